// SPDX-License-Identifier: Apache-2.0
#include "check/verdict.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "judge/analysis/statistics.hpp"

namespace trackservo::sim {
namespace {

std::string problem_of(const JudgedFigure& judged) {
  const Limit& limit = *judged.limit;
  const std::string& unit = judged.figure.unit;
  const std::string key = text_of(judged.figure.key);
  if (!std::isfinite(judged.value)) {
    const auto without = std::count_if(judged.figure.values.begin(), judged.figure.values.end(),
                                       [](double value) { return !std::isfinite(value); });
    return fmt::format("{} has no value in {} of {} seeds: {}", key, without, judged.figure.values.size(),
                       judged.figure.failure.value_or("it is not finite"));
  }
  const bool above = limit.max && judged.value > *limit.max;
  return fmt::format("{} = {:.4g} {} is {} the limit of {:.4g} {} ({})", key, judged.value, unit,
                     above ? "above" : "below", above ? *limit.max : *limit.min, unit, limit.place);
}

}  // namespace

std::vector<JudgedFigure> judge(const std::vector<CheckFigure>& figures, const Limits& limits) {
  std::vector<JudgedFigure> all;
  for (const CheckFigure& figure : figures) {
    JudgedFigure judged{figure, mean_of(figure), standard_deviation(figure.values), std::nullopt, true, ""};
    if (const Limit *limit = limits.find(figure.key)) {
      judged.limit = *limit;
      judged.kept = std::isfinite(judged.value) && judged.value >= limit->min.value_or(judged.value) &&
                    judged.value <= limit->max.value_or(judged.value);
      judged.problem = judged.kept ? "" : problem_of(judged);
    }
    all.push_back(std::move(judged));
  }
  return all;
}

bool all_kept(const std::vector<JudgedFigure>& judged) {
  return std::all_of(judged.begin(), judged.end(), [](const JudgedFigure& one) { return one.kept; });
}

std::string limit_text(const JudgedFigure& judged) {
  if (!judged.limit) {
    return "";
  }
  const Limit& limit = *judged.limit;
  if (limit.min && limit.max) {
    return fmt::format("{:.4g} to {:.4g}", *limit.min, *limit.max);
  }
  return limit.max ? fmt::format("max {:.4g}", *limit.max) : fmt::format("min {:.4g}", *limit.min);
}

}  // namespace trackservo::sim
