// SPDX-License-Identifier: Apache-2.0
#include "board/board_device.hpp"

#include <fmt/format.h>

#include <cstddef>
#include <cstring>
#include <fstream>
#include <iterator>
#include <stdexcept>
#include <string_view>

#include "version_block.h"

namespace trackservo::target {
namespace {

constexpr std::string_view kBoard = "nucleo_g474";

std::uint32_t word(const Image& image, std::size_t at) {
  return image[at] | static_cast<std::uint32_t>(image[at + 1]) << 8 | static_cast<std::uint32_t>(image[at + 2]) << 16 |
         static_cast<std::uint32_t>(image[at + 3]) << 24;
}

// The vector table begins an image: a stack in RAM, and a reset handler in the flash (with the bit for Thumb code).
bool is_for_this_chip(const Image& image) {
  constexpr std::size_t kVectors = 8;
  if (image.size() < kVectors) {
    return false;
  }
  const std::uint32_t stack = word(image, 0);
  const std::uint32_t reset = word(image, 4);
  const bool in_ram = (stack > 0x20000000 && stack <= 0x20020000) || (stack > 0x10000000 && stack <= 0x10008000);
  return in_ram && reset % 2 == 1 && reset > 0x08000000 && reset < 0x08000000 + image.size();
}

// Returns the board that the image's version block names; empty when there is no block, or none of today's.
std::string board_of(const Image& image) {
  constexpr std::size_t kBlock = 0x200;
  if (image.size() < kBlock + sizeof(version_block) || word(image, kBlock) != VERSION_BLOCK_MAGIC) {
    return "";
  }
  const auto *const name = reinterpret_cast<const char *>(&image[kBlock + offsetof(version_block, board)]);
  return {name, strnlen(name, VERSION_BOARD_BYTES)};
}

constexpr int kBoot_ms = 320;
// From the node's tick to the set-points: they need 0.13 ms, and have arrived before the tick that takes them. A
// set-point that comes 0.9 ms later costs 1 mdeg/s of a sine's rms error.
constexpr double kSetPointPhase_s = 0.8e-3;

}  // namespace

bool BoardDevice::settle() {
  for (int ms = 0; ms < kBoot_ms; ++ms) {
    pass_ms();
  }
  return machine_.run_after_tick(kSetPointPhase_s);
}

std::optional<std::string> BoardDevice::defect() const {
  if (machine_.chip().resets() > 0) {
    return "the board has reset";
  }
  const std::vector<std::string>& violations = machine_.chip().violations.list();
  return violations.empty() ? std::nullopt : std::optional("violation of the chip's rules: " + violations.front());
}

Image read_image(const std::filesystem::path& file) {
  std::ifstream stream(file, std::ios::binary);
  Image image((std::istreambuf_iterator<char>(stream)), std::istreambuf_iterator<char>());
  if (!is_for_this_chip(image)) {
    throw std::runtime_error(fmt::format(
        "{}: is no image of this board, or cannot be read; give build/stm32g474/bin/trackservo.bin", file.string()));
  }
  if (const std::string board = board_of(image); !board.empty() && board != kBoard) {
    throw std::runtime_error(
        fmt::format("{}: is an image of the board {}; the emulated one is {}", file.string(), board, kBoard));
  }
  return image;
}

}  // namespace trackservo::target
