// SPDX-License-Identifier: Apache-2.0
// Which runs count as controlled, on traces made for the test.
#include "judge/analysis/verdict.hpp"

#include <cmath>
#include <functional>
#include <limits>

#include "support/bench.hpp"
#include "support/check.h"

extern "C" void setUp(void) {}
extern "C" void tearDown(void) {}

namespace {

using namespace bench;

constexpr double kSetPoint_rad_s = 2.0 * kRadPerDeg;

// Azimuth turns at `rate` of the time after the rest, pitch follows.
std::vector<std::string> verdict(const char *scenario_name, const std::function<double(double)>& rate) {
  ScenarioConfig scenario = shipped_scenario(scenario_name);
  scenario.duration_s = scenario.rest_s + scenario.settle_s + 1.0;
  Trace trace;
  for (int tick = 0; tick * kTick_s < scenario.duration_s; ++tick) {
    TraceRow row{};
    row.time_s = tick * kTick_s;
    for (AxisRow& axis : row.axis) {
      axis.reference_rad_s = row.time_s < scenario.rest_s ? 0.0 : kSetPoint_rad_s;
      axis.rate_rad_s = axis.joint_rate_rad_s = axis.reference_rad_s;
    }
    if (row.time_s >= scenario.rest_s) {
      row.axis[kAzimuth].rate_rad_s = row.axis[kAzimuth].joint_rate_rad_s = rate(row.time_s - scenario.rest_s);
    }
    trace.push_back(row);
  }
  return uncontrolled_axes(shipped_plant("tracker"), scenario, kSetPoint_rad_s, trace);
}

void check_one(const std::vector<std::string>& sentences, const char *part) {
  TEST_ASSERT_EQUAL(1, sentences.size());
  TEST_ASSERT_TRUE_MESSAGE(sentences[0].find(part) != std::string::npos, sentences[0].c_str());
  TEST_ASSERT_TRUE_MESSAGE(sentences[0].find("tracker.toml:") != std::string::npos, sentences[0].c_str());
  TEST_ASSERT_TRUE_MESSAGE(sentences[0].find(", give at ") != std::string::npos, sentences[0].c_str());
}

void test_an_axis_near_its_set_point_is_controlled() {
  TEST_ASSERT_EQUAL(0, verdict("steady_speed", [](double) { return kSetPoint_rad_s; }).size());
  TEST_ASSERT_EQUAL(0, verdict("steady_speed", [](double) { return 0.55 * kSetPoint_rad_s; }).size());
}

void test_more_than_half_of_the_set_point_is_too_far_from_it() {
  check_one(verdict("steady_speed", [](double) { return 0.45 * kSetPoint_rad_s; }), "its rms error is 1.1 deg/s");
}

void test_over_speed_counts_wherever_it_comes() {
  check_one(verdict("steady_speed", [](double t) { return t < 0.01 ? 2.0 : kSetPoint_rad_s; }), "it reaches 115 deg/s");
}

void test_what_is_not_a_number_is_not_controlled() {
  check_one(verdict("steady_speed", [](double) { return std::numeric_limits<double>::quiet_NaN(); }), "not finite");
}

void test_a_start_may_take_its_time_but_must_arrive() {
  TEST_ASSERT_EQUAL(0,
                    verdict("low_speed_start", [](double t) { return t < 0.6 ? 0.0 : 0.95 * kSetPoint_rad_s; }).size());
  check_one(verdict("low_speed_start", [](double) { return 0.85 * kSetPoint_rad_s; }),
            "it does not reach 90 % of 2 deg/s");
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_an_axis_near_its_set_point_is_controlled);
  RUN_TEST(test_more_than_half_of_the_set_point_is_too_far_from_it);
  RUN_TEST(test_over_speed_counts_wherever_it_comes);
  RUN_TEST(test_what_is_not_a_number_is_not_controlled);
  RUN_TEST(test_a_start_may_take_its_time_but_must_arrive);
  return UNITY_END();
}
