// SPDX-License-Identifier: Apache-2.0
// Judges a row of the result table by the goals and the paper's figures of its experiment.
#ifndef TRACKSERVO_SIM_STUDIES_SHARED_GOALS_HPP
#define TRACKSERVO_SIM_STUDIES_SHARED_GOALS_HPP

#include <optional>
#include <string>

#include "studies/shared/cell.hpp"
#include "studies/shared/experiment.hpp"

namespace trackservo::sim {

struct Goal {
  double low;  // met when low <= value <= high
  double high;
  std::string text;
};

// Returns the goal of a cell, if there is one. Goals are set for the azimuth axis on LuGre friction: calibration bands
// for "pi", results for the others.
std::optional<Goal> goal_of(const Cell& cell, const Experiment& experiment);

// Returns whether PI alone reproduces the value printed in the paper: within the calibration band, also where that is
// no goal because the plant cannot show it (Fig. 9). Nothing where the paper printed nothing, and for the other
// controllers.
std::optional<bool> reproduces_paper(const Cell& cell, double value, const Experiment& experiment);

}  // namespace trackservo::sim

#endif
