// SPDX-License-Identifier: Apache-2.0
#include "studies/shared/derived.hpp"

#include <algorithm>
#include <limits>
#include <optional>

#include "judge/analysis/statistics.hpp"

namespace trackservo::sim {
namespace {

bool same_place(const Cell& a, const Cell& b) {
  return a.experiment == b.experiment && a.case_name == b.case_name && a.plant == b.plant && a.axis == b.axis &&
         a.metric == b.metric;
}

const Cell *find(const std::vector<Cell>& cells, const Cell& like, FrictionModel friction,
                 const std::string& controller) {
  const auto found = std::find_if(cells.begin(), cells.end(), [&](const Cell& c) {
    return same_place(c, like) && c.friction == friction && c.controller == controller;
  });
  return found == cells.end() ? nullptr : &*found;
}

// Relative to the mean of PI alone, so that one lucky seed of PI does not count as a result.
std::optional<Cell> reduction(const std::vector<Cell>& cells, const Cell& cell) {
  const bool counts = cell.metric == "peak_error" && cell.controller != "pi";
  const Cell *pi = counts ? find(cells, cell, cell.friction, "pi") : nullptr;
  if (pi == nullptr) {
    return std::nullopt;
  }
  Cell derived = cell;
  derived.metric = kReduction;
  derived.unit = "%";
  for (double& value : derived.values) {
    value = 100.0 * (1.0 - value / mean(pi->values));
  }
  return derived;
}

// Friction feedforward on a machine without friction is no fair reference: the friction-free run is that of the same
// loop without it.
std::string without_feedforward(const std::string& controller) {
  if (controller == "pi_vob_ftc" || controller == "least_error") {  // the same, where no wind is known
    return "pi_vob";
  }
  return controller == "pi_ftc" || controller == "pi_coulomb" ? "pi" : controller;
}

const Cell *friction_free(const std::vector<Cell>& cells, const Cell& cell) {
  const bool counts = cell.metric == "overshoot" && cell.friction != FrictionModel::kNone;
  return counts ? find(cells, cell, FrictionModel::kNone, without_feedforward(cell.controller)) : nullptr;
}

// The paper's "the overshoot increases by 25 %", read as a difference.
std::optional<Cell> above_friction_free(const std::vector<Cell>& cells, const Cell& cell) {
  const Cell *free = friction_free(cells, cell);
  if (free == nullptr) {
    return std::nullopt;
  }
  Cell derived = cell;
  derived.metric = kAboveFrictionFree;
  derived.unit = "points";
  for (std::size_t i = 0; i < derived.values.size(); ++i) {
    derived.values[i] -= free->values[i];
  }
  return derived;
}

// The same, read as a ratio; none when the overshoot is almost zero.
std::optional<Cell> over_friction_free(const std::vector<Cell>& cells, const Cell& cell) {
  const Cell *free = friction_free(cells, cell);
  if (free == nullptr) {
    return std::nullopt;
  }
  Cell derived = cell;
  derived.metric = kOverFrictionFree;
  derived.unit = "ratio";
  for (std::size_t i = 0; i < derived.values.size(); ++i) {
    const bool has_ratio = free->values[i] >= kMinFreeOvershoot;
    derived.values[i] = has_ratio ? cell.values[i] / free->values[i] : std::numeric_limits<double>::quiet_NaN();
  }
  return derived;
}

}  // namespace

std::vector<Cell> with_derived(const std::vector<Cell>& cells, const std::vector<Experiment>& experiments) {
  std::vector<Cell> all = cells;
  for (const Cell& cell : cells) {
    const std::vector<std::string>& wanted = experiment_named(cell.experiment, experiments).derived;
    for (const std::optional<Cell>& derived :
         {reduction(cells, cell), above_friction_free(cells, cell), over_friction_free(cells, cell)}) {
      if (derived && std::find(wanted.begin(), wanted.end(), derived->metric) != wanted.end()) {
        all.push_back(*derived);
      }
    }
  }
  return all;
}

}  // namespace trackservo::sim
