// SPDX-License-Identifier: Apache-2.0
// The flash's wait states behind its instruction cache and prefetch (STM32G4: 32 lines of 32 bytes, read by 8 bytes).
//
// A line that is in the cache costs nothing. Other lines are read at one word of 8 bytes per (wait states + 1) cycles
// while the core executes the words that have arrived, so a block takes the longer of both. When it does not follow in
// sequence, or without prefetch, the wait states of its first word are added. The oldest line is replaced.
#ifndef TRACKSERVO_SIM_EMULATOR_CORE_FLASH_ACCELERATOR_HPP
#define TRACKSERVO_SIM_EMULATOR_CORE_FLASH_ACCELERATOR_HPP

#include <algorithm>
#include <array>
#include <cstdint>

namespace trackservo::target {

class FlashAccelerator {
 public:
  FlashAccelerator() {
    for (std::uint8_t slot = 0; slot <= kLines; ++slot) {
      after_[slot] = static_cast<std::uint8_t>(slot == kLines ? 0 : slot + 1);
      before_[slot] = static_cast<std::uint8_t>(slot == 0 ? kLines : slot - 1);
    }
  }

  void configure(std::uint32_t wait_states, bool cache, bool prefetch) {
    wait_states_ = wait_states;
    cache_ = cache;
    prefetch_ = prefetch;
    tags_.fill(kEmpty);
  }

  // Returns the cycles lost when code of `size` bytes (at least 1) is fetched from `offset` into the flash and executed
  // in `execution` cycles. `follows_on`: the code before it was in sequence.
  std::uint32_t fetch(std::uint32_t offset, std::uint32_t size, std::uint32_t execution, bool follows_on) {
    if (wait_states_ == 0) {
      return 0;
    }
    std::uint32_t words = 0;
    const std::uint32_t end = offset + size;
    for (std::uint32_t line = offset / kLineBytes; line <= (end - 1) / kLineBytes; ++line) {
      if (!cache_ || !holds(line)) {
        const std::uint32_t first = std::max(offset, line * kLineBytes) / kWordBytes;
        const std::uint32_t last = (std::min(end, (line + 1) * kLineBytes) - 1) / kWordBytes;
        words += last - first + 1;
      }
    }
    if (words == 0) {
      return 0;
    }
    const std::uint32_t reading = words * (wait_states_ + 1);
    const std::uint32_t hidden = prefetch_ ? execution : words;
    return (reading > hidden ? reading - hidden : 0) + (follows_on && prefetch_ ? 0 : wait_states_);
  }

 private:
  static constexpr std::uint32_t kLineBytes = 32;
  static constexpr std::uint32_t kWordBytes = 8;
  static constexpr std::uint32_t kLines = 32;
  static constexpr std::uint32_t kFlashLines = 512 * 1024 / kLineBytes;
  static constexpr std::uint32_t kEmpty = UINT32_MAX;
  static constexpr std::uint8_t kHead = kLines;

  // Returns whether the line is in the cache; afterwards it is. `where_` has its last slot.
  bool holds(std::uint32_t line) {
    std::uint8_t& slot = where_[line % kFlashLines];
    const bool hit = tags_[slot] == line;
    if (!hit) {
      slot = before_[kHead];
      tags_[slot] = line;
    }
    use(slot);
    return hit;
  }

  // Moves a slot to the front of the ring of slots, which begins after kHead with the last used one.
  void use(std::uint8_t slot) {
    after_[before_[slot]] = after_[slot];
    before_[after_[slot]] = before_[slot];
    after_[slot] = after_[kHead];
    before_[slot] = kHead;
    before_[after_[slot]] = slot;
    after_[kHead] = slot;
  }

  std::uint32_t wait_states_ = 0;
  bool cache_ = false;
  bool prefetch_ = false;
  std::array<std::uint32_t, kLines> tags_{};
  std::array<std::uint8_t, kLines + 1> after_{};
  std::array<std::uint8_t, kLines + 1> before_{};
  std::array<std::uint8_t, kFlashLines> where_{};
};

}  // namespace trackservo::target

#endif
