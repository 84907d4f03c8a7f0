// SPDX-License-Identifier: Apache-2.0
// One figure of a check over all seeds: "steady_speed, 0.1 deg/s, azimuth: rms_error_deg_s".
#ifndef TRACKSERVO_SIM_CHECK_FIGURE_HPP
#define TRACKSERVO_SIM_CHECK_FIGURE_HPP

#include <optional>
#include <string>
#include <tuple>
#include <vector>

namespace trackservo::sim {

enum class Better { kLower, kHigher, kNeither };

// Place of a figure; `name` ends with its unit.
struct FigureKey {
  std::string scenario;
  std::string case_name;
  std::string axis;
  std::string name;

  bool operator==(const FigureKey& other) const {
    return std::tie(scenario, case_name, axis, name) ==
           std::tie(other.scenario, other.case_name, other.axis, other.name);
  }
  bool operator<(const FigureKey& other) const {
    return std::tie(scenario, case_name, axis, name) <
           std::tie(other.scenario, other.case_name, other.axis, other.name);
  }
};

struct CheckFigure {
  FigureKey key;
  std::string unit;  // for people: "deg/s"
  Better better = Better::kLower;
  std::vector<double> values;          // one per seed; NaN where a run gave none
  std::optional<std::string> failure;  // the reason, of the first such run
};

// Returns the name of a metric with its unit: "rms_error" and "deg/s" give "rms_error_deg_s".
std::string name_with_unit(const std::string& metric, const std::string& unit);

// Returns the good direction of a figure, by its name with unit.
Better better_of(const std::string& name);

// Returns "lower", "higher", "neither".
const char *better_name(Better better);

// Returns "steady_speed, 0.1 deg/s, azimuth: rms_error_deg_s"
std::string text_of(const FigureKey& key);

// Returns the mean over the seeds; NaN when one of them has no value.
double mean_of(const CheckFigure& figure);

}  // namespace trackservo::sim

#endif
