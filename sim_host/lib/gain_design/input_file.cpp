#include "gain_design/input_file.hpp"

#include <fstream>
#include <iterator>
#include <utility>

namespace trackservo::gain_design {

InputFile load_input_file(const std::string& path) {
  std::ifstream stream(path);
  if (!stream) {
    throw InputFile{path, {}}.error("cannot be read; give the path of a JSON file");
  }
  return parse_input_file(path, std::string(std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()));
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
