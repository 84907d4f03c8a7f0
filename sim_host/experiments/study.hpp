// A study is one scenario on one plant: the unit in which controllers are compared.
//
// `measure` turns one run into its figures of merit; `best_pi` finds the PI that does best in the study within the
// margins that every controller must keep.
#ifndef TRACKSERVO_SIM_EXPERIMENTS_STUDY_HPP
#define TRACKSERVO_SIM_EXPERIMENTS_STUDY_HPP

#include <filesystem>
#include <string>
#include <vector>

#include "experiments/control_design.hpp"
#include "run/scenario_run.hpp"

namespace trackservo::sim {

struct Study {
  std::string experiment;  // sine, step_disturbed, low_speed_start, steady_speed, tracking
  PlantConfig plant;
  ScenarioConfig scenario;
  tracker_kind tracker = TRACKER_PI;
  std::string figure;  // the paper's figure that it reproduces: "fig7" ...; empty for none
};

struct StudyCase {
  std::string name;    // as people read it: "0.1 deg/s"
  double speed_rad_s;  // 0 for tracking
};

// One figure of merit of one run, in the unit that people read.
struct Figure {
  int axis;
  std::string metric;
  std::string unit;
  double value;
};

std::vector<StudyCase> cases_of(const Study& study);

// The analysis of a run of this study.
std::vector<Figure> measure(const Study& study, const StudyCase& study_case, const Trace& trace);

// The figure that decides in this study (peak error, time to 90 %, overshoot, tracking sigma).
std::string deciding_metric(const Study& study);

// The PI that minimises the deciding metric (mean over cases, seeds 101 and 102, both unused elsewhere) within the
// margins, and within 10 % of overshoot at start-up. Deterministic. NLopt: DIRECT-L, then Nelder-Mead.
PiWish best_pi(const Study& study);

}  // namespace trackservo::sim

#endif
