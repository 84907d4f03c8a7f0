// SPDX-License-Identifier: Apache-2.0
// Actions of a program that the chip's manual forbids, or that the emulator does not model: each makes a test fail.
#ifndef TRACKSERVO_SIM_EMULATOR_CORE_VIOLATIONS_HPP
#define TRACKSERVO_SIM_EMULATOR_CORE_VIOLATIONS_HPP

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <string>
#include <utility>
#include <vector>

namespace trackservo::target {

class Violations {
 public:
  // Adds a sentence; the same one counts once. `block_address()` is the address of the program, rounded to the start of
  // its basic block.
  void add(const std::string& sentence) {
    if (std::none_of(list_.begin(), list_.end(),
                     [&](const std::string& known) { return known.rfind(sentence + " [", 0) == 0; }) &&
        list_.size() < kMax) {
      list_.push_back(fmt::format("{} [block 0x{:08x}]", sentence, block_address_));
    }
  }

  void at_block(std::uint32_t address) { block_address_ = address; }
  std::uint32_t block_address() const { return block_address_; }

  const std::vector<std::string>& list() const { return list_; }
  void clear() { list_.clear(); }

 private:
  static constexpr std::size_t kMax = 50;

  std::vector<std::string> list_;
  std::uint32_t block_address_ = 0;
};

}  // namespace trackservo::target

#endif
