// SPDX-License-Identifier: Apache-2.0
#include "check/loop_figures.hpp"

#include <limits>

#include "design/loop_margins.hpp"
#include "design/margin_measurement.hpp"

namespace trackservo::sim {
namespace {

constexpr double kNoValue = std::numeric_limits<double>::quiet_NaN();

// As in the margin study.
FrequencyResponse computed_response(const LinearMachine& machine, const speed_loop_params& loop) {
  return computed_loop_gain(machine, loop, log_space(0.05, 450.0, 2000));
}

bool has_bandwidth(const LoopCase& loop_case) { return !loop_case.measured && !loop_case.pre_sliding; }

}  // namespace

std::vector<LoopCase> loop_cases() {
  std::vector<LoopCase> cases;
  for (int axis = 0; axis < kAxes; ++axis) {
    cases.push_back({"computed, sliding", axis, false, false});
    cases.push_back({"computed, pre-sliding", axis, true, false});
    cases.push_back({"measured, sliding", axis, false, true});
  }
  return cases;
}

std::vector<Figure> unknown_loop_figures(const LoopCase& loop_case) {
  const int axis = loop_case.axis;
  std::vector<Figure> figures = {{axis, "gain_margin", "dB", kNoValue},
                                 {axis, "phase_margin", "deg", kNoValue},
                                 {axis, "crossover", "Hz", kNoValue}};
  if (has_bandwidth(loop_case)) {
    figures.push_back({axis, "bandwidth", "Hz", kNoValue});
  }
  return figures;
}

LoopFigures loop_figures(const PlantConfig& plant, const servo_params& params, const LoopCase& loop_case,
                         std::uint64_t seed) {
  const int axis = loop_case.axis;
  const speed_loop_params& loop = params.axis[axis].speed;
  const LinearMachine machine = linear_machine(plant, axis, loop_case.pre_sliding);
  const FrequencyResponse computed = computed_response(machine, loop);
  LoopFigures found{unknown_loop_figures(loop_case), std::nullopt};
  if (!is_stable_in_closed_loop(computed)) {
    found.failure = "the speed loop is unstable";
    return found;
  }
  Margins margins = margins_of(computed);
  if (loop_case.measured) {
    margins = margins_of(measured_near_crossover(plant, params, axis, loop_case.pre_sliding, margins, seed));
  }
  found.figures[0].value = margins.gain_margin_db;
  found.figures[1].value = margins.phase_margin_deg;
  found.figures[2].value = margins.crossover_hz;
  if (has_bandwidth(loop_case)) {
    found.figures[3].value = closed_loop_bandwidth_hz(machine, loop);
  }
  return found;
}

}  // namespace trackservo::sim
