// SPDX-License-Identifier: Apache-2.0
// Test plans for machines of all sizes: the firmware accepts every experiment, and the axis stays within its limits.
#include "test_plan/test_plan_json.hpp"

#include <cmath>
#include <string>

#include "support/check.h"

using namespace trackservo::commissioning;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

struct Case {
  const char *name;
  MotionLimits limits;
  RoughMachine machine;
};

const Case kCases[] = {
    {"tracker azimuth", {-4.9, 4.9, 0.6, 40.0}, {6.0, 2e-4, 5.2e-3, 6.0}},
    {"tracker pitch", {-0.35, 1.66, 0.6, 24.0}, {3.0, 2.4e-4, 5.2e-3, 2.5}},
    {"the paper's soft bristles", {-3.1, 3.1, 0.6, 40.0}, {10.0, 3.2e-2, 8.7e-3, 23.5}},
    {"small and quick", {-3.1, 3.1, 6.0, 0.5}, {0.02, 1e-3, 0.02, 0.01}},
    {"half a thousand kg m2", {-1.0, 1.0, 0.3, 2000.0}, {200.0, 1e-4, 2e-3, 500.0}},
    {"a few degrees of travel", {-0.05, 0.05, 0.2, 40.0}, {6.0, 2e-4, 5.2e-3, 6.0}},
    {"a weak motor", {-1.0, 1.0, 0.6, 8.0}, {6.0, 2e-4, 5.2e-3, 6.0}},
    {"a slow axis", {-1.0, 1.0, 0.02, 40.0}, {6.0, 2e-4, 5.2e-3, 6.0}},
};

void expect_possible(const Case& machine, const TestPlan& test_plan) {
  TEST_ASSERT_TRUE_MESSAGE(test_plan.moving_rad_s <= machine.limits.rate_rad_s, machine.name);
  TEST_ASSERT_TRUE_MESSAGE(static_cast<double>(test_plan.limits.rate_rad_s) <= machine.limits.rate_rad_s * 1.000001,
                           machine.name);
  TEST_ASSERT_TRUE_MESSAGE(static_cast<double>(test_plan.limits.torque_nm) <= machine.limits.torque_nm * 1.000001,
                           machine.name);
  for (const Place& place : test_plan.places) {
    const double room_rad = static_cast<double>(test_plan.limits.travel_rad) * 0.999999;
    TEST_ASSERT_TRUE_MESSAGE(machine.limits.lowest_rad <= place.angle_rad - room_rad, machine.name);
    TEST_ASSERT_TRUE_MESSAGE(place.angle_rad + room_rad <= machine.limits.highest_rad, machine.name);
    for (const stimulus_setup& experiment : place.experiments) {
      const std::string which = std::string(machine.name) + ", kind " + std::to_string(experiment.kind);
      TEST_ASSERT_EQUAL_INT_MESSAGE(CONTROL_OK, experiment_check(&experiment, &test_plan.limits), which.c_str());
    }
  }
}

void test_the_firmware_takes_every_experiment_of_every_test_plan() {
  for (const Case& machine : kCases) {
    expect_possible(machine, first_look(machine.limits));
    expect_possible(machine, test_plan_for(machine.limits, machine.machine));
    expect_possible(machine, structure_look(machine.limits, machine.machine));
  }
}

void test_a_first_look_takes_about_a_minute_and_a_test_plan_some() {
  for (const Case& machine : {kCases[0], kCases[1], kCases[2]}) {
    CHECK_NEAR("first look, s", 80, duration_s(first_look(machine.limits), 0.0), 15);
    CHECK_NEAR("test plan, s", 540, duration_s(test_plan_for(machine.limits, machine.machine), 0.0), 200);
    CHECK_NEAR("chirps, s", 75, duration_s(structure_look(machine.limits, machine.machine), 0.0), 15);
  }
}

void test_speeds_and_loops_fit_the_machine() {
  const Case& tracker = kCases[0];
  const TestPlan test_plan = test_plan_for(tracker.limits, tracker.machine);
  double slowest_rad_s = 1e9;
  int loops = 0;
  for (const Place& place : test_plan.places) {
    for (const stimulus_setup& experiment : place.experiments) {
      if (experiment.kind == STIMULUS_SWEEP) {
        slowest_rad_s = std::min(slowest_rad_s, static_cast<double>(experiment.low_rad_s));
      }
      if (experiment.kind == STIMULUS_HYSTERESIS) {
        CHECK_NEAR("loop, bristle lengths", 3.0,
                   static_cast<double>(experiment.amplitude_rad) / tracker.machine.bristle_rad, 1e-4);
        ++loops;
      }
    }
  }
  CHECK_AT_MOST("slowest speed, Stribeck speeds", 0.2, slowest_rad_s / tracker.machine.stribeck_rad_s);
  TEST_ASSERT_EQUAL_INT(test_plan.places.size(), loops);
}

void expect_refusal(const MotionLimits& limits, const RoughMachine& machine, const char *said) {
  try {
    test_plan_for(limits, machine);
    TEST_FAIL_MESSAGE(said);
  } catch (const TestPlanError& error) {
    TEST_ASSERT_TRUE_MESSAGE(std::string(error.what()).find(said) != std::string::npos, error.what());
  }
}

void test_limits_without_room_and_machines_that_make_no_sense_are_refused() {
  const Case& good = kCases[0];
  MotionLimits limits = good.limits;
  limits.highest_rad = limits.lowest_rad + 0.01;
  expect_refusal(limits, good.machine, "the travel between lowest and highest joint angle [rad] is 0.01; give 0.02");
  limits = good.limits;
  limits.rate_rad_s = NAN;
  expect_refusal(limits, good.machine, "the speed limit [rad/s] is nan");
  RoughMachine machine = good.machine;
  machine.inertia_kg_m2 = 0.0;
  expect_refusal(good.limits, machine, "the rough inertia [kg m2] is 0; the range of machines is 1e-07");
}

void test_the_file_holds_what_the_device_is_reported() {
  const TestPlan test_plan = first_look(kCases[0].limits);
  const auto json = to_json(test_plan, 0.0);
  TEST_ASSERT_EQUAL_STRING("first_look", json.at("stage").get<std::string>().c_str());
  TEST_ASSERT_EQUAL_size_t(test_plan.places.size(), json.at("places").size());
  const auto& sweep = json.at("places").at(0).at("experiments").at(0);
  TEST_ASSERT_EQUAL_INT(STIMULUS_SWEEP, sweep.at("kind").get<int>());
  TEST_ASSERT_EQUAL_FLOAT(test_plan.places[0].experiments[0].low_rad_s, sweep.at("low_rad_s").get<float>());
  TEST_ASSERT_FALSE_MESSAGE(sweep.contains("amplitude_nm"), "a sweep uses no torque");
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_the_firmware_takes_every_experiment_of_every_test_plan);
  RUN_TEST(test_a_first_look_takes_about_a_minute_and_a_test_plan_some);
  RUN_TEST(test_speeds_and_loops_fit_the_machine);
  RUN_TEST(test_limits_without_room_and_machines_that_make_no_sense_are_refused);
  RUN_TEST(test_the_file_holds_what_the_device_is_reported);
  return UNITY_END();
}
