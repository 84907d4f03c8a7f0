// SPDX-License-Identifier: Apache-2.0
// Machines with known parameters for tests of the identification: which plant, which axis, which noise.
#ifndef TRACKSERVO_TESTS_COMMISSIONING_BENCH_HPP
#define TRACKSERVO_TESTS_COMMISSIONING_BENCH_HPP

#include <map>
#include <string>

#include "design/commissioning/acquisition.hpp"
#include "identification/identification.hpp"
#include "machine/config/plant_config.hpp"
#include "test_plan/test_plan.hpp"

namespace commissioning_bench {

namespace sim = trackservo::sim;
namespace identification = trackservo::identification;
namespace commissioning = trackservo::commissioning;

using sim::kRadPerDeg;

struct BenchSetup {
  sim::PlantConfig plant;
  int axis = sim::kAzimuth;
  std::uint64_t seed = 1;
  double pitch_rad = 0.3;  // held while azimuth moves
  std::string controller = "pi";
  bool gyro_recorded = true;
};

// The shipped plant of this name.
BenchSetup setup_of(const std::string& plant, int axis = sim::kAzimuth, std::uint64_t seed = 1);

// The plant's own numbers, like the result of a first look.
commissioning::RoughMachine rough_truth(const BenchSetup& setup);

// The main test plan for these numbers.
commissioning::TestPlan test_plan_of(const BenchSetup& setup);

identification::Recording record(const BenchSetup& setup, const commissioning::TestPlan& test_plan);

std::map<std::string, double> truth_of(const BenchSetup& setup, const identification::Identification& result);

// Allowed error of a value, as a logarithm: the project's limits.
double allowed_error(const std::string& parameter);

}  // namespace commissioning_bench

#endif
