// SPDX-License-Identifier: Apache-2.0
// Margins of the speed loops: they show a wrong gain before it is visible above the noise of a run.
//
// Computed from the gains and the plant's numbers, without noise; and measured on the simulated machine with the
// firmware as built, so that changes in the firmware are included.
#ifndef TRACKSERVO_SIM_CHECK_LOOP_FIGURES_HPP
#define TRACKSERVO_SIM_CHECK_LOOP_FIGURES_HPP

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "studies/shared/study.hpp"

namespace trackservo::sim {

struct LoopCase {
  std::string name;  // "computed, sliding"
  int axis;
  bool pre_sliding;
  bool measured;
};

std::vector<LoopCase> loop_cases();

struct LoopFigures {
  std::vector<Figure> figures;         // NaN after a failure
  std::optional<std::string> failure;  // the loop is unstable
};

// Returns the same figures without values.
std::vector<Figure> unknown_loop_figures(const LoopCase& loop_case);

LoopFigures loop_figures(const PlantConfig& plant, const servo_params& params, const LoopCase& loop_case,
                         std::uint64_t seed);

}  // namespace trackservo::sim

#endif
