// SPDX-License-Identifier: Apache-2.0
// Simulated time and its alarms.
//
// Time counts in 1/4.08 GHz, in which every clock of the board has a whole period: 24 units at 170 MHz, 170 at 24 MHz,
// 255 at 16 MHz, 127,500 at 32 kHz. An alarm is a repeated event (a timer's next edge, the end of a conversion).
//
// Use: set alarms, move `now` on, run_due() whenever next_due() has passed.
#ifndef TRACKSERVO_SIM_EMULATOR_CORE_TIMELINE_HPP
#define TRACKSERVO_SIM_EMULATOR_CORE_TIMELINE_HPP

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <utility>
#include <vector>

namespace trackservo::target {

using Instant = std::uint64_t;  // [1/4.08 GHz], also for durations

constexpr Instant kUnitsPerSecond = 4'080'000'000;
constexpr Instant kUnitsPerMicrosecond = 4'080;

constexpr Instant period_of(std::uint32_t frequency_hz) { return kUnitsPerSecond / frequency_hz; }
constexpr double seconds_of(Instant duration) {
  return static_cast<double>(duration) / static_cast<double>(kUnitsPerSecond);
}
constexpr Instant duration_of(double seconds) {
  // NOLINTNEXTLINE(bugprone-incorrect-roundings): std::lround is not constexpr; durations are not negative.
  return static_cast<Instant>(seconds * static_cast<double>(kUnitsPerSecond) + 0.5);
}

class Timeline {
 public:
  using Alarm = std::size_t;
  static constexpr Instant kNever = UINT64_MAX;

  Timeline() = default;
  Timeline(const Timeline&) = delete;
  Timeline& operator=(const Timeline&) = delete;

  // Adds an alarm. `action` runs in run_due(), with the alarm already off; now() may be a little later than the set
  // time.
  Alarm add(std::function<void()> action) {
    actions_.push_back({kNever, std::move(action)});
    return actions_.size() - 1;
  }

  void set(Alarm alarm, Instant due) {
    actions_[alarm].due = due;
    next_due_ = due < next_due_ ? due : earliest();
  }
  void cancel(Alarm alarm) { set(alarm, kNever); }
  Instant due(Alarm alarm) const { return actions_[alarm].due; }

  Instant now() const { return now_; }
  Instant next_due() const { return next_due_; }
  void advance(Instant duration) { now_ += duration; }

  // Returns the set time of the running alarm, otherwise now(): later times are computed from here, so that nothing
  // drifts.
  Instant instant() const { return running_ ? due_now_ : now_; }

  // Runs everything that is due, earliest first.
  void run_due() {
    while (next_due_ <= now_) {
      const auto first = std::min_element(actions_.begin(), actions_.end(),
                                          [](const Action& left, const Action& right) { return left.due < right.due; });
      due_now_ = first->due;
      first->due = kNever;
      next_due_ = earliest();
      running_ = true;
      first->action();
      running_ = false;
    }
  }

 private:
  struct Action {
    Instant due;
    std::function<void()> action;
  };

  Instant earliest() const {
    Instant earliest = kNever;
    for (const Action& action : actions_) {
      earliest = std::min(earliest, action.due);
    }
    return earliest;
  }

  std::vector<Action> actions_;
  Instant now_ = 0;
  Instant next_due_ = kNever;
  Instant due_now_ = 0;
  bool running_ = false;
};

}  // namespace trackservo::target

#endif
