// SPDX-License-Identifier: Apache-2.0
// Where the image keeps its variables: offsets from board_layout.c, addresses from the symbols of its ELF file.
#ifndef TRACKSERVO_TARGET_IMAGE_LAYOUT_HPP
#define TRACKSERVO_TARGET_IMAGE_LAYOUT_HPP

#include <cstdint>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <optional>
#include <stdexcept>
#include <string>
#include <vector>

#include "hal.h"

namespace bench {

// See board_layout.c.
struct Layout {
  std::uint32_t hal_bytes, context, period, service_under_way, current_a, bus_voltage_v, samples, samples_bytes, motor,
      motor_bytes, motor_voltage_v, node_safety_bytes;
};

inline Layout read_layout() {
  const char *name = std::getenv("TARGET_LAYOUT");
  std::ifstream file(name != nullptr ? name : "", std::ios::binary);
  Layout layout{};
  if (!file.read(reinterpret_cast<char *>(&layout), sizeof layout) || file.peek() != EOF) {
    throw std::runtime_error("no layout of the board's variables; is TARGET_LAYOUT set?");
  }
  if (layout.samples_bytes != sizeof(hal_axis_samples)) {
    throw std::runtime_error("hal_axis_samples has another layout on the chip than here");
  }
  return layout;
}

// The symbol of this name, and of this size if one is given (ELF-32: header, section headers, symbols).
inline std::uint32_t address_of(const std::string& wanted, std::optional<std::uint32_t> size = std::nullopt) {
  const std::filesystem::path elf = std::filesystem::path(std::getenv("TARGET_IMAGE")).replace_extension(".elf");
  std::ifstream file(elf, std::ios::binary);
  const std::vector<char> bytes((std::istreambuf_iterator<char>(file)), std::istreambuf_iterator<char>());
  const auto word = [&bytes](std::size_t at) {
    std::uint32_t value = 0;
    std::memcpy(&value, &bytes.at(at + 3) - 3, sizeof value);
    return value;
  };
  constexpr std::uint32_t kSymbolTable = 2;
  constexpr std::size_t kSectionBytes = 40;
  constexpr std::size_t kSymbolBytes = 16;
  const std::size_t sections = word(0x20);
  for (std::size_t n = 0; n < (word(0x30) & 0xFFFFU); ++n) {
    const std::size_t section = sections + n * kSectionBytes;
    const std::size_t names = word(sections + word(section + 0x18) * kSectionBytes + 0x10);
    for (std::size_t at = 0; word(section + 4) == kSymbolTable && at < word(section + 0x14); at += kSymbolBytes) {
      const std::size_t symbol = word(section + 0x10) + at;
      if (wanted == &bytes.at(names + word(symbol)) && (!size || word(symbol + 8) == *size)) {
        return word(symbol + 4);
      }
    }
  }
  throw std::runtime_error(elf.string() + " has no symbol " + wanted + " of this size; build image and test anew");
}

}  // namespace bench

#endif
