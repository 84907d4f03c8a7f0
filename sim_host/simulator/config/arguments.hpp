// What is wrong with an argument of the command line, told before any work is done. Each returns one sentence, or
// nothing when all is well: the form that CLI11's validators want.
#ifndef TRACKSERVO_SIM_CONFIG_ARGUMENTS_HPP
#define TRACKSERVO_SIM_CONFIG_ARGUMENTS_HPP

#include <filesystem>
#include <string>

namespace trackservo::sim {

// A seed: digits alone, below 2^64. Parsers take "-1" for the largest number.
std::string seed_problem(const std::string& text);

// A file to be written: its folder must be there and writable, and it must not be a folder itself.
std::string output_file_problem(const std::filesystem::path& file);

// Makes the folder if it is not there, and sees whether it can be written.
std::string output_folder_problem(const std::filesystem::path& folder);

}  // namespace trackservo::sim

#endif
