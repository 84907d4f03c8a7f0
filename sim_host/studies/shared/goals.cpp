// SPDX-License-Identifier: Apache-2.0
#include "studies/shared/goals.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

namespace trackservo::sim {
namespace {

constexpr double kAnyValue = std::numeric_limits<double>::infinity();

Goal goal_between(double low, double high, int decimals) {
  if (low == -kAnyValue) {
    return {low, high, fmt::format("<= {:.{}f}", high, decimals)};
  }
  if (high == kAnyValue) {
    return {low, high, fmt::format(">= {:.{}f}", low, decimals)};
  }
  return {low, high, fmt::format("{:.{}f} .. {:.{}f}", low, decimals, high, decimals)};
}

// Where PI alone reproduces the paper's figure.
std::optional<Goal> calibration_band(const PaperFigure *figure, int decimals) {
  if (figure == nullptr || !figure->uncompensated || !figure->within_percent) {
    return std::nullopt;
  }
  const double value = *figure->uncompensated;
  const double tolerance = 0.01 * *figure->within_percent * value;
  return goal_between(value - tolerance, value + tolerance, decimals);
}

bool is_judged(const Cell& cell) { return cell.axis == kAzimuth && cell.friction == FrictionModel::kLugre; }

}  // namespace

std::optional<Goal> goal_of(const Cell& cell, const Experiment& experiment) {
  const auto is_for = [&](const GoalEntry& goal) {
    return goal.controller == cell.controller && goal.metric == cell.metric &&
           (goal.case_name.empty() || goal.case_name == cell.case_name);
  };
  const auto goal = std::find_if(experiment.goals.begin(), experiment.goals.end(), is_for);
  if (!is_judged(cell) || goal == experiment.goals.end()) {
    return std::nullopt;
  }
  if (!goal->low && !goal->high) {
    return calibration_band(paper_figure(experiment.paper, cell.case_name, cell.metric), goal->decimals);
  }
  return goal_between(goal->low.value_or(-kAnyValue), goal->high.value_or(kAnyValue), goal->decimals);
}

std::optional<bool> reproduces_paper(const Cell& cell, double value, const Experiment& experiment) {
  if (!is_judged(cell) || cell.controller != "pi") {
    return std::nullopt;
  }
  const std::optional<Goal> band = calibration_band(paper_figure(experiment.paper, cell.case_name, cell.metric), 0);
  return band ? std::optional<bool>(value >= band->low && value <= band->high) : std::nullopt;
}

}  // namespace trackservo::sim
