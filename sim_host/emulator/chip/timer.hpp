// SPDX-License-Identifier: Apache-2.0
// An advanced timer (TIM1, TIM8: RM0440, 28) or a basic one (TIM6: RM0440, 31), as far as the board uses them: counting
// up or centre-aligned, repetition, preload, complementary outputs with dead time and break, start by another timer,
// trigger outputs. A write that would let both switches of a leg conduct is a violation.
#ifndef TRACKSERVO_SIM_EMULATOR_CHIP_TIMER_HPP
#define TRACKSERVO_SIM_EMULATOR_CHIP_TIMER_HPP

#include <array>
#include <functional>
#include <optional>

#include "core/peripheral.hpp"

namespace trackservo::target {

class Timer : public Peripheral {
 public:
  struct Interrupts {
    int update;
    int brake;  // -1: none
  };
  static constexpr std::size_t kLegs = 2;

  Timer(Services services, const char *name, Interrupts interrupts, bool advanced);

  // Sets the source of the kernel clock's period, read when the counter starts.
  void clocked_at(std::function<std::uint32_t()> frequency_hz) { frequency_hz_ = std::move(frequency_hz); }

  // Sets what is called when the first or second trigger output pulses.
  void on_trigger(std::function<void(bool second)> listener) { triggered_ = std::move(listener); }

  // Sets how this timer starts another: the action of the slave when the master's counter is switched on.
  void on_enable(std::function<void()> listener) { enabled_ = std::move(listener); }
  void started_by_master();

  // Sets the level at the break input; low is a fault when BKP is 0.
  void set_break_input(bool level);

  // Sets the level at the second break input; low is a fault when BK2P is 0.
  void set_second_break_input(bool level);

  // Sets a fault of the system (parity of the RAM, lock-up) at the break input; no polarity, no filter.
  void set_system_break(bool active);

  // Returns the mean of leg 0 or 1 (channels 1 and 2) over the time since the last call: share of the period for which
  // its high side conducts; nothing for a leg that is or was not driven all the time.
  std::array<std::optional<double>, kLegs> take_mean_legs();

  // Returns whether it is centre-aligned and in the half of the period around counter 0, where high sides conduct.
  bool is_around_zero() const { return is_centred() && counter() < limit_ / 2; }

  bool is_running() const { return (reg(0x00) & 1U) != 0; }
  bool is_main_output_enabled() const { return advanced_ && (reg(0x44) & 1U << 15) != 0; }

  // Sets what is called after every change of the main output enable.
  void monitor_outputs(std::function<void()> monitor) { output_monitor_ = std::move(monitor); }

  // Returns the PWM period, or the time between updates of a basic timer [1/4.08 GHz].
  Instant period() const { return (is_centred() ? 2 * limit_ : limit_ + 1) * count_; }

  // Cancels the next edge, so that there are no more; for a missing tick.
  void stall() { timeline().cancel(edge_); }

  // Delays the next edge and all later ones by `delay`; for a misplaced tick.
  void slip(Instant delay);

 protected:
  std::uint32_t on_read(std::uint32_t offset, std::uint32_t stored, unsigned width) override;
  void on_write(std::uint32_t offset, std::uint32_t written, unsigned width) override;
  void on_reset() override;

 private:
  static std::vector<Register> registers(bool advanced);

  bool is_centred() const { return (reg(0x00) >> 5 & 3U) != 0; }
  bool counts_down_now() const { return down_; }
  std::uint32_t counter() const;
  void start();
  void stop();
  void edge();
  void update(bool by_software);
  void load_preload();
  void schedule_compare();
  void compare_pulse();
  void trigger(unsigned source);
  void write_cr1(std::uint32_t written);
  void write_bdtr(std::uint32_t written);
  void write_compare(std::uint32_t offset, std::uint32_t written);
  void check_lock(std::uint32_t offset, std::uint32_t written) const;
  void check_legs();
  bool is_break_active() const;
  bool is_second_break_active() const;
  void take_active_breaks();
  void take_break(std::uint32_t flag);
  bool is_leg_driven(std::size_t leg) const;
  void integrate();
  void refresh_interrupts();
  void outputs_changed();

  bool advanced_;
  IrqLine update_line_;
  std::optional<IrqLine> break_line_;
  std::function<std::uint32_t()> frequency_hz_;
  std::function<void(bool)> triggered_;
  std::function<void()> enabled_;
  std::function<void()> output_monitor_;
  Timeline::Alarm edge_;
  Timeline::Alarm compare_;

  Instant count_ = 24;                            // one count of the prescaled clock
  std::uint32_t prescale_ = 0;                    // in force
  std::uint32_t limit_ = 0xFFFF;                  // auto-reload in effect
  std::array<std::uint32_t, 6> compare_value_{};  // in force
  std::uint32_t repetitions_left_ = 0;
  bool down_ = false;
  Instant edge_at_ = 0;  // when the counter last was at 0 or, counting down, at its limit
  std::uint32_t stopped_at_ = 0;
  bool break_input_ = true;
  bool second_break_input_ = true;
  bool system_break_ = false;

  Instant integrated_to_ = 0;
  Instant integrated_from_ = 0;
  std::array<double, kLegs> conducted_{};
  std::array<bool, kLegs> driven_{};
};

}  // namespace trackservo::target

#endif
