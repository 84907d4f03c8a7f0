// SPDX-License-Identifier: Apache-2.0
// Results as JSON files.
#ifndef TRACKSERVO_SIM_BASE_JSON_FILE_HPP
#define TRACKSERVO_SIM_BASE_JSON_FILE_HPP

#include <filesystem>
#include <nlohmann/json_fwd.hpp>

namespace trackservo::sim {

// Writes the file, one line per value. Throws std::runtime_error that names it.
void write_json(const nlohmann::ordered_json& json, const std::filesystem::path& file);

}  // namespace trackservo::sim

#endif
