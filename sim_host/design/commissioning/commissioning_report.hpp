// SPDX-License-Identifier: Apache-2.0
// Results of commissioning, for people and as files.
#ifndef TRACKSERVO_SIM_COMMISSIONING_COMMISSIONING_REPORT_HPP
#define TRACKSERVO_SIM_COMMISSIONING_COMMISSIONING_REPORT_HPP

#include <filesystem>
#include <nlohmann/json.hpp>

#include "design/commissioning/commissioning.hpp"

namespace trackservo::sim {

// Prints a table to the standard output: true, found, interval.
void print(const PlantConfig& plant, const Commissioned& commissioned);

// Returns the contents of result.json: what was identified, as every tool of ours reads it.
nlohmann::ordered_json result_of(const Commissioned& commissioned);

// Writes result.json and residuals.csv, as servoctl identify writes them. Creates the folder. Throws std::runtime_error
// that names the file.
void write_result(const Commissioned& commissioned, const std::filesystem::path& folder);

}  // namespace trackservo::sim

#endif
