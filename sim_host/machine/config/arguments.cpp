// SPDX-License-Identifier: Apache-2.0
#include "machine/config/arguments.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <charconv>
#include <cstdint>
#include <system_error>

namespace trackservo::sim {
namespace {

bool is_writable(const std::filesystem::path& path) { return access(path.c_str(), W_OK) == 0; }

}  // namespace

std::string seed_problem(const std::string& text) {
  std::uint64_t value = 0;
  const char *end = text.data() + text.size();
  const auto [stop, error] = std::from_chars(text.data(), end, value);
  return error == std::errc() && stop == end
             ? ""
             : fmt::format("Invalid seed \"{}\": expected an integer from 0 to {}", text, UINT64_MAX);
}

std::string output_file_problem(const std::filesystem::path& file) {
  const std::filesystem::path folder = file.has_parent_path() ? file.parent_path() : ".";
  std::error_code ignored;
  if (!file.has_filename() || std::filesystem::is_directory(file, ignored)) {
    return fmt::format("\"{}\" is a folder; give a file name", file.string());
  }
  if (!std::filesystem::is_directory(folder, ignored)) {
    return fmt::format("{}: the folder {} does not exist; create it or give another one", file.string(),
                       folder.string());
  }
  if (!is_writable(std::filesystem::exists(file, ignored) ? file : folder)) {
    return fmt::format("{}: cannot be written; give another path", file.string());
  }
  return "";
}

std::string output_folder_problem(const std::filesystem::path& folder) {
  if (folder.empty()) {
    return "\"\" is not a folder; give the name of a folder";
  }
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error || !std::filesystem::is_directory(folder, error)) {
    return fmt::format("{}: cannot be created as a folder ({}); give another path", folder.string(), error.message());
  }
  return is_writable(folder) ? "" : fmt::format("{}: cannot be written; give another folder", folder.string());
}

}  // namespace trackservo::sim
