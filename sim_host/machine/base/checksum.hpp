// SPDX-License-Identifier: Apache-2.0
// Whether two files or settings are the same, without a copy of them.
#ifndef TRACKSERVO_SIM_BASE_CHECKSUM_HPP
#define TRACKSERVO_SIM_BASE_CHECKSUM_HPP

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace trackservo::sim {

// Returns the CRC-32 as eight hexadecimal digits.
std::string checksum_of(std::string_view text);

// Does the same for the files' contents, one after the other. Throws std::runtime_error that names a file that cannot
// be read.
std::string checksum_of(const std::vector<std::filesystem::path>& files);

}  // namespace trackservo::sim

#endif
