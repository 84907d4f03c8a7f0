#include "config/arguments.hpp"

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
  return error == std::errc() && stop == end ? "" : fmt::format("\"{}\" is no seed; give 0 to {}", text, UINT64_MAX);
}

std::string output_file_problem(const std::filesystem::path& file) {
  const std::filesystem::path folder = file.has_parent_path() ? file.parent_path() : ".";
  std::error_code ignored;
  if (!file.has_filename() || std::filesystem::is_directory(file, ignored)) {
    return fmt::format("\"{}\" is a folder; give the name of a file", file.string());
  }
  if (!std::filesystem::is_directory(folder, ignored)) {
    return fmt::format("{}: there is no folder {}; make it, or give another one", file.string(), folder.string());
  }
  if (!is_writable(std::filesystem::exists(file, ignored) ? file : folder)) {
    return fmt::format("{}: cannot be written; give another place", file.string());
  }
  return "";
}

std::string output_folder_problem(const std::filesystem::path& folder) {
  if (folder.empty()) {
    return "\"\" is no folder; give its name";
  }
  std::error_code error;
  std::filesystem::create_directories(folder, error);
  if (error || !std::filesystem::is_directory(folder, error)) {
    return fmt::format("{}: cannot be made a folder ({}); give another place", folder.string(), error.message());
  }
  return is_writable(folder) ? "" : fmt::format("{}: cannot be written; give another folder", folder.string());
}

}  // namespace trackservo::sim
