// SPDX-License-Identifier: Apache-2.0
#include "device/flash_memory.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>
#include <stdexcept>

namespace trackservo::sim {
namespace {

constexpr std::uint32_t kAreaBytes = FlashMemory::kPages * FlashMemory::kPageBytes;
constexpr std::uint32_t kAreasBytes = FlashMemory::kAreas * kAreaBytes;
constexpr std::uint32_t kBytes = kAreasBytes + FlashMemory::kBusPages * FlashMemory::kPageBytes;
constexpr std::uint8_t kErased = 0xFF;

bool is_within(const hal_flash *flash, std::uint32_t offset, std::uint32_t count) {
  const std::uint32_t bytes = flash->pages * flash->page_bytes;
  return offset <= bytes && count <= bytes - offset;
}

FlashMemory& memory_of(const hal_flash *flash) { return *static_cast<FlashMemory *>(flash->context); }

}  // namespace

FlashMemory::FlashMemory() : bytes_(kBytes, kErased), areas_{} {
  for (std::uint32_t area = 0; area < kAreas; ++area) {
    areas_.at(area) = {read, program, erase, nullptr, this, area, kPageBytes, kPages};
  }
  areas_.back() = {read, program, erase, nullptr, this, kAreas, kPageBytes, kBusPages};
}

FlashMemory::FlashMemory(const std::filesystem::path& file) : FlashMemory() {
  if (std::filesystem::exists(file)) {
    if (!std::filesystem::is_regular_file(file)) {
      throw std::invalid_argument(
          fmt::format("--flash: {} is not a regular file; give one, or a new name", file.string()));
    }
    const auto size = std::filesystem::file_size(file);
    if (size != kBytes && size != kAreasBytes) {
      throw std::invalid_argument(
          fmt::format("{} does not contain a parameter flash: it must have {} bytes", file.string(), kBytes));
    }
    std::ifstream(file, std::ios::binary)
        .read(reinterpret_cast<char *>(bytes_.data()), static_cast<std::streamsize>(size));
  }
  std::ofstream(file, std::ios::binary).write(reinterpret_cast<const char *>(bytes_.data()), kBytes);
  file_.open(file, std::ios::binary | std::ios::in | std::ios::out);
  if (!file_) {
    throw std::runtime_error(fmt::format("{} cannot be read or written", file.string()));
  }
}

// False: the file cannot be written.
bool FlashMemory::keep(std::uint32_t begin, std::uint32_t count) {
  if (!file_.is_open()) {
    return true;
  }
  file_.seekp(begin);
  file_.write(reinterpret_cast<const char *>(bytes_.data() + begin), count);
  file_.flush();
  return static_cast<bool>(file_);
}

bool FlashMemory::read(const hal_flash *flash, std::uint32_t offset, void *bytes, std::uint32_t count) {
  if (!is_within(flash, offset, count)) {
    return false;
  }
  const std::uint32_t begin = flash->area * kAreaBytes + offset;
  std::memcpy(bytes, memory_of(flash).bytes_.data() + begin, count);
  return true;
}

bool FlashMemory::program(const hal_flash *flash, std::uint32_t offset, const std::uint32_t *double_word) {
  if (offset % HAL_FLASH_UNIT_BYTES != 0 || !is_within(flash, offset, HAL_FLASH_UNIT_BYTES)) {
    return false;
  }
  FlashMemory& memory = memory_of(flash);
  const std::uint32_t begin = flash->area * kAreaBytes + offset;
  const auto target = memory.bytes_.begin() + begin;
  if (std::any_of(target, target + HAL_FLASH_UNIT_BYTES, [](std::uint8_t byte) { return byte != kErased; })) {
    return false;
  }
  std::memcpy(&*target, double_word, HAL_FLASH_UNIT_BYTES);
  return memory.keep(begin, HAL_FLASH_UNIT_BYTES);
}

bool FlashMemory::erase(const hal_flash *flash, std::uint32_t page) {
  if (page >= flash->pages) {
    return false;
  }
  FlashMemory& memory = memory_of(flash);
  const std::uint32_t begin = flash->area * kAreaBytes + page * kPageBytes;
  std::fill_n(memory.bytes_.begin() + begin, kPageBytes, kErased);
  return memory.keep(begin, kPageBytes);
}

}  // namespace trackservo::sim
