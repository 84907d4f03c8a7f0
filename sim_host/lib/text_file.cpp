// SPDX-License-Identifier: Apache-2.0
#include "text_file.hpp"

#include <fmt/format.h>
#include <iconv.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <fstream>
#include <memory>
#include <optional>
#include <string_view>

namespace trackservo {
namespace {

constexpr char kDosEnd = 0x1A;

struct Mark {
  std::string_view bytes;
  const char *encoding;
};

// In this order: the mark of UTF-32 begins as one of UTF-16.
constexpr std::array<Mark, 5> kMarks{{{{"\xFF\xFE\0\0", 4}, "UTF-32LE"},
                                      {{"\0\0\xFE\xFF", 4}, "UTF-32BE"},
                                      {{"\xEF\xBB\xBF", 3}, "UTF-8"},
                                      {{"\xFF\xFE", 2}, "UTF-16LE"},
                                      {{"\xFE\xFF", 2}, "UTF-16BE"}}};

// Nothing: the bytes are not in this encoding.
std::optional<std::string> converted(std::string_view bytes, const char *encoding) {
  const std::unique_ptr<void, int (*)(iconv_t)> converter(iconv_open("UTF-8", encoding), iconv_close);
  std::string text;
  std::array<char, 1U << 16U> block{};
  std::string source(bytes);  // iconv's parameter is not const
  char *in = source.data();
  std::size_t left = source.size();
  while (left > 0) {
    char *out = block.data();
    std::size_t room = block.size();
    const std::size_t result = iconv(converter.get(), &in, &left, &out, &room);
    text.append(block.data(), block.size() - room);
    if (result == static_cast<std::size_t>(-1) && errno != E2BIG) {
      return std::nullopt;
    }
  }
  return text;
}

std::string decoded(std::string_view bytes) {
  for (const Mark& mark : kMarks) {
    if (bytes.substr(0, mark.bytes.size()) == mark.bytes) {
      const std::optional<std::string> text = converted(bytes.substr(mark.bytes.size()), mark.encoding);
      if (!text) {
        throw TextFileError(1, fmt::format("begins as {}, but is not; save it as UTF-8", mark.encoding));
      }
      return *text;
    }
  }
  const std::optional<std::string> text = converted(bytes, "UTF-8");
  return text ? *text : *converted(bytes, "ISO-8859-1");
}

// CR LF and CR become LF.
std::string with_line_feeds(const std::string& text) {
  std::string result;
  result.reserve(text.size());
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '\r') {
      result += text[i];
    } else if (i + 1 == text.size() || text[i + 1] != '\n') {
      result += '\n';
    }
  }
  return result;
}

// Programs that add a mark to each file add it to one that has a mark, too.
std::string without_marks(std::string text) {
  constexpr std::string_view kMark = "\xEF\xBB\xBF";
  std::size_t begin = 0;
  while (text.compare(begin, kMark.size(), kMark) == 0) {
    begin += kMark.size();
  }
  text.erase(0, begin);
  return text;
}

std::string text_of_bytes(const std::string& bytes) {
  std::string text = with_line_feeds(without_marks(decoded(bytes)));
  while (!text.empty() && (text.back() == '\0' || text.back() == kDosEnd)) {
    text.pop_back();
  }
  const std::size_t nul = text.find('\0');
  if (nul != std::string::npos) {
    const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(nul), '\n');
    throw TextFileError(
        static_cast<int>(line),
        "has a NUL character: it is no text file, or UTF-16 without a byte order mark; save it as UTF-8");
  }
  return text;
}

}  // namespace

std::string read_text(const std::filesystem::path& path, std::size_t most_bytes) {
  std::error_code ignored;
  std::ifstream stream(path, std::ios::binary);
  if (!stream || std::filesystem::is_directory(path, ignored)) {
    throw TextFileError(1, "cannot be read; give the path of an existing file");
  }
  std::string bytes;
  std::array<char, 1U << 16U> block{};
  while (stream.read(block.data(), block.size()) || stream.gcount() > 0) {
    bytes.append(block.data(), static_cast<std::size_t>(stream.gcount()));
    if (bytes.size() > most_bytes) {
      throw TextFileError(1, fmt::format("has more than {} MB; give a smaller file", most_bytes / 1'000'000));
    }
  }
  return text_of_bytes(bytes);
}

}  // namespace trackservo
