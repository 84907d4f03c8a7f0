// SPDX-License-Identifier: Apache-2.0
#include "check/figure.hpp"

#include <fmt/format.h>

#include <array>
#include <utility>

#include "judge/analysis/statistics.hpp"

namespace trackservo::sim {
namespace {

bool begins_with(const std::string& text, const char *begin) { return text.rfind(begin, 0) == 0; }

}  // namespace

std::string name_with_unit(const std::string& metric, const std::string& unit) {
  constexpr std::array<std::pair<const char *, const char *>, 5> kSpelled = {
      {{"deg/s", "deg_s"}, {"Nm", "nm"}, {"%", "percent"}, {"dB", "db"}, {"Hz", "hz"}}};
  for (const auto& [written, spelled] : kSpelled) {
    if (unit == written) {
      return fmt::format("{}_{}", metric, spelled);
    }
  }
  return fmt::format("{}_{}", metric, unit);
}

Better better_of(const std::string& name) {
  if (begins_with(name, "gain_margin") || begins_with(name, "phase_margin")) {
    return Better::kHigher;
  }
  return begins_with(name, "crossover") || begins_with(name, "bandwidth") ? Better::kNeither : Better::kLower;
}

const char *better_name(Better better) {
  switch (better) {
    case Better::kLower:
      return "lower";
    case Better::kHigher:
      return "higher";
    case Better::kNeither:
    default:
      return "neither";
  }
}

std::string text_of(const FigureKey& key) {
  return fmt::format("{}, {}, {}: {}", key.scenario, key.case_name, key.axis, key.name);
}

double mean_of(const CheckFigure& figure) { return mean(figure.values); }

}  // namespace trackservo::sim
