// SPDX-License-Identifier: Apache-2.0
#include "studies/campaign/results.hpp"

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>

#include "judge/analysis/statistics.hpp"
#include "machine/base/json_file.hpp"
#include "studies/shared/derived.hpp"
#include "studies/shared/goals.hpp"

namespace trackservo::sim {
namespace {

using Json = nlohmann::ordered_json;

// JSON has no NaN: a figure without a value is null.
Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }
Json number(const std::optional<double>& value) { return value ? number(*value) : Json(nullptr); }

// The median of start-up times, because they are skewed: with PI alone one gust makes the difference between a tenth of
// a second and a whole one. The mean of everything else.
bool is_skewed(const Cell& cell) { return cell.metric == "time_to_90_percent"; }

double value_of(const Cell& cell) { return is_skewed(cell) ? median(cell.values) : mean(cell.values); }

void add_statistics(Json& row, const Cell& cell) {
  const auto [low, high] = std::minmax_element(cell.values.begin(), cell.values.end());
  row["statistic"] = is_skewed(cell) ? "median" : "mean";
  row["value"] = number(value_of(cell));
  row["spread"] = number(standard_deviation(cell.values));
  row["low"] = number(*low);
  row["high"] = number(*high);
  row["seeds"] = cell.values.size();
}

void add_goal(Json& row, const Cell& cell, const Experiment& experiment) {
  const std::optional<Goal> goal = goal_of(cell, experiment);
  const double value = value_of(cell);
  row["goal"] = goal ? Json(goal->text) : Json(nullptr);
  row["met"] = goal ? Json(value >= goal->low && value <= goal->high) : Json(nullptr);
}

Json row_of(const Cell& cell, const Experiment& experiment) {
  const PaperFigure *paper = paper_figure(experiment.paper, cell.case_name, cell.metric);
  Json row;
  row["experiment"] = cell.experiment;
  row["case"] = cell.case_name;
  row["plant"] = cell.plant;
  row["friction"] = friction_name(cell.friction);
  row["controller"] = cell.controller;
  row["axis"] = axis_name(cell.axis);
  row["metric"] = cell.metric;
  row["unit"] = cell.unit;
  add_statistics(row, cell);
  row["paper_uncompensated"] = paper != nullptr ? number(paper->uncompensated) : Json(nullptr);
  row["paper_compensated"] = paper != nullptr ? number(paper->compensated) : Json(nullptr);
  add_goal(row, cell, experiment);
  const std::optional<bool> reproduced = reproduces_paper(cell, value_of(cell), experiment);
  row["reproduced"] = reproduced ? Json(*reproduced) : Json(nullptr);
  return row;
}

Json sensitivity_of(const SensitivityRecord& record, const Experiment& experiment) {
  Json row;
  row["variation"] = record.variation;
  row["kind"] = record.switches_off ? "source" : "choice";
  row["shipped_setting"] = record.shipped_setting;
  row["varied_setting"] = record.varied_setting;
  row["experiment"] = record.varied.experiment;
  row["case"] = record.varied.case_name;
  row["plant"] = record.varied.plant;
  row["controller"] = record.varied.controller;
  row["axis"] = axis_name(record.varied.axis);
  row["metric"] = record.varied.metric;
  row["unit"] = record.varied.unit;
  add_statistics(row, record.varied);
  add_statistics(row["shipped"], record.shipped);
  add_goal(row, record.varied, experiment);
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

Json breakaway_of(const BreakawayTorque& torque) {
  return {{"count", torque.count}, {"mean_nm", torque.mean_nm}, {"deviation_nm", torque.deviation_nm}};
}

Json identified_of(const IdentifiedAxis& identified) {
  Json json;
  json["plant"] = identified.plant;
  json["axis"] = axis_name(identified.axis);
  json["seed"] = kIdentificationSeed;
  json["first_look_s"] = identified.first_look_s;
  json["recorded_s"] = identified.recorded_s;
  json["rough"] = {{"coulomb_nm", identified.rough.coulomb_nm},
                   {"bristle_rad", identified.rough.bristle_rad},
                   {"stribeck_speed_rad_s", identified.rough.stribeck_rad_s},
                   {"inertia_kg_m2", identified.rough.inertia_kg_m2}};
  json["parameters"] = Json::array();
  for (const identification::Parameter& parameter : identified.parameters) {
    json["parameters"].push_back({{"name", parameter.name},
                                  {"unit", parameter.unit},
                                  {"true", identified.truth.at(parameter.name)},
                                  {"identified", parameter.value},
                                  {"low", parameter.interval.low},
                                  {"high", parameter.interval.high},
                                  {"paper_method", number(parameter.paper)}});
  }
  json["breakaway"] = {{"negative", breakaway_of(identified.breakaway[STIMULUS_BACKWARD])},
                       {"positive", breakaway_of(identified.breakaway[STIMULUS_FORWARD])}};
  json["folder"] = identified.folder;
  return json;
}

Json margin_of(const MarginRecord& record) {
  Json json;
  json["plant"] = record.plant;
  json["controller"] = record.controller;
  json["study"] = record.study.empty() ? Json(nullptr) : Json(record.study);
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

// A CSV holds both axes; the report needs it by axis.
Json runs_of(const Campaign& campaign) {
  Json json = Json::array();
  for (const SavedRun& run : campaign.runs) {
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
                       {"version", TRACKSERVO_VERSION},
                       {"git", git},
                       {"seeds", campaign.options.seeds},
                       {"quick", campaign.options.quick()},
                       {"friction_parameter_error", campaign.options.friction_parameter_error}};
  json["plants"] = Json::array();
  for (const PlantConfig& plant : campaign.plants) {
    json["plants"].push_back(plant_of(plant));
  }
  json["identified"] = Json::array();
  for (const IdentifiedAxis& identified : campaign.identified) {
    json["identified"].push_back(identified_of(identified));
  }
  json["controllers"] = controllers_of();
  json["rows"] = Json::array();
  for (const Cell& cell : with_derived(campaign.cells, campaign.experiments)) {
    json["rows"].push_back(row_of(cell, experiment_named(cell.experiment, campaign.experiments)));
  }
  json["sensitivity"] = Json::array();
  for (const SensitivityRecord& record : campaign.sensitivity) {
    json["sensitivity"].push_back(
        sensitivity_of(record, experiment_named(record.varied.experiment, campaign.experiments)));
  }
  json["runs"] = runs_of(campaign);
  json["margins"] = Json::array();
  for (const MarginRecord& record : campaign.margins) {
    json["margins"].push_back(margin_of(record));
  }
  json["best_pi"] = Json::object();
  for (const auto& [study, requirement] : campaign.best_pi) {
    json["best_pi"][study] = {{"natural_frequency_rad_s", requirement.natural_frequency_rad_s},
                              {"damping", requirement.damping},
                              {"setpoint_weight", requirement.setpoint_weight}};
  }
  json["benchmark"] = nullptr;
  json["requirements"] = Json::array();  // shared/requirement.hpp: the studies add theirs
  write_json(json, file);
}

}  // namespace trackservo::sim
