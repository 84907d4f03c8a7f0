// The flash's wait states behind its instruction cache and prefetch (STM32G4: 32 lines of 32 bytes).
//
// A line that is in the cache costs nothing. One that is not costs the wait states once for its first eight bytes, and,
// with prefetch, what the next words need longer than the core (two cycles at four wait states) for the other three;
// without prefetch the wait states for each. The oldest line makes room.
#ifndef TRACKSERVO_TARGET_CORE_FLASH_ACCELERATOR_HPP
#define TRACKSERVO_TARGET_CORE_FLASH_ACCELERATOR_HPP

#include <array>
#include <cstdint>

namespace trackservo::target {

class FlashAccelerator {
 public:
  void configure(std::uint32_t wait_states, bool cache, bool prefetch) {
    wait_states_ = wait_states;
    cache_ = cache;
    const std::uint32_t following = wait_states > 2 ? wait_states - 2 : 0;
    miss_cycles_ = wait_states + 3 * (prefetch ? following : wait_states);
    tags_.fill(kEmpty);
  }

  // Cycles lost when code of `size` bytes (at least 1) is fetched from `offset` into the flash.
  std::uint32_t fetch(std::uint32_t offset, std::uint32_t size) {
    if (wait_states_ == 0) {
      return 0;
    }
    std::uint32_t lost = 0;
    for (std::uint32_t line = offset / kLineBytes; line <= (offset + size - 1) / kLineBytes; ++line) {
      if (!cache_ || !holds(line)) {
        lost += miss_cycles_;
      }
    }
    return lost;
  }

 private:
  static constexpr std::uint32_t kLineBytes = 32;
  static constexpr std::uint32_t kLines = 32;
  static constexpr std::uint32_t kFlashLines = 512 * 1024 / kLineBytes;
  static constexpr std::uint32_t kEmpty = UINT32_MAX;

  // Whether the line is there; from now on it is. `where_` tells in which slot it was last.
  bool holds(std::uint32_t line) {
    std::uint8_t& slot = where_[line % kFlashLines];
    const bool hit = tags_[slot] == line;
    if (!hit) {
      slot = oldest();
      tags_[slot] = line;
    }
    used_[slot] = ++clock_;
    return hit;
  }

  std::uint8_t oldest() const {
    std::uint8_t oldest = 0;
    for (std::uint8_t slot = 1; slot < kLines; ++slot) {
      if (used_[slot] < used_[oldest]) {
        oldest = slot;
      }
    }
    return oldest;
  }

  std::uint32_t wait_states_ = 0;
  std::uint32_t miss_cycles_ = 0;
  bool cache_ = false;
  std::array<std::uint32_t, kLines> tags_{};
  std::array<std::uint64_t, kLines> used_{};
  std::array<std::uint8_t, kFlashLines> where_{};
  std::uint64_t clock_ = 0;
};

}  // namespace trackservo::target

#endif
