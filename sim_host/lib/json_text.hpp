// SPDX-License-Identifier: Apache-2.0
// JSON in the text files of users.
#ifndef TRACKSERVO_JSON_TEXT_HPP
#define TRACKSERVO_JSON_TEXT_HPP

#include <nlohmann/json.hpp>
#include <string_view>

#include "text_file.hpp"

namespace trackservo {

// Returns the error of a parser in this text, with its line.
TextFileError json_error(std::string_view text, const nlohmann::json::exception& error);

// `Json`: nlohmann::json, or ordered_json. Throws TextFileError.
template <class Json = nlohmann::json>
Json parse_json(std::string_view text) {
  try {
    return Json::parse(text);
  } catch (const nlohmann::json::exception& error) {
    throw json_error(text, error);
  }
}

}  // namespace trackservo

#endif
