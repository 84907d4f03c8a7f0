// SPDX-License-Identifier: Apache-2.0
#include "gain_design/input_file.hpp"

#include <fmt/format.h>

#include <utility>

#include "json_text.hpp"

namespace trackservo::gain_design {

namespace {

InputFileError error_in(const std::string& name, const TextFileError& error) {
  return InputFile{fmt::format("{}:{}", name, error.line()), {}}.error(error.what());
}

}  // namespace

InputFile load_input_file(const std::string& path) {
  try {
    return parse_input_file(path, read_text(path));
  } catch (const TextFileError& error) {
    throw error_in(path, error);
  }
}

InputFile parse_input_file(std::string name, std::string_view text) {
  InputFile file{std::move(name), {}};
  try {
    file.json = parse_json(text);
  } catch (const TextFileError& error) {
    throw error_in(file.name, error);
  }
  if (!file.json.is_object()) {
    throw file.error("is not a JSON object; it must begin with {");
  }
  return file;
}

}  // namespace trackservo::gain_design
