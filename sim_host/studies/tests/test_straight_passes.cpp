// The study of straight passes: its time-optimal plan, its judgement, and one seed of the passes with a goal.
#include "studies/straight_passes/straight_passes.hpp"

#include <cmath>
#include <limits>

#include "support/bench.hpp"
#include "support/check.h"

extern "C" void setUp(void) {}
extern "C" void tearDown(void) {}

namespace {

using namespace bench;

constexpr double kLimit_rad_s = 60.0 * kRadPerDeg;

PassConfig pass_at(double elevation_deg) { return {20.0, 500.0, elevation_deg * kRadPerDeg, 25.0, 0.0, 4.0}; }

void test_the_time_optimal_plan_is_none_below_the_limit_and_a_half_turn_at_the_zenith() {
  CHECK_SAME("26 deg/s", 0.0, optimal_lost_s(pass_at(85.0), kLimit_rad_s));
  CHECK_NEAR("zenith, s", 3.0, optimal_lost_s(pass_at(90.0), kLimit_rad_s), 1e-6);
  // Between them the azimuth grows in that time by exactly what the limit allows.
  const double lost_s = optimal_lost_s(pass_at(88.0), kLimit_rad_s);
  const double ahead_m = 500.0 / std::tan(88.0 * kRadPerDeg);
  CHECK_NEAR("azimuth, rad", kLimit_rad_s * lost_s, 2.0 * std::atan(10.0 * lost_s / ahead_m), 1e-9);
  CHECK_AT_LEAST("s", 0.5, lost_s);
}

void test_one_bad_seed_fails_a_goal() {
  PassResult result;
  result.choice = {500.0, 60.0, PassGoal::kSigma};
  result.runs = {{{4e-6, 4.9e-6}, 0.0, 0.0}, {{4.9e-6, 4e-6}, 0.0, 0.0}};
  TEST_ASSERT_TRUE(meets_goal(result));
  result.runs[1].sigma_rad[kPitch] = 5.1e-6;
  TEST_ASSERT_FALSE(meets_goal(result));
  result.choice.goal = PassGoal::kLost;
  result.optimal_lost_s = 1.0;
  result.runs[0].lost_s = 1.2;
  TEST_ASSERT_TRUE(meets_goal(result));
  result.runs[0].lost_s = std::numeric_limits<double>::infinity();
  TEST_ASSERT_FALSE(meets_goal(result));
}

void test_every_pass_meets_its_goal() {
  PassesSetup setup;
  setup.plant = shipped_plant("tracker");
  setup.scenario =
      load_scenario(std::string(TRACKSERVO_SOURCE_DIR) + "/sim_host/studies/straight_passes/scenario.toml");
  setup.seeds = {1};
  const std::vector<PassResult> results = run_passes(setup, [](int, int, const std::string&) {});
  TEST_ASSERT_EQUAL(shipped_passes().size(), results.size());
  print(setup, results);
  for (const PassResult& result : results) {
    TEST_ASSERT_EQUAL(1, result.runs.size());
    TEST_ASSERT_TRUE_MESSAGE(meets_goal(result), "a pass misses its goal; see the table above");
  }
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_the_time_optimal_plan_is_none_below_the_limit_and_a_half_turn_at_the_zenith);
  RUN_TEST(test_one_bad_seed_fails_a_goal);
  RUN_TEST(test_every_pass_meets_its_goal);
  return UNITY_END();
}
