// SPDX-License-Identifier: Apache-2.0
// Errors in command-line arguments, found before any work is done. Each function returns one sentence, or nothing when
// there is no error: the form that CLI11's validators need.
#ifndef TRACKSERVO_SIM_CONFIG_ARGUMENTS_HPP
#define TRACKSERVO_SIM_CONFIG_ARGUMENTS_HPP

#include <filesystem>
#include <string>

namespace trackservo::sim {

// Checks a seed: only digits, below 2^64. Parsers take "-1" for the largest number.
std::string seed_problem(const std::string& text);

// Checks a file to be written: its folder must exist and be writable, and it must not be a folder itself.
std::string output_file_problem(const std::filesystem::path& file);

// Creates the folder if it does not exist, and checks that it can be written.
std::string output_folder_problem(const std::filesystem::path& folder);

}  // namespace trackservo::sim

#endif
