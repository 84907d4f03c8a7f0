// SPDX-License-Identifier: Apache-2.0
#include "studies/shared/requirement.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "json_text.hpp"
#include "machine/base/json_file.hpp"

namespace trackservo::sim {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char *kList = "requirements";

// JSON has no infinity: an event that never came is null.
Json number(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json row_of(const RequirementSource& source, const Requirement& requirement) {
  const auto [low, high] = std::minmax_element(requirement.values.begin(), requirement.values.end());
  Json row;
  row["command"] = source.command;
  row["git"] = source.git;
  row["plant"] = source.plant;
  row["case"] = requirement.case_name;
  row["axis"] = requirement.axis.empty() ? Json(nullptr) : Json(requirement.axis);
  row["metric"] = requirement.metric;
  row["unit"] = requirement.unit;
  row["statistic"] = requirement.bound == Bound::kAtMost ? "largest" : "smallest";
  row["value"] = number(worst_of(requirement));
  row["low"] = number(*low);
  row["high"] = number(*high);
  row["seeds"] = requirement.values.size();
  row["goal"] = goal_text(requirement);
  row["met"] = is_met(requirement);
  return row;
}

Json read_results(const std::filesystem::path& file) {
  Json results;
  try {
    results = parse_json<Json>(read_text(file));
  } catch (const TextFileError& error) {
    throw std::runtime_error(fmt::format("{}:{}: {}; run sim_host experiments of this version first", file.string(),
                                         error.line(), error.what()));
  }
  if (!results.is_object() || !results.contains(kList)) {
    throw std::runtime_error(
        fmt::format("{}: has no list \"{}\"; run sim_host experiments of this version first", file.string(), kList));
  }
  return results;
}

}  // namespace

double worst_of(const Requirement& requirement) {
  const auto [low, high] = std::minmax_element(requirement.values.begin(), requirement.values.end());
  return requirement.bound == Bound::kAtMost ? *high : *low;
}

bool is_met(const Requirement& requirement) {
  return std::all_of(requirement.values.begin(), requirement.values.end(), [&](double value) {
    return requirement.bound == Bound::kAtMost ? value <= requirement.limit : value >= requirement.limit;
  });
}

std::string goal_text(const Requirement& requirement) {
  return fmt::format("{} {:.4g}", requirement.bound == Bound::kAtMost ? "<=" : ">=", requirement.limit);
}

bool record_requirements(const RequirementSource& source, const std::vector<Requirement>& requirements,
                         const std::filesystem::path& folder) {
  const std::filesystem::path file = folder / "results.json";
  if (!std::filesystem::exists(file)) {
    return false;
  }
  Json results = read_results(file);
  Json rows = Json::array();
  for (const Json& row : results[kList]) {
    if (row.at("command") != source.command) {
      rows.push_back(row);
    }
  }
  for (const Requirement& requirement : requirements) {
    rows.push_back(row_of(source, requirement));
  }
  results[kList] = rows;
  write_json(results, file);
  return true;
}

}  // namespace trackservo::sim
