// The bench of the closed-loop tests: shipped plants and scenarios, and the mean of a figure over seeds that no report
// uses. Tests run in the project's folder.
#ifndef TRACKSERVO_TESTS_CLOSED_LOOP_BENCH_HPP
#define TRACKSERVO_TESTS_CLOSED_LOOP_BENCH_HPP

#include <string>

#include "experiments/study.hpp"
#include "run/scenario_run.hpp"

namespace bench {

namespace sim = trackservo::sim;

constexpr double kRadPerDeg = sim::kPi / 180.0;

inline sim::Study study(const std::string& experiment, const std::string& plant, tracker_kind tracker = TRACKER_PI) {
  sim::Study study;
  study.experiment = experiment;
  study.plant = sim::load_plant("sim_host/plants/" + plant + ".toml");
  study.scenario = sim::load_scenario("sim_host/scenarios/" + experiment + ".toml");
  study.tracker = tracker;
  return study;
}

// Seeds 11 and 12: neither the report's (1 to 5) nor the optimiser's (101, 102).
inline double mean_figure(const sim::Study& study, const std::string& controller, std::size_t case_index,
                          const std::string& metric, int axis = sim::kAzimuth) {
  const sim::StudyCase study_case = sim::cases_of(study).at(case_index);
  double sum = 0.0;
  for (const std::uint64_t seed : {std::uint64_t{11}, std::uint64_t{12}}) {
    sim::DesignOptions options;
    options.seed = seed;
    options.tracker = study.tracker;
    const servo_params params = sim::design_controller(study.plant, sim::controller_spec(controller), options);
    const sim::Trace trace = sim::run_scenario({&study.plant, &study.scenario, study_case.speed_rad_s, params, seed});
    for (const sim::Figure& figure : sim::measure(study, study_case, trace)) {
      sum += figure.axis == axis && figure.metric == metric ? figure.value : 0.0;
    }
  }
  return sum / 2.0;
}

}  // namespace bench

#endif
