#include "base/result_log.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <stdexcept>

namespace trackservo::sim {
namespace {

std::runtime_error cannot_write(const std::filesystem::path& file) {
  return std::runtime_error(fmt::format("{}: cannot be written; is the disk full?", file.string()));
}

}  // namespace

std::string ResultLogFormat::head() const { return fmt::format("# {}, {}\n{}\n", program, origin, columns); }

ResultLogSize read_result_log(const std::filesystem::path& file, const ResultLogFormat& format,
                              const LineReader& each) {
  const std::string head = format.head();
  std::ifstream stream(file, std::ios::binary);
  std::string read(head.size(), '\0');
  stream.read(read.data(), static_cast<std::streamsize>(read.size()));
  read.resize(static_cast<std::size_t>(stream.gcount()));
  if (head.compare(0, read.size(), read) != 0) {
    throw std::runtime_error(
        fmt::format("{}: line 1 is not \"{}\": the file is of another firmware, plant, setting or program; "
                    "give another file",
                    file.string(), head.substr(0, head.find('\n'))));
  }
  if (read.size() < head.size()) {
    return {0, !read.empty()};
  }
  ResultLogSize size{head.size(), false};
  int number = static_cast<int>(std::count(head.begin(), head.end(), '\n'));
  std::string line;
  while (std::getline(stream, line) && !stream.eof()) {
    if (!each(line, ++number)) {
      throw std::runtime_error(
          fmt::format("{}: line {} is not a result of {}; remove it", file.string(), number, format.program));
    }
    size.whole += line.size() + 1;
  }
  size.cut_off = !line.empty();
  return size;
}

ResultLog::ResultLog(const std::filesystem::path& file, const ResultLogFormat& format, const LineReader& each)
    : file_(file) {
  const ResultLogSize size = read_result_log(file, format, each);
  if (size.whole > 0) {
    std::filesystem::resize_file(file, size.whole);
    return;
  }
  std::ofstream created(file, std::ios::binary | std::ios::trunc);
  if (!(created << format.head()).flush()) {
    throw cannot_write(file);
  }
}

void ResultLog::append(const std::string& lines) {
  std::ofstream stream(file_, std::ios::binary | std::ios::app);
  if (!(stream << lines).flush()) {
    throw cannot_write(file_);
  }
}

}  // namespace trackservo::sim
