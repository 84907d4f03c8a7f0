// SPDX-License-Identifier: Apache-2.0
// Which exception of a Cortex-M4 runs and which waits (ARMv7-M architecture manual, B1.5): pending, enabled and active
// bits, priorities of four bits with grouping, level-sensitive interrupt lines. It decides; CortexM4 acts.
//
// Numbers are the architecture's: 2 NMI, 3 HardFault, 4 MemManage, 5 BusFault, 6 UsageFault, 11 SVCall, 14 PendSV,
// 15 SysTick, 16 + n interrupt n.
#ifndef TRACKSERVO_SIM_EMULATOR_CORE_EXCEPTIONS_HPP
#define TRACKSERVO_SIM_EMULATOR_CORE_EXCEPTIONS_HPP

#include <array>
#include <bitset>
#include <cstddef>
#include <cstdint>
#include <vector>

namespace trackservo::target {

enum Exception : int {
  kThread = 0,
  kNmi = 2,
  kHardFault = 3,
  kMemManage = 4,
  kBusFault = 5,
  kUsageFault = 6,
  kSvcall = 11,
  kPendSv = 14,
  kSysTick = 15,
  kFirstInterrupt = 16,
};

class Exceptions {
 public:
  static constexpr int kInterrupts = 102;  // of the STM32G474
  static constexpr int kCount = kFirstInterrupt + kInterrupts;
  static constexpr int kLowest = 256;  // execution priority of thread mode without masks

  Exceptions() { reset(); }

  void reset();

  void pend(int exception) { set(pending_, exception, true); }
  void unpend(int exception) { set(pending_, exception, false); }
  bool is_pending(int exception) const { return pending_[index(exception)]; }

  // Enables or disables an interrupt; system exceptions are always enabled, configurable faults by SHCSR where they are
  // raised.
  void enable(int exception, bool enabled) { set(enabled_, exception, enabled); }
  bool is_enabled(int exception) const { return enabled_[index(exception)]; }

  bool is_active(int exception) const { return active_[index(exception)]; }

  // Sets the priority: 0 (first) .. 255, low four bits not implemented.
  void set_priority(int exception, std::uint8_t priority);
  std::uint8_t priority(int exception) const { return priority_[index(exception)]; }
  void set_priority_grouping(unsigned prigroup);
  unsigned priority_grouping() const { return prigroup_; }

  // Takes a peripheral's request. Lines with several sources are counted. A line that is still high when its handler
  // returns becomes pending again.
  void raise_line(int interrupt);
  void lower_line(int interrupt);

  // Returns the exception that would run next, or kThread.
  int next() const { return next_; }

  // Returns whether an exception waits that active exceptions alone would allow.
  bool wants_attention() const { return attention_; }

  // Returns the same under the masks; BASEPRI 0 masks nothing.
  bool can_run(int exception, bool primask, bool faultmask, std::uint8_t basepri) const;

  int execution_priority(bool primask, bool faultmask, std::uint8_t basepri) const;
  int group_priority(int exception) const;

  void enter(int exception);
  void leave(int exception);
  int running() const { return nesting_.empty() ? static_cast<int>(kThread) : nesting_.back(); }
  int nesting() const { return static_cast<int>(nesting_.size()); }

 private:
  using Bits = std::bitset<static_cast<std::size_t>(kCount)>;

  static std::size_t index(int exception) { return static_cast<std::size_t>(exception); }
  void set(Bits& bits, int exception, bool value);
  int active_priority() const;
  void decide();

  Bits pending_, enabled_, active_;
  std::array<std::uint8_t, static_cast<std::size_t>(kCount)> priority_{};
  std::array<int, static_cast<std::size_t>(kCount)> line_{};
  std::vector<int> nesting_;
  unsigned prigroup_ = 0;
  int next_ = kThread;
  bool attention_ = false;
};

}  // namespace trackservo::target

#endif
