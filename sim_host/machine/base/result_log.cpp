// SPDX-License-Identifier: Apache-2.0
#include "machine/base/result_log.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <stdexcept>
#include <string_view>
#include <system_error>
#include <utility>

#include "text_file.hpp"

namespace trackservo::sim {
namespace {

constexpr std::size_t kMostBytes = 1'000'000'000;  // a million plants have 340 MB

std::runtime_error cannot_write(const std::filesystem::path& file) {
  return std::runtime_error(fmt::format("{}: cannot be written; is the disk full?", file.string()));
}

// Number of the line in which `text` ends, or would go on.
int last_line(std::string_view text) { return 1 + static_cast<int>(std::count(text.begin(), text.end(), '\n')); }

void refuse_other_head(const std::filesystem::path& file, std::string_view text, std::string_view head) {
  const std::string_view begin = text.substr(0, head.size());
  const auto differs = std::mismatch(begin.begin(), begin.end(), head.begin()).first;
  if (differs == begin.end()) {
    return;
  }
  const int line = last_line(text.substr(0, static_cast<std::size_t>(differs - begin.begin())));
  const std::string_view expected = line == 1 ? head : head.substr(head.find('\n') + 1);
  throw std::runtime_error(
      fmt::format("{}:{}: is not \"{}\": the file is of another firmware, plant, setting or program; give another file",
                  file.string(), line, expected.substr(0, expected.find('\n'))));
}

// It has the old contents or the new ones, also when the process is killed; a link stays one, and the mode as it was.
void replace(const std::filesystem::path& file, std::string_view text) {
  std::error_code error;
  const std::filesystem::path target = std::filesystem::weakly_canonical(file);
  const std::filesystem::path part = fmt::format("{}.{}", target.string(), getpid());
  std::ofstream stream(part, std::ios::binary | std::ios::trunc);
  if ((stream << text).flush()) {
    const std::filesystem::file_status before = std::filesystem::status(target, error);
    if (std::filesystem::exists(before)) {
      std::filesystem::permissions(part, before.permissions(), error);
    }
    std::filesystem::rename(part, target, error);
  }
  if (!stream || error) {
    std::filesystem::remove(part, error);
    throw cannot_write(file);
  }
}

}  // namespace

std::string ResultLogFormat::head() const { return fmt::format("# {}, {}\n{}\n", program, origin, columns); }

std::string read_log_text(const std::filesystem::path& file) {
  try {
    return read_text(file, kMostBytes);
  } catch (const TextFileError& error) {
    throw std::runtime_error(fmt::format("{}:{}: {}", file.string(), error.line(), error.what()));
  }
}

ResultLogLines read_result_log(const std::filesystem::path& file, std::string text, const ResultLogFormat& format,
                               const LineReader& each) {
  const std::string head = format.head();
  refuse_other_head(file, text, head);
  if (text.size() < head.size()) {
    return {"", last_line(text)};
  }
  int number = last_line(head) - 1;
  for (std::size_t begin = head.size(); begin < text.size();) {
    const std::size_t end = text.find('\n', begin);
    const std::string line = text.substr(begin, end - begin);
    ++number;
    if (!line.empty() && !each(line, number)) {
      if (end == std::string::npos) {
        text.resize(begin);
        return {std::move(text), number};
      }
      throw std::runtime_error(
          fmt::format("{}:{}: is not a result of {}; remove this line", file.string(), number, format.program));
    }
    begin += line.size() + 1;
  }
  if (text.back() != '\n') {
    text += '\n';
  }
  return {std::move(text), 0};
}

ResultLog::ResultLog(const std::filesystem::path& file, const ResultLogFormat& format, const LineReader& each)
    : file_(file) {
  const std::string text = std::filesystem::exists(file) ? read_log_text(file) : "";
  ResultLogLines lines = read_result_log(file, text, format, each);
  if (lines.whole.empty()) {
    lines.whole = format.head();
  }
  if (lines.whole != text || std::filesystem::file_size(file) != text.size()) {
    replace(file, lines.whole);
  }
}

void ResultLog::append(const std::string& lines) {
  std::ofstream stream(file_, std::ios::binary | std::ios::app);
  if (!(stream << lines).flush()) {
    throw cannot_write(file_);
  }
}

}  // namespace trackservo::sim
