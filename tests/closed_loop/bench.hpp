// SPDX-License-Identifier: Apache-2.0
// The bench of the closed-loop tests: shipped plants and scenarios, and the mean of a figure over seeds that no report
// uses. Tests run in the project's folder.
#ifndef TRACKSERVO_TESTS_CLOSED_LOOP_BENCH_HPP
#define TRACKSERVO_TESTS_CLOSED_LOOP_BENCH_HPP

#include <cstdint>
#include <iterator>
#include <string>
#include <vector>

#include "judge/analysis/statistics.hpp"
#include "machine/run/scenario_run.hpp"
#include "studies/shared/study.hpp"
#include "unity.h"

namespace bench {

namespace sim = trackservo::sim;

using sim::kRadPerDeg;

inline sim::Study study(const std::string& experiment, const std::string& plant, tracker_kind tracker = TRACKER_PI) {
  sim::Study study;
  study.experiment = experiment;
  study.plant = sim::load_plant("sim_host/plants/" + plant + ".toml");
  study.scenario = sim::load_scenario("sim_host/scenarios/" + experiment + ".toml");
  study.tracker = tracker;
  return study;
}

// Neither the report's (1 to 5) nor the optimiser's (101, 102).
constexpr std::uint64_t kSeeds[] = {11, 12};

inline sim::Trace run(const sim::Study& study, const std::string& controller, std::size_t case_index,
                      std::uint64_t seed) {
  sim::RunChoice choice;
  choice.controller = &sim::controller_spec(controller);
  choice.friction = study.plant.friction_model;
  choice.seed = seed;
  return sim::run_case(study, sim::cases_of(study).at(case_index), choice);
}

inline double mean_figure(const sim::Study& study, const std::string& controller, std::size_t case_index,
                          const std::string& metric, int axis = sim::kAzimuth) {
  const sim::StudyCase study_case = sim::cases_of(study).at(case_index);
  std::vector<double> values;
  for (const std::uint64_t seed : kSeeds) {
    const sim::Trace trace = run(study, controller, case_index, seed);
    for (const sim::Figure& figure : sim::measure(study, study_case, trace)) {
      if (figure.axis == axis && figure.metric == metric) {
        values.push_back(figure.value);
      }
    }
  }
  TEST_ASSERT_EQUAL_INT_MESSAGE(std::size(kSeeds), values.size(), metric.c_str());
  return sim::mean(values);
}

}  // namespace bench

#endif
