// SPDX-License-Identifier: Apache-2.0
// The servo board with a machine on it: the chip runs an image, its PWM drives the simulator's plant, the plant's
// sensors feed ADC, SPI and UART, and CAN is an end of a virtual bus.
//
// The plant moves in whole PWM periods. A period ends when the ADCs are triggered (or 50 us after the last one while
// they are not). Then the plant moves under the mean duty of that period, and the ADCs sample the currents at its end.
// A bridge that is off at the end of a period leaves the motor's terminals open during it.
#ifndef TRACKSERVO_SIM_EMULATOR_BOARD_BOARD_MACHINE_HPP
#define TRACKSERVO_SIM_EMULATOR_BOARD_BOARD_MACHINE_HPP

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "board/biss_encoder.hpp"
#include "board/can_line.hpp"
#include "board/fibre_gyro.hpp"
#include "chip/stm32g474.hpp"
#include "machine/plant/tracker.hpp"

namespace trackservo::target {

class BoardMachine {
 public:
  struct Options {
    std::uint64_t seed = 1;
    std::array<double, sim::kAxes> joint_angle_rad{};
    // PWM periods after the control task's tick at which the gyros sample their rate; 0.39 ms later it has arrived.
    int gyro_phase = 11;
    bool holding_brakes = false;  // of the plant file, if it has some
  };

  // Switches the power on. `bus` must exist longer than the machine.
  BoardMachine(const std::vector<std::uint8_t>& image, const sim::PlantConfig& plant, sim::VirtualBus& bus,
               const Options& options);

  void run(double seconds) { chip_.run(duration_of(seconds)); }
  // Runs until `after_s` after the next tick of the control task. How long an image takes to start depends on its size;
  // what is then sent every millisecond arrives in the same phase, whatever the image. Returns false without a tick
  // within 10 ms: the task does not run.
  [[nodiscard]] bool run_after_tick(double after_s);
  double time_s() const { return seconds_of(chip_.timeline.now()); }

  Stm32g474& chip() { return chip_; }
  const Stm32g474& chip() const { return chip_; }
  BissEncoder& encoder(int axis) { return encoder_[static_cast<std::size_t>(axis)]; }
  FibreGyro& gyro(int axis) { return gyro_[static_cast<std::size_t>(axis)]; }
  sim::TruthState truth() const { return tracker_.truth(); }

  // Returns the ticks of the control task since power-on, counted 22 us before each begins.
  std::uint64_t ticks() const { return ticks_; }

  // Sets what is called once per ms: 22 us before the tick of the control task, from the first one on.
  void on_tick(std::function<void()> listener) { tick_listener_ = std::move(listener); }

  // Sets the current that flows through the sensor and not through the motor: a short behind it.
  void set_short_current(int axis, double current_a) { short_current_a_[static_cast<std::size_t>(axis)] = current_a; }

  // Lets the converter of a current repeat its last reading, whatever flows.
  void stick_current(int axis, bool stuck) {
    const std::size_t i = static_cast<std::size_t>(axis);
    stuck_current_a_[i] = stuck ? std::optional<double>(current_a_[i]) : std::nullopt;
  }

  // Sets the voltage at the divider of the bus, whatever the plant's supply does; none: the plant's.
  void set_bus_voltage(std::optional<double> voltage_v) { forced_bus_v_ = voltage_v; }

  // Sets a driver's fault output, low while active.
  void set_driver_fault(int axis, bool fault);

  // Raises the camera's strobe, at PC12; it falls again at once.
  void strobe() { chip_.tim5.rise(); }

  // A channel of STO at the board's terminals: false removes the torque. The input circuit follows a change that lasts
  // longer than kStoDelay.
  enum class StoChannel { kA, kB };
  static constexpr Instant kStoDelay = Instant{3'000} * kUnitsPerMicrosecond;
  void set_sto(StoChannel channel, bool permits);

  // Keeps a wire between the gate of channel A and the driver of an axis, or its read-back, at this level; none:
  // intact.
  void stick_driver_enable(int axis, std::optional<bool> level) {
    stuck_enable_[static_cast<std::size_t>(axis)] = level;
    update_inputs();
  }

  // Sets what a brake's contact reports, whatever the brake does; none: intact.
  void stick_brake_contact(int axis, std::optional<bool> released) {
    stuck_contact_[static_cast<std::size_t>(axis)] = released;
  }
  bool is_brake_powered(int axis);

  // Returns whether the gate driver is enabled and the timer gives it signals.
  bool is_bridge_on(int axis);
  // Returns whether neither bridge is on: the required state after every reset and fault.
  bool is_safe() { return !is_bridge_on(0) && !is_bridge_on(1); }

  double duty(int axis) const { return duty_[static_cast<std::size_t>(axis)]; }

 private:
  struct BridgePins;

  void step(Instant at);
  void step_if_due();
  double take_duty(int axis);
  double read_current_a(std::size_t axis) const;
  std::uint32_t adc_counts(int converter, unsigned channel);
  void update_inputs();
  void follow_sto();
  bool is_driver_enabled(int axis);
  void check_pin_is_analog(char port, unsigned pin);

  sim::VirtualBus& bus_;
  sim::Tracker tracker_;
  sim::AdcConfig adc_;
  Stm32g474 chip_;
  CanLine can_;
  std::array<BissEncoder, sim::kAxes> encoder_;
  std::array<FibreGyro, sim::kAxes> gyro_;
  int gyro_phase_;
  Timeline::Alarm late_step_;
  Instant stepped_at_ = 0;
  int step_in_tick_ = 0;  // PWM periods since the last tick of the control task, which TIM6 requests in period 0
  bool ticking_ = false;
  std::uint64_t ticks_ = 0;
  std::array<bool, sim::kAxes> driver_fault_{};
  struct Sto {
    bool terminal = true;
    bool pin = true;  // behind the input circuit
    Instant due = Timeline::kNever;
  };
  std::array<Sto, 2> sto_;
  Timeline::Alarm sto_alarm_;
  std::array<std::optional<bool>, sim::kAxes> stuck_enable_;
  std::array<std::optional<bool>, sim::kAxes> stuck_contact_;
  std::array<double, sim::kAxes> duty_{};
  std::array<double, sim::kAxes> current_a_{};
  std::array<double, sim::kAxes> short_current_a_{};
  std::array<std::optional<double>, sim::kAxes> stuck_current_a_;
  double bus_voltage_v_ = 0;
  std::optional<double> forced_bus_v_;
  std::function<void()> tick_listener_;
};

}  // namespace trackservo::target

#endif
