// SPDX-License-Identifier: Apache-2.0
// The best possible PI, as the opponent of our controllers: found by search, within the margins that they keep.
#include <algorithm>
#include <cmath>
#include <nlopt.hpp>

#include "device/tracking_run.hpp"
#include "machine/run/scenario_run.hpp"
#include "studies/shared/study.hpp"

namespace trackservo::sim {
namespace {

// The search runs over logarithms, so that half and double are equally far.
PiRequirement requirement_of(const std::vector<double>& x) { return {std::exp(x[0]), std::exp(x[1]), x[2]}; }

struct Search {
  Study study;
  servo_params params;                            // with everything except the PI
  std::array<axis_parameters, kAxes> parameters;  // the same, as objects
};

// The measured margins count too, and a measurement can be lower than the computation by up to this.
constexpr double kGainReserve_db = 0.5;
constexpr double kPhaseReserve_deg = 2.0;

double lacking(double wanted, double got) { return std::max(0.0, (wanted - got) / wanted); }

// Contribution of one figure to the cost. In the start-up race a PI must meet our own limit of overshoot: every point
// above costs 10 ms.
double cost_of(const Study& study, const Figure& figure) {
  constexpr double kMaxStartOvershoot_percent = 10.0;
  if (figure.axis != kAzimuth) {
    return 0.0;
  }
  if (purpose_of(study.scenario) == Purpose::kStart && figure.metric == "overshoot") {
    return 10.0 * std::max(0.0, figure.value - kMaxStartOvershoot_percent);
  }
  if (figure.metric != deciding_metric(study)) {
    return 0.0;
  }
  // A start that never arrives costs its whole window.
  return std::isinf(figure.value) ? 1e3 * (study.scenario.duration_s - study.scenario.rest_s) : figure.value;
}

Trace run_of(const Search& search, double speed_rad_s, std::uint64_t seed) {
  const Study& study = search.study;
  if (study.scenario.kind == ScenarioKind::kTracking) {
    return run_tracking(NodeSetup(study.plant, search.parameters), study.scenario, seed);
  }
  return run_scenario({&study.plant, &study.scenario, speed_rad_s, search.params, seed});
}

double mean_cost(const Search& search) {
  double sum = 0.0;
  int count = 0;
  for (const StudyCase& study_case : cases_of(search.study)) {
    for (const std::uint64_t seed : {std::uint64_t{101}, std::uint64_t{102}}) {
      const Trace trace = run_of(search, study_case.speed_rad_s, seed);
      for (const Figure& figure : measure(search.study, study_case, trace)) {
        sum += cost_of(search.study, figure);
      }
      ++count;
    }
  }
  return sum / count;
}

// What NLopt minimises. A PI that violates a margin is not run: it costs more than any run, and more the worse it is.
double cost(const std::vector<double>& x, std::vector<double>&, void *data) {
  Search& search = *static_cast<Search *>(data);
  for (int axis = 0; axis < kAxes; ++axis) {
    set_pi(search.params, axis, requirement_of(x));
    set_pi(search.parameters[static_cast<std::size_t>(axis)], requirement_of(x));
    if (servo_axis_check(&search.params.axis[axis], SERVO_TICK_S, SERVO_PWM_PERIOD_S) != CONTROL_OK) {
      return 1e6;
    }
  }
  double broken = 0.0;
  for (int axis = 0; axis < kAxes; ++axis) {
    const Margins margins = worst_margins(search.study.plant, axis, search.params.axis[axis].speed);
    broken += lacking(kMinMargins.gain_margin_db + kGainReserve_db, margins.gain_margin_db);
    broken += lacking(kMinMargins.phase_margin_deg + kPhaseReserve_deg, margins.phase_margin_deg);
  }
  return broken > 0.0 ? 1e4 * (1.0 + broken) : mean_cost(search);
}

void minimise(nlopt::algorithm algorithm, int evaluations, Search& search, const PiRequirement& start,
              std::vector<double>& x) {
  nlopt::opt optimiser(algorithm, 3);
  const double centre = std::log(start.natural_frequency_rad_s);
  optimiser.set_lower_bounds({centre - 1.5, std::log(0.4), 0.2});
  optimiser.set_upper_bounds({centre + 3.5, std::log(4.0), 1.0});
  optimiser.set_maxeval(evaluations);
  optimiser.set_min_objective(cost, &search);
  double least = 0.0;
  optimiser.optimize(x, least);
}

}  // namespace

PiRequirement best_pi(const Study& study, const SearchEffort& effort) {
  const DesignOptions options = design_options(study);
  const ControllerSpec& spec = controller_spec("pi_best");
  Search search{study, design_controller(study.plant, spec, options), design_axes(study.plant, spec, options)};
  if (study.scenario.axes_move == AxesMove::kOneAtATime) {
    search.study.scenario.axes = {true, false};  // only the azimuth costs, and its runs do not see the pitch move
  }
  const PiRequirement start = pi_requirement(study.plant, kAzimuth, options);
  std::vector<double> x = {std::log(start.natural_frequency_rad_s), std::log(start.damping), start.setpoint_weight};
  minimise(nlopt::GN_DIRECT_L, effort.explore, search, start, x);
  minimise(nlopt::LN_NELDERMEAD, effort.refine, search, start, x);
  return requirement_of(x);
}

}  // namespace trackservo::sim
