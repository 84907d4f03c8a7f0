// SPDX-License-Identifier: Apache-2.0
#include "check/results_file.hpp"

#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "check/check_report.hpp"

namespace trackservo::sim {
namespace {

using Json = nlohmann::ordered_json;

Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }
Json number(const std::optional<double>& value) { return value ? number(*value) : Json(nullptr); }

Json row_of(const FigureKey& key, const std::string& unit) {
  return {
      {"scenario", key.scenario}, {"case", key.case_name}, {"axis", key.axis}, {"figure", key.name}, {"unit", unit}};
}

Json row_of(const JudgedFigure& judged) {
  Json row = row_of(judged.figure.key, judged.figure.unit);
  row["better"] = better_name(judged.figure.better);
  row["value"] = number(judged.value);
  row["scatter"] = number(judged.scatter);
  row["min"] = judged.limit ? number(judged.limit->min) : Json(nullptr);
  row["max"] = judged.limit ? number(judged.limit->max) : Json(nullptr);
  row["kept"] = judged.limit ? Json(judged.kept) : Json(nullptr);
  row["failure"] = judged.figure.failure ? Json(*judged.figure.failure) : Json(nullptr);
  row["values"] = Json::array();
  for (const double value : judged.figure.values) {
    row["values"].push_back(number(value));
  }
  return row;
}

Json changes_of(const Comparison& comparison) {
  Json changes = Json::array();
  for (const Change& change : comparison.changes) {
    Json row = row_of(change.key, change.unit);
    row["change"] = change_name(change.kind);
    row["before"] = number(change.before);
    row["now"] = number(change.now);
    row["threshold"] = number(change.threshold);
    changes.push_back(row);
  }
  return {{"file", comparison.baseline.file.string()},
          {"git", comparison.baseline.git},
          {"paired", comparison.paired},
          {"compared", comparison.compared},
          {"changes", changes}};
}

}  // namespace

void write_results(const CheckReport& report, const std::filesystem::path& file) {
  Json json{{"format", kResultsFormat}, {"git", report.git},       {"plant", report.plant},
            {"gains", report.gains},    {"device", report.device}, {"limits", report.limits},
            {"seeds", report.seeds},    {"kept", report.kept()},   {"figures", Json::array()}};
  for (const JudgedFigure& judged : report.figures) {
    json["figures"].push_back(row_of(judged));
  }
  json["baseline"] = report.comparison ? changes_of(*report.comparison) : Json(nullptr);
  std::ofstream stream(file);
  stream << json.dump(1) << "\n";
  if (!stream.flush()) {
    throw std::runtime_error(fmt::format("{}: cannot be written; is the folder writable?", file.string()));
  }
}

}  // namespace trackservo::sim
