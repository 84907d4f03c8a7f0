// SPDX-License-Identifier: Apache-2.0
// A study is one scenario on one plant: the unit in which controllers are compared.
//
// `run_case` runs one case of it, `measure` computes the figures of merit of the run; `best_pi` finds the PI that does
// best in the study within the margins that every controller must keep. The kind of scenario decides what is measured,
// never its name, so a user's own scenario gets suitable figures.
#ifndef TRACKSERVO_SIM_STUDIES_SHARED_STUDY_HPP
#define TRACKSERVO_SIM_STUDIES_SHARED_STUDY_HPP

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "design/control_design.hpp"
#include "machine/config/scenario_config.hpp"
#include "machine/run/trace.hpp"

namespace trackservo::sim {

struct Study {
  std::string experiment;  // sine, step_disturbed, low_speed_start, steady_speed, tracking
  PlantConfig plant;
  ScenarioConfig scenario;
  tracker_kind tracker = TRACKER_PI;
  std::string figure;                         // the paper's figure that it reproduces: "fig7" ...; empty for none
  std::vector<FrictionModel> frictions;       // of the plant, on which a campaign runs it; friction-free is the floor
  std::optional<AssumedPlant> identified;     // basis of its controllers; none: friction parameters wrong by a share
  std::optional<AxesParameters> least_error;  // the controller of this name, if it was designed already
};

// Returns "steady_speed on tracker" and the like; distinguishes the two tracking loops.
std::string study_name(const Study& study);

std::string friction_name(FrictionModel model);

struct StudyCase {
  std::string name;    // for people: "0.1 deg/s"
  double speed_rad_s;  // 0 for tracking
};

// One figure of merit of one run, in the unit for people. Infinite: never arrived; NaN: nothing to measure. JSON has
// neither number; both are null.
struct Figure {
  int axis;
  std::string metric;
  std::string unit;
  double value;
};

std::vector<StudyCase> cases_of(const Study& study);

// Returns how the controllers of this study are designed.
DesignOptions design_options(const Study& study, std::uint64_t seed = 1, double friction_parameter_error = 0.15);

// Inputs of one run of a case.
struct RunChoice {
  const ControllerSpec *controller = nullptr;
  FrictionModel friction = FrictionModel::kLugre;  // of the plant
  std::uint64_t seed = 1;
  double friction_parameter_error = 0.15;
  std::optional<PiRequirement> pi;  // replaces the plant's own requirement
};

// Designs the controller and runs it. Throws like design_controller, run_scenario and run_tracking.
Trace run_case(const Study& study, const StudyCase& study_case, const RunChoice& choice);

// What a run of a scenario is analysed for.
enum class Purpose {
  kTracking,       // a target: line-of-sight error after settling
  kSteady,         // a sine, or a step with settle_s > 0: speed error after settling
  kStart,          // a step with settle_s = 0: time to 90 %, and overshoot in the first half second
  kDisturbedStep,  // the same with a sine of disturbing torque: overshoot over the whole run, because the sine
                   // continues
};

Purpose purpose_of(const ScenarioConfig& scenario);

// Returns the analysis of a run of this study.
std::vector<Figure> measure(const Study& study, const StudyCase& study_case, const Trace& trace);

// Returns the figures of merit that a run of the scenario gives, the one that decides first.
std::vector<std::string> metrics_of(const ScenarioConfig& scenario);

// Returns the figure that decides in this study (peak error, time to 90 %, overshoot, tracking sigma).
std::string deciding_metric(const Study& study);

// Numbers of evaluations of a search.
struct SearchEffort {
  int explore = 60;
  int refine = 50;
};

// Returns the PI that minimises the deciding metric (mean over cases, seeds 101 and 102, both unused elsewhere) within
// the margins, and within 10 % of overshoot at start-up. Deterministic. NLopt: DIRECT-L with `effort.explore`
// evaluations, then Nelder-Mead with `effort.refine`.
PiRequirement best_pi(const Study& study, const SearchEffort& effort = {});

}  // namespace trackservo::sim

#endif
