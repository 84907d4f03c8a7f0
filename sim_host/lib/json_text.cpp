// SPDX-License-Identifier: Apache-2.0
#include "json_text.hpp"

#include <algorithm>
#include <string>

namespace trackservo {
namespace {

// From 0 on. A number out of range is only quoted, at the end of the sentence.
std::size_t place_of(std::string_view text, const nlohmann::json::exception& error) {
  if (const auto *syntax = dynamic_cast<const nlohmann::json::parse_error *>(&error)) {
    return std::max<std::size_t>(syntax->byte, 1) - 1;
  }
  const std::string_view sentence = error.what();
  const std::size_t end = sentence.rfind('\'');
  const std::size_t begin = end == std::string_view::npos || end == 0 ? end : sentence.rfind('\'', end - 1);
  return begin == end || begin == std::string_view::npos ? 0 : text.find(sentence.substr(begin + 1, end - begin - 1));
}

// The parser's sentence quotes what it has read, up to the middle of a character.
std::string plain(std::string sentence) {
  constexpr unsigned char kAscii = 0x7F;
  std::replace_if(
      sentence.begin(), sentence.end(), [](unsigned char letter) { return letter > kAscii; }, '?');
  return sentence;
}

}  // namespace

TextFileError json_error(std::string_view text, const nlohmann::json::exception& error) {
  const std::string_view before = text.substr(0, std::min(place_of(text, error), text.size()));
  return {1 + static_cast<int>(std::count(before.begin(), before.end(), '\n')), plain(error.what())};
}

}  // namespace trackservo
