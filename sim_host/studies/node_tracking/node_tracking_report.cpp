// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "machine/base/json_file.hpp"
#include "studies/node_tracking/node_tracking.hpp"

namespace trackservo::sim {
namespace {

template <class Value>
std::vector<double> over_runs(const NodeTrackingResult& result, const Value& value) {
  std::vector<double> values;
  for (const NodeTrackingRun& run : result.runs) {
    values.push_back(value(run));
  }
  return values;
}

void add_of_axis(const NodeTrackingResult& result, std::size_t axis, std::vector<Requirement>& requirements) {
  const NodeTrackingCase& tried = result.tried;
  const std::string name = axis_name(static_cast<int>(axis));
  if (tried.goal.sigma_rad) {
    requirements.push_back({tried.name, name, "sigma", "urad", (*tried.goal.sigma_rad)[axis] / kUrad,
                            over_runs(result, [axis](const auto& run) { return run.sigma_rad[axis] / kUrad; })});
  }
  if (tried.goal.per_reference) {
    const auto ratio = [axis](const auto& run) { return run.sigma_rad[axis] / run.reference_sigma_rad[axis]; };
    requirements.push_back(
        {tried.name, name, "sigma_over_right_age", "ratio", *tried.goal.per_reference, over_runs(result, ratio)});
  }
}

std::string goal_and_met(const Requirement& requirement) {
  return fmt::format("{} {}", goal_text(requirement), is_met(requirement) ? "yes" : "no");
}

nlohmann::ordered_json finite_or_null(double value) {
  return std::isfinite(value) ? nlohmann::ordered_json(value) : nlohmann::ordered_json(nullptr);
}

nlohmann::ordered_json json_of(const NodeTrackingCase& tried, const NodeTrackingRun& run, std::uint64_t seed) {
  nlohmann::ordered_json one{{"seed", seed},
                             {"azimuth_sigma_urad", run.sigma_rad[kAzimuth] / kUrad},
                             {"pitch_sigma_urad", run.sigma_rad[kPitch] / kUrad},
                             {"largest_step_nm", run.step_nm},
                             {"lost_s", finite_or_null(run.lost_s)},
                             {"frames_dropped", run.dropped}};
  if (tried.goal.per_reference) {
    one["azimuth_sigma_with_right_age_urad"] = run.reference_sigma_rad[kAzimuth] / kUrad;
    one["pitch_sigma_with_right_age_urad"] = run.reference_sigma_rad[kPitch] / kUrad;
  }
  return one;
}

}  // namespace

std::vector<Requirement> requirements_of(const NodeTrackingResult& result) {
  const NodeTrackingCase& tried = result.tried;
  std::vector<Requirement> requirements;
  for (std::size_t axis = 0; axis < kAxes; ++axis) {
    add_of_axis(result, axis, requirements);
  }
  if (tried.goal.step_nm) {
    requirements.push_back({tried.name, "", "torque_step", "Nm", *tried.goal.step_nm,
                            over_runs(result, [](const auto& run) { return run.step_nm; })});
  }
  if (tried.goal.lost_s) {
    requirements.push_back({tried.name, "", "time_lost", "s", *tried.goal.lost_s,
                            over_runs(result, [](const auto& run) { return run.lost_s; })});
  }
  requirements.push_back({tried.name, "", "frames_dropped", "1", 0.0,
                          over_runs(result, [](const auto& run) { return static_cast<double>(run.dropped); })});
  return requirements;
}

bool meets_goal(const NodeTrackingResult& result) {
  const std::vector<Requirement> requirements = requirements_of(result);
  return std::all_of(requirements.begin(), requirements.end(), is_met);
}

void print(const NodeTrackingSetup& setup, const std::vector<NodeTrackingResult>& results) {
  fmt::print("Tracking in the running node, camera frames over CAN: {} seeds, on {}\n", setup.seeds.size(),
             setup.plant.name);
  const char *const line = "  {:<36} {:<8} {:<21} {:>8} {:<5} {}\n";
  fmt::print(fmt::runtime(line), "target", "axis", "figure", "worst", "unit", "goal, met");
  for (const NodeTrackingResult& result : results) {
    for (const Requirement& row : requirements_of(result)) {
      if (row.metric != std::string("frames_dropped") || !is_met(row)) {
        fmt::print(fmt::runtime(line), row.case_name, row.axis.empty() ? "both" : row.axis, row.metric,
                   fmt::format("{:.3g}", worst_of(row)), row.unit, goal_and_met(row));
      }
    }
  }
  fmt::print("Azimuth stands for cross-elevation, pitch for elevation where the camera sees both.\n");
}

void write_node_tracking(const NodeTrackingSetup& setup, const std::vector<NodeTrackingResult>& results,
                         const std::string& git, const std::filesystem::path& file) {
  nlohmann::ordered_json json;
  json["generator"] = {
      {"program", "sim_host node-tracking"}, {"git", git}, {"plant", setup.plant.name}, {"seeds", setup.seeds}};
  json["cases"] = nlohmann::ordered_json::array();
  for (const NodeTrackingResult& result : results) {
    const CameraConfig& camera = result.tried.scenario.camera;
    nlohmann::ordered_json tried{{"name", result.tried.name},
                                 {"meets_goal", meets_goal(result)},
                                 {"dropout_s", camera.dropouts_at_s.empty() ? 0.0 : camera.dropout_s},
                                 {"runs", nlohmann::ordered_json::array()}};
    for (std::size_t i = 0; i < result.runs.size(); ++i) {
      tried["runs"].push_back(json_of(result.tried, result.runs[i], setup.seeds[i]));
    }
    json["cases"].push_back(tried);
  }
  write_json(json, file);
}

}  // namespace trackservo::sim
