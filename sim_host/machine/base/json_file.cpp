// SPDX-License-Identifier: Apache-2.0
#include "machine/base/json_file.hpp"

#include <fmt/format.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

namespace trackservo::sim {

void write_json(const nlohmann::ordered_json& json, const std::filesystem::path& file) {
  std::ofstream stream(file);
  stream << json.dump(1) << "\n";
  if (!stream.flush()) {
    throw std::runtime_error(fmt::format("{}: cannot be written; is the folder writable?", file.string()));
  }
}

}  // namespace trackservo::sim
