#include "experiments/results.hpp"

#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "experiments/derived.hpp"
#include "experiments/goals.hpp"

namespace trackservo::sim {
namespace {

using Json = nlohmann::ordered_json;

// JSON has no NaN: a figure that could not be taken is null.
Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }
Json number(const std::optional<double>& value) { return value ? number(*value) : Json(nullptr); }

double mean_of(const std::vector<double>& values) {
  double sum = 0.0;
  for (const double value : values) {
    sum += value;
  }
  return sum / static_cast<double>(values.size());
}

double spread_of(const std::vector<double>& values) {
  const double mean = mean_of(values);
  double sum = 0.0;
  for (const double value : values) {
    sum += (value - mean) * (value - mean);
  }
  return values.size() < 2 ? 0.0 : std::sqrt(sum / static_cast<double>(values.size() - 1));
}

Json row_of(const Cell& cell) {
  const double value = mean_of(cell.values);
  const PaperFigures paper = paper_figures(cell);
  const std::optional<Goal> goal = goal_of(cell);
  Json row;
  row["experiment"] = cell.experiment;
  row["case"] = cell.case_name;
  row["plant"] = cell.plant;
  row["friction"] = friction_name(cell.friction);
  row["controller"] = cell.controller;
  row["axis"] = axis_name(cell.axis);
  row["metric"] = cell.metric;
  row["unit"] = cell.unit;
  row["value"] = number(value);
  row["spread"] = number(spread_of(cell.values));
  row["seeds"] = cell.values.size();
  row["paper_uncompensated"] = number(paper.uncompensated);
  row["paper_compensated"] = number(paper.compensated);
  row["goal"] = goal ? Json(goal->text) : Json(nullptr);
  row["met"] = goal ? Json(value >= goal->low && value <= goal->high) : Json(nullptr);
  return row;
}

Json stribeck_of(const StribeckConfig& s) {
  return {{"coulomb_nm", s.coulomb_nm},
          {"breakaway_nm", s.breakaway_nm},
          {"stribeck_speed_rad_s", s.stribeck_speed_rad_s},
          {"viscous_nm_s_rad", s.viscous_nm_s_rad}};
}

Json plant_of(const PlantConfig& plant) {
  Json json;
  json["name"] = plant.name;
  json["title"] = plant.title;
  json["file"] = "sim_host/plants/" + plant.name + ".toml";
  json["assumptions"] = Json::array();
  for (const Assumption& assumption : plant.assumptions) {
    json["assumptions"].push_back({{"topic", assumption.topic}, {"text", assumption.text}});
  }
  for (int axis = 0; axis < kAxes; ++axis) {
    const AxisConfig& config = plant.axis[static_cast<std::size_t>(axis)];
    json["friction"][axis_name(axis)] = {{"inertia_kg_m2", axis_inertia_kg_m2(plant, axis, 0.0)},
                                         {"stiffness_nm_rad", config.friction.stiffness_nm_rad},
                                         {"damping_nm_s_rad", config.friction.damping_nm_s_rad},
                                         {"positive", stribeck_of(config.friction.positive)},
                                         {"negative", stribeck_of(config.friction.negative)}};
  }
  return json;
}

Json margin_of(const MarginRecord& record) {
  Json json;
  json["plant"] = record.plant;
  json["controller"] = record.controller;
  json["axis"] = axis_name(record.axis);
  json["condition"] = record.pre_sliding ? "pre_sliding" : "sliding";
  json["gain_margin_db"] = number(record.computed.gain_margin_db);
  json["phase_margin_deg"] = number(record.computed.phase_margin_deg);
  json["crossover_hz"] = number(record.computed.crossover_hz);
  json["closed_loop_bandwidth_hz"] = number(record.bandwidth_hz);
  json["measured_gain_margin_db"] = number(record.measured.gain_margin_db);
  json["measured_phase_margin_deg"] = number(record.measured.phase_margin_deg);
  json["response_csv"] = record.csv;
  return json;
}

Json controllers_of() {
  Json json = Json::array();
  for (const ControllerSpec& spec : controller_specs()) {
    json.push_back({{"name", spec.name}, {"title", spec.title}, {"text", spec.text}});
  }
  return json;
}

// A CSV holds both axes; the report asks for it by axis.
Json runs_of(const Campaign& campaign) {
  Json json = Json::array();
  for (const KeptRun& run : campaign.runs) {
    for (int axis = 0; axis < kAxes; ++axis) {
      json.push_back({{"experiment", run.experiment},
                      {"case", run.case_name},
                      {"plant", run.plant},
                      {"friction", friction_name(run.friction)},
                      {"controller", run.controller},
                      {"axis", axis_name(axis)},
                      {"seed", run.seed},
                      {"csv", run.csv},
                      {"figure", run.figure.empty() ? Json(nullptr) : Json(run.figure)},
                      {"settling_s", run.settle_s}});
    }
  }
  return json;
}

}  // namespace

void write_results(const Campaign& campaign, const std::string& git, const std::filesystem::path& file) {
  Json json;
  json["schema_version"] = 1;
  json["generator"] = {{"program", "sim_host experiments"},
                       {"version", "0.1.0"},
                       {"git", git},
                       {"seeds", campaign.options.seeds},
                       {"quick", campaign.options.seeds.size() < 5},
                       {"friction_parameter_error", campaign.options.friction_parameter_error}};
  json["plants"] = Json::array();
  for (const PlantConfig& plant : campaign.plants) {
    json["plants"].push_back(plant_of(plant));
  }
  json["controllers"] = controllers_of();
  json["rows"] = Json::array();
  for (const Cell& cell : with_derived(campaign.cells)) {
    json["rows"].push_back(row_of(cell));
  }
  json["runs"] = runs_of(campaign);
  json["margins"] = Json::array();
  for (const MarginRecord& record : campaign.margins) {
    json["margins"].push_back(margin_of(record));
  }
  json["best_pi"] = Json::object();
  for (const auto& [study, wish] : campaign.best_pi) {
    json["best_pi"][study] = {{"natural_frequency_rad_s", wish.natural_frequency_rad_s},
                              {"damping", wish.damping},
                              {"setpoint_weight", wish.setpoint_weight}};
  }
  json["benchmark"] = nullptr;
  std::ofstream stream(file);
  stream << json.dump(1) << "\n";
  if (!stream.flush()) {
    throw std::runtime_error(fmt::format("{}: cannot be written; is the folder writable?", file.string()));
  }
}

}  // namespace trackservo::sim
