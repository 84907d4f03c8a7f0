#include "gain_design/input_file.hpp"

#include <utility>

#include "text_file.hpp"

namespace trackservo::gain_design {

InputFile load_input_file(const std::string& path) {
  try {
    return parse_input_file(path, read_text(path));
  } catch (const TextFileError& error) {
    throw InputFile{path, {}}.error(error.what());
  }
}

InputFile parse_input_file(std::string name, std::string_view text) {
  InputFile file{std::move(name), {}};
  try {
    file.json = nlohmann::json::parse(text);
  } catch (const nlohmann::json::exception& error) {
    throw file.error(error.what());
  }
  if (!file.json.is_object()) {
    throw file.error("is not a JSON object; it must begin with {");
  }
  return file;
}

}  // namespace trackservo::gain_design
