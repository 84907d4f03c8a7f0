// SPDX-License-Identifier: Apache-2.0
#include "machine/base/checksum.hpp"

#include <fmt/format.h>

#include <fstream>
#include <iterator>
#include <stdexcept>

extern "C" {
#include "base/crc32.h"
}

namespace trackservo::sim {

std::string checksum_of(std::string_view text) {
  const std::vector<std::uint8_t> bytes(text.begin(), text.end());
  return fmt::format("{:08x}",
                     crc32_end(crc32_add(CRC32_START, bytes.data(), static_cast<std::uint32_t>(bytes.size()))));
}

std::string checksum_of(const std::vector<std::filesystem::path>& files) {
  std::string text;
  for (const std::filesystem::path& file : files) {
    std::ifstream stream(file, std::ios::binary);
    text.append(std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>());
    if (!stream) {
      throw std::runtime_error(fmt::format("{}: cannot be read", file.string()));
    }
  }
  return checksum_of(text);
}

}  // namespace trackservo::sim
