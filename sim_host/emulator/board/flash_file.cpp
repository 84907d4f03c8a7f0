// SPDX-License-Identifier: Apache-2.0
#include "board/flash_file.hpp"

#include <algorithm>
#include <array>
#include <stdexcept>

namespace trackservo::target {
namespace {

constexpr std::size_t kPieces = sim::FlashMemory::kAreas + 1;
constexpr std::uint32_t kPageBytes = sim::FlashMemory::kPageBytes;
constexpr std::uint32_t kBusBytes = sim::FlashMemory::kBusPages * kPageBytes;
constexpr std::uint32_t kAreaBytes = sim::FlashMemory::kPages * kPageBytes;

// The board has the pages for node id and bit rate first (hal/chips/stm32g4/parameter_flash.h).
constexpr std::array<std::uint32_t, kPieces> kOnBoard = {kBusBytes, kBusBytes + kAreaBytes, 0};

std::array<const hal_flash *, kPieces> pieces_of(const sim::FlashMemory& file) {
  return {file.areas(), file.areas() + 1, file.bus_pages()};
}

bool keep_unit(const hal_flash *flash, std::uint32_t offset, const std::uint8_t *bytes) {
  if (std::all_of(bytes, bytes + HAL_FLASH_UNIT_BYTES, [](std::uint8_t byte) { return byte == 0xFF; })) {
    return true;
  }
  std::array<std::uint32_t, 2> double_word{};
  std::copy_n(bytes, HAL_FLASH_UNIT_BYTES, reinterpret_cast<std::uint8_t *>(double_word.data()));
  return flash->program(flash, offset, double_word.data());
}

bool keep_piece(const hal_flash *flash, const std::uint8_t *bytes) {
  bool kept = true;
  for (std::uint32_t page = 0; page < flash->pages; ++page) {
    kept = flash->erase(flash, page) && kept;
  }
  for (std::uint32_t offset = 0; offset < flash->pages * flash->page_bytes; offset += HAL_FLASH_UNIT_BYTES) {
    kept = keep_unit(flash, offset, bytes + offset) && kept;
  }
  return kept;
}

}  // namespace

void load_parameter_pages(Stm32g474& chip, const sim::FlashMemory& file) {
  const auto pieces = pieces_of(file);
  for (std::size_t i = 0; i < kPieces; ++i) {
    pieces.at(i)->read(pieces.at(i), 0, chip.parameter_bytes() + kOnBoard.at(i), pieces.at(i)->pages * kPageBytes);
  }
}

void keep_parameter_pages(Stm32g474& chip, const sim::FlashMemory& file) {
  const auto pieces = pieces_of(file);
  for (std::size_t i = 0; i < kPieces; ++i) {
    if (!keep_piece(pieces.at(i), chip.parameter_bytes() + kOnBoard.at(i))) {
      throw std::runtime_error("the parameter pages cannot be written to the file of --flash");
    }
  }
}

}  // namespace trackservo::target
