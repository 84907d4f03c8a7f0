// SPDX-License-Identifier: Apache-2.0
#include "design/commissioning/commissioning_report.hpp"

#include <fmt/format.h>

#include <fstream>

#include "identification/result_json.hpp"

namespace trackservo::sim {

namespace {

void close(std::ofstream& file, const std::filesystem::path& path) {
  if (!file.flush()) {
    throw std::runtime_error(fmt::format("{}: cannot be written; is the disk full?", path.string()));
  }
}

void print(const identification::Parameter& parameter, double truth) {
  const std::string value = parameter.refused.empty() ? fmt::format("{:.5g}", parameter.value) : "refused";
  fmt::print("  {:<24} {:>10.5g} {:>10} {:>+8.2f} {:>11.5g} .. {:<10.5g} {}\n", parameter.name, truth, value,
             100.0 * (parameter.value / truth - 1.0), parameter.interval.low, parameter.interval.high, parameter.unit);
}

void print_breakaway(const char *direction, const BreakawayTorque& torque) {
  fmt::print("  break-away {}: {} times, {:.3g} Nm, deviation {:.2g} Nm\n", direction, torque.count, torque.mean_nm,
             torque.deviation_nm);
}

}  // namespace

void print(const PlantConfig& plant, const Commissioned& commissioned) {
  const auto& [axis, rough, first_look_s, acquisition, structure, found, truth] = commissioned;
  fmt::print(
      "{} {}\n  first look, {:.0f} s: Tc {:.3g} Nm, bristle length {:.3g} urad, Stribeck speed {:.3g} mrad/s, "
      "inertia {:.3g} kg m2\n",
      plant.name, axis_name(axis), first_look_s, rough.coulomb_nm, 1e6 * rough.bristle_rad, 1e3 * rough.stribeck_rad_s,
      rough.inertia_kg_m2);
  fmt::print("  main test plan, {:.0f} s; chirps for structural resonances, {:.0f} s\n",
             acquisition.recording.time_s.back(), structure.time_s.back());
  fmt::print("  {:<24} {:>10} {:>10} {:>8} {:>22}\n", "parameter", "true", "found", "off, %", "95 % interval");
  for (const identification::Parameter& parameter : found.parameters) {
    print(parameter, truth.at(parameter.name));
  }
  print_breakaway("forward", breakaway_torque(acquisition.ended, STIMULUS_FORWARD));
  print_breakaway("backward", breakaway_torque(acquisition.ended, STIMULUS_BACKWARD));
  for (const identification::Parameter& parameter : found.parameters) {
    if (!parameter.refused.empty()) {
      fmt::print("  refused: {}\n", parameter.refused);
    }
  }
}

nlohmann::ordered_json result_of(const Commissioned& commissioned) {
  nlohmann::ordered_json result =
      identification::to_json(commissioned.identification, commissioned.acquisition.recording, commissioned.structure);
  result["machine"] = {{"axis", axis_name(commissioned.axis)}};
  return result;
}

void write_result(const Commissioned& commissioned, const std::filesystem::path& folder) {
  std::filesystem::create_directories(folder);
  const identification::Recording& recording = commissioned.acquisition.recording;
  std::ofstream json(folder / "result.json");
  json << result_of(commissioned).dump(2) << '\n';
  close(json, folder / "result.json");
  std::ofstream residuals(folder / "residuals.csv");
  identification::write_residuals(residuals, commissioned.identification, recording);
  close(residuals, folder / "residuals.csv");
}

}  // namespace trackservo::sim
