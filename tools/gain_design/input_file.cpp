#include "gain_design/input_file.hpp"

#include <fstream>

namespace trackservo::gain_design {

InputFile load_input_file(const std::string& path) {
  InputFile file{path, {}};
  std::ifstream stream(path);
  if (!stream) {
    throw file.error("cannot be read; give the path of a JSON file");
  }
  try {
    file.json = nlohmann::json::parse(stream);
  } catch (const nlohmann::json::parse_error& error) {
    throw file.error(error.what());
  }
  if (!file.json.is_object()) {
    throw file.error("holds no JSON object; it must begin with {");
  }
  return file;
}

}  // namespace trackservo::gain_design
