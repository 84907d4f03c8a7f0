// SPDX-License-Identifier: Apache-2.0
// One simulated tracker with the firmware on it: the host end of the HAL.
//
// The firmware's functions run in the board's order: PWM period 0, the tick, PWM periods 1 to 19. The firmware's motor
// stage delays what the tick commands; here only a duty is delayed: it counts from the period after the one in which
// its current was sampled.
#ifndef TRACKSERVO_SIM_RUN_MACHINE_HPP
#define TRACKSERVO_SIM_RUN_MACHINE_HPP

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "machine/base/firmware.hpp"
#include "machine/plant/tracker.hpp"
#include "machine/run/bad_sensors.hpp"
#include "machine/run/broken_parts.hpp"

namespace trackservo::sim {

struct MachineHal;

class Machine {
 public:
  // Makes a machine with the servo of the firmware alone, without drive and node. Throws std::invalid_argument when it
  // refuses the parameters.
  Machine(const PlantConfig& plant, const servo_params& params, std::uint64_t seed,
          const std::array<double, kAxes>& joint_angle_rad);

  // Makes a machine without firmware; `run_firmware` gives it one with another owner.
  Machine(const PlantConfig& plant, std::uint64_t seed, const std::array<double, kAxes>& joint_angle_rad);

  Machine(const Machine&) = delete;
  Machine& operator=(const Machine&) = delete;

  // Returns the HAL's end of this machine, for starting a firmware on it.
  hal *hal_pointer() { return &hal_; }

  // Makes `tick` the firmware's 1 ms tick from now on; `board` has the motor stages that the PWM periods run. Both must
  // outlive the machine.
  void run_firmware(servo_board& board, std::function<void()> tick) {
    board_ = &board;
    tick_ = std::move(tick);
  }

  // Replaces the 1 ms tick of the servo, which is servo_board_tick.
  void on_tick(std::function<void(servo_board& board)> tick) {
    tick_ = [this, tick = std::move(tick)] { tick(*board_); };
  }
  servo_board& board() { return *board_; }

  // Adds the holding brakes of the plant file, which hold while the bridge of their axis is off. Only before the first
  // tick.
  void fit_holding_brakes() { tracker_.fit_holding_brakes(); }

  // Returns the command of the axes; takes effect at the next tick.
  servo_command& command() { return board_->command; }

  // Begins an exposure of the camera: a rising edge of its strobe, between two ticks.
  void strobe() { strobes_.push_back(clock_us()); }

  // Returns the firmware's clock (hal_clock_us): as fine as its ticks.
  std::uint32_t clock_us() const { return clock_us_; }

  // Sets extra torque behind the controller, for loads and frequency responses [Nm]; held until set again. It is added
  // to the set-point of the current loop, from the PWM period on in which the next tick's set-points count: what the
  // current loop reads is less by it. The firmware's mean current has it, its torque command has not.
  void inject_torque(int axis, double torque_nm) { injected_nm_[static_cast<std::size_t>(axis)] = torque_nm; }

  // Returns the faults that are injected from the next tick on.
  BrokenParts& broken() { return broken_; }

  // Runs the firmware's tick and then the machine to the end of the millisecond.
  void advance_tick();

  // Runs one PWM period; the first of a millisecond has the firmware's tick in it.
  void advance_period();

  // Returns the bridge in the coming PWM period: its duty, and whether it drives the motor.
  double duty(int axis) const { return duty_[static_cast<std::size_t>(axis)]; }
  bool bridge_on(int axis) const { return !tracker_.terminals_are_open(axis); }

  TruthState truth() const { return tracker_.truth(); }
  const servo_samples& samples() const { return board_->samples; }
  const servo_axis& firmware(int axis) const { return board_->app.axis[axis]; }
  double injected_nm(int axis) const { return injected_nm_[static_cast<std::size_t>(axis)]; }

 private:
  friend struct MachineHal;
  static hal hal_of(Machine *machine);
  void break_parts();
  void run_clock();
  void convert(std::uint32_t period);
  void begin_injection();

  Tracker tracker_;
  hal hal_;
  servo_board own_board_{};
  servo_board *board_ = &own_board_;
  std::function<void()> tick_ = [this] { servo_board_tick(board_); };
  TickSamples samples_{};
  double bus_voltage_v_ = 0;  // both axes share one conversion per period
  std::uint32_t period_ = 0;  // the coming PWM period of the tick
  std::array<double, kAxes> current_sum_a_{};
  std::array<double, kAxes> mean_current_a_{};
  std::array<double, kAxes> duty_{};       // in force
  std::array<double, kAxes> next_duty_{};  // from the next period on
  std::array<double, kAxes> injected_nm_{};
  std::array<double, kAxes> injected_a_{};  // in force
  std::vector<std::uint32_t> strobes_;
  std::uint32_t clock_us_ = 0;  // at the next tick; within it, and in its deferred task, at its beginning
  BrokenParts broken_;
  std::array<BadSensors, kAxes> bad_sensors_;
  std::array<BadConverter, kAxes> bad_currents_;
  BadConverter bad_bus_;
  double clock_periods_ = 0;  // that the plant is ahead of the firmware's clock
  int clock_wrong_ticks_ = 0;
  std::array<double, kAxes> reported_current_a_{};  // the last reading, for a sensor that is stuck
  // The scales that the firmware assumes for the converters; wrong scales give wrong readings.
  AdcConfig adc_;
  std::array<double, kAxes> current_share_{1.0, 1.0};
  std::array<double, kAxes> over_current_a_{};  // 0: the end of the range, used by fault injection
  double voltage_share_ = 1.0;
  std::array<bool, kAxes> tripped_{};
};

}  // namespace trackservo::sim

#endif
