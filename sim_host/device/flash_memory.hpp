// SPDX-License-Identifier: Apache-2.0
// The parameter flash of a simulated board: two areas of four pages of 2 KiB for the parameter store and one of two for
// node id and bit rate, in memory, and in a file if one is named.
//
// It follows the hardware's rules (hal_flash.h). The file has every operation as soon as it is done: a simulator that
// is killed during a save leaves the same contents as a board whose power fails.
#ifndef TRACKSERVO_SIM_DEVICE_FLASH_MEMORY_HPP
#define TRACKSERVO_SIM_DEVICE_FLASH_MEMORY_HPP

#include <array>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <vector>

extern "C" {
#include "hal_flash.h"
}

namespace trackservo::sim {

class FlashMemory {
 public:
  static constexpr std::uint32_t kAreas = 2;
  static constexpr std::uint32_t kPages = 4;     // of an area
  static constexpr std::uint32_t kBusPages = 2;  // behind the areas
  static constexpr std::uint32_t kPageBytes = 2048;

  // Makes a blank flash, which is lost with the object.
  FlashMemory();
  // Reads the contents of the file; a missing file is created, blank. Throws std::invalid_argument for what is no
  // regular file or not 20 KiB long (or 16, as before there were pages for the bus), std::runtime_error for one that
  // cannot be written.
  explicit FlashMemory(const std::filesystem::path& file);
  FlashMemory(const FlashMemory&) = delete;
  FlashMemory& operator=(const FlashMemory&) = delete;

  // Returns the areas of the parameter store, kAreas of them.
  const hal_flash *areas() const { return areas_.data(); }

  // Returns the pages for node id and bit rate.
  const hal_flash *bus_pages() const { return &areas_.back(); }

 private:
  static bool read(const hal_flash *flash, std::uint32_t offset, void *bytes, std::uint32_t count);
  static bool program(const hal_flash *flash, std::uint32_t offset, const std::uint32_t *double_word);
  static bool erase(const hal_flash *flash, std::uint32_t page);
  bool keep(std::uint32_t begin, std::uint32_t count);

  std::vector<std::uint8_t> bytes_;
  std::fstream file_;
  std::array<hal_flash, kAreas + 1> areas_;
};

}  // namespace trackservo::sim

#endif
