// Values reported by the paper and goals of this project, row by row of the result table.
#ifndef TRACKSERVO_SIM_STUDIES_SHARED_GOALS_HPP
#define TRACKSERVO_SIM_STUDIES_SHARED_GOALS_HPP

#include <optional>
#include <string>

#include "studies/shared/cell.hpp"

namespace trackservo::sim {

// Fig. 9: "the overshoot increases by 25 %", as points and as a ratio.
constexpr double kFig9Points = 25.0;
constexpr double kFig9Ratio = 1.25;

// The paper's published figures for a row (facts: Figs 7, 12, 14, 16 and Table 2).
struct PaperFigures {
  std::optional<double> uncompensated;
  std::optional<double> compensated;
};

struct Goal {
  double low;  // met when low <= value <= high
  double high;
  std::string text;
};

PaperFigures paper_figures(const Cell& cell);

// Goals are set for the azimuth axis on LuGre friction: calibration bands for "pi", results for "pi_vob_ftc".
std::optional<Goal> goal_of(const Cell& cell);

// Whether PI alone reproduces the value printed in the paper: within the calibration band, also where that is no goal
// because the plant cannot show it (Fig. 9). Nothing where the paper printed nothing, and for the other controllers.
std::optional<bool> reproduces_paper(const Cell& cell, double value);

}  // namespace trackservo::sim

#endif
