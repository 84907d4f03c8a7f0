// SPDX-License-Identifier: Apache-2.0
// Tracking in the running node: the camera's frames come as PDOs, and both axes are in mode -1. `sim_host
// node-tracking` has more seeds.
#include <string>

#include "bench.hpp"
#include "studies/node_tracking/node_tracking.hpp"
#include "support/test_size.h"
#include "unity.h"

namespace sim = trackservo::sim;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

void test_every_target_is_tracked_as_well_as_required() {
  sim::NodeTrackingSetup setup;
  setup.plant = sim::load_plant("sim_host/plants/tracker.toml");
  const std::vector<sim::NodeTrackingCase> shipped = sim::shipped_node_tracking(setup.plant, "sim_host");
  for (std::size_t i = 0; i < shipped.size(); i += static_cast<std::size_t>(by_size(4, 1, 1))) {
    setup.cases.push_back(shipped[i]);
  }
  setup.seeds.assign(std::begin(bench::kSeeds), std::begin(bench::kSeeds) + by_size(1, 2, 2));
  const std::vector<sim::NodeTrackingResult> results =
      sim::run_node_tracking(setup, [](int, int, const std::string&) {});
  sim::print(setup, results);
  TEST_ASSERT_EQUAL(setup.cases.size(), results.size());
  for (const sim::NodeTrackingResult& result : results) {
    TEST_ASSERT_EQUAL(setup.seeds.size(), result.runs.size());
    TEST_ASSERT_TRUE_MESSAGE(sim::meets_goal(result), result.tried.name.c_str());
  }
}

sim::NodeTrackingResult one_run(const sim::NodeTrackingRun& run) {
  sim::NodeTrackingResult result;
  result.tried.goal = {std::array<double, 2>{2e-6, 3e-6}, 1.1, 2.0, 1.5};
  result.runs = {run};
  return result;
}

void test_each_figure_alone_fails_a_goal() {
  const sim::NodeTrackingRun good{{2e-6, 3e-6}, {2e-6, 2.8e-6}, 2.0, 1.5, 0};
  TEST_ASSERT_TRUE(sim::meets_goal(one_run(good)));
  sim::NodeTrackingRun bad = good;
  bad.sigma_rad[1] = 3.01e-6;
  TEST_ASSERT_FALSE(sim::meets_goal(one_run(bad)));
  bad = good;
  bad.reference_sigma_rad[0] = 1.8e-6;
  TEST_ASSERT_FALSE(sim::meets_goal(one_run(bad)));
  bad = good;
  bad.step_nm = 2.01;
  TEST_ASSERT_FALSE(sim::meets_goal(one_run(bad)));
  bad = good;
  bad.lost_s = 1.51;
  TEST_ASSERT_FALSE(sim::meets_goal(one_run(bad)));
  bad = good;
  bad.dropped = 1;
  TEST_ASSERT_FALSE(sim::meets_goal(one_run(bad)));
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_every_target_is_tracked_as_well_as_required);
  RUN_TEST(test_each_figure_alone_fails_a_goal);
  return UNITY_END();
}
