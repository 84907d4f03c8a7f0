// SPDX-License-Identifier: Apache-2.0
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
  CHECK_SAME("26 deg/s", 0.0, optimal_lost_s(pass_at(85.0), {kLimit_rad_s}));
  CHECK_NEAR("zenith, s", 3.0, optimal_lost_s(pass_at(90.0), {kLimit_rad_s}), 2e-3);
  CHECK_NEAR("zenith, 1 rad/s2, s", 3.0 + kLimit_rad_s, optimal_lost_s(pass_at(90.0), {kLimit_rad_s, 1.0}), 2e-3);
  // Between them it begins where the target reaches the limit, and the azimuth grows by what the limit allows.
  const double lost_s = optimal_lost_s(pass_at(88.0), {kLimit_rad_s});
  const double tau_s = 500.0 / std::tan(88.0 * kRadPerDeg) / 20.0;
  const double begin_s = -tau_s * std::sqrt(1.0 / (tau_s * kLimit_rad_s) - 1.0);
  CHECK_NEAR("azimuth, rad", kLimit_rad_s * lost_s, std::atan((begin_s + lost_s) / tau_s) - std::atan(begin_s / tau_s),
             2e-3);
  CHECK_AT_LEAST("s", 0.5, lost_s);
  CHECK_AT_LEAST("with 1 rad/s2, s", lost_s, optimal_lost_s(pass_at(88.0), {kLimit_rad_s, 1.0}));
}

// The azimuth of the target on both sides of a turn at the limit, from any beginning.
void test_no_plan_that_begins_earlier_is_shorter() {
  const double tau_s = 500.0 / std::tan(88.5 * kRadPerDeg) / 20.0;
  const double lost_s = optimal_lost_s(pass_at(88.5), {kLimit_rad_s});
  const double too_fast_from_s = -tau_s * std::sqrt(1.0 / (tau_s * kLimit_rad_s) - 1.0);
  for (int i = 0; - 3.0 + 0.01 * i < too_fast_from_s; ++i) {
    const double begin_s = -3.0 + 0.01 * i;
    double end_s = 0.0;
    while (std::atan(end_s / tau_s) - std::atan(begin_s / tau_s) > kLimit_rad_s * (end_s - begin_s) ||
           1.0 / (tau_s * (1.0 + end_s * end_s / tau_s / tau_s)) > kLimit_rad_s) {
      end_s += 1e-3;
    }
    CHECK_AT_LEAST("s", lost_s - 5e-3, end_s - begin_s);
  }
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
  RUN_TEST(test_no_plan_that_begins_earlier_is_shorter);
  RUN_TEST(test_one_bad_seed_fails_a_goal);
  RUN_TEST(test_every_pass_meets_its_goal);
  return UNITY_END();
}
