// SPDX-License-Identifier: Apache-2.0
// JSON files that the gain design reads, and the messages for errors in them.
#ifndef TRACKSERVO_GAIN_DESIGN_INPUT_FILE_HPP
#define TRACKSERVO_GAIN_DESIGN_INPUT_FILE_HPP

#include <nlohmann/json.hpp>
#include <stdexcept>
#include <string>
#include <string_view>

namespace trackservo::gain_design {

// "FILE: key error; remedy".
class InputFileError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// The content of a file and its name for messages.
struct InputFile {
  std::string name;
  nlohmann::json json;

  InputFileError error(const std::string& what) const { return InputFileError(name + ": " + what); }
};

// Throws InputFileError when it cannot be read or holds no JSON object.
InputFile load_input_file(const std::string& path);

// Returns the same for a text; `name` replaces the file in messages.
InputFile parse_input_file(std::string name, std::string_view text);

}  // namespace trackservo::gain_design

#endif
