// SPDX-License-Identifier: Apache-2.0
// Combinations of scenario and plant: starts, courses, torques and speeds that make no sense, or that are unusual.
#include "machine/run/scenario_check.hpp"

#include <cmath>

#include "support/bench.hpp"
#include "support/check.h"

extern "C" void setUp(void) {}
extern "C" void tearDown(void) {}

namespace {

using namespace bench;

std::string refusal(const PlantConfig& plant, const ScenarioConfig& scenario) {
  try {
    check_scenario(plant, scenario);
  } catch (const ConfigError& error) {
    return error.what();
  }
  return "";
}

void check_says(const std::string& text, const std::string& part) {
  TEST_ASSERT_TRUE_MESSAGE(text.find(part) != std::string::npos, (part + " in: " + text).c_str());
}

// The warnings about this key; there must be no others.
std::size_t warnings_of(const char *key, const PlantConfig& plant, const ScenarioConfig& scenario) {
  const std::vector<std::string> warnings = check_scenario(plant, scenario);
  for (const std::string& warning : warnings) {
    check_says(warning, key);
  }
  return warnings.size();
}

void test_shipped_scenarios_need_no_warning_on_their_plants() {
  for (const char *name : {"low_speed_start", "steady_speed", "tracking"}) {
    TEST_ASSERT_EQUAL_MESSAGE(0, check_scenario(shipped_plant("tracker"), shipped_scenario(name)).size(), name);
  }
  for (const char *name : {"sine", "step_disturbed"}) {
    TEST_ASSERT_EQUAL_MESSAGE(0, check_scenario(shipped_plant("paper_simulation"), shipped_scenario(name)).size(),
                              name);
  }
}

void test_a_start_beyond_the_end_stops_is_refused_with_its_line() {
  const PlantConfig plant = shipped_plant("tracker");
  ScenarioConfig scenario = shipped_scenario("low_speed_start");
  scenario.initial_joint_angle_rad[kPitch] = 95.1 * kRadPerDeg;
  check_says(
      refusal(plant, scenario),
      "low_speed_start.toml:10: initial_pitch_deg: a start at 95.1 deg is beyond the end stops of tracker's pitch, "
      "-20 and 95 deg, start between these angles");
  scenario.initial_joint_angle_rad = {-281.0 * kRadPerDeg, 0.0};
  check_says(refusal(plant, scenario), "low_speed_start.toml:9: initial_azimuth_deg: a start at -281 deg");
  ScenarioConfig below = shipped_scenario("tracking");
  below.fly_by.start_position_m = {3000.0, 40.0, -2000.0};
  check_says(refusal(plant, below), "fly_by.start_position_m: a start at");
}

void test_a_target_straight_above_or_going_round_is_refused() {
  const PlantConfig plant = shipped_plant("tracker");
  ScenarioConfig scenario = shipped_scenario("tracking");
  scenario.fly_by = FlyByConfig{};
  scenario.fly_by.start_position_m = {300.0, 0.5, 150.0};
  scenario.fly_by.velocity_m_s = {-20.0, 0.0, 0.0};
  check_says(refusal(plant, scenario), "directly above the tracker at 14.9");
  scenario.fly_by.start_position_m = {0.0, 0.0, 150.0};
  scenario.fly_by.velocity_m_s = {0.0, 0.0, 0.0};
  check_says(refusal(plant, scenario), "directly above the tracker at 0 s");
  scenario.fly_by.start_position_m = {2.0, 0.0, 150.0};
  scenario.fly_by.weave_lateral_m = 0.0;
  TEST_ASSERT_EQUAL_STRING("", refusal(plant, scenario).c_str());
  // Across behind the tracker's back, with a first bearing of 170 deg.
  scenario.fly_by.start_position_m = {-100.0, 17.6, 50.0};
  scenario.fly_by.velocity_m_s = {10.0, -5.0, 0.0};
  scenario.fly_by.weave_lateral_m = 100.0;
  scenario.fly_by.weave_lateral_period_s = 10.0;
  check_says(refusal(plant, scenario), "half a turn around the tracker");
}

void test_a_target_that_leaves_the_travel_is_a_warning() {
  PlantConfig plant = shipped_plant("tracker");
  plant.axis[kPitch].end_stops->upper_rad = 3.5 * kRadPerDeg;
  TEST_ASSERT_EQUAL(1, warnings_of("fly_by: the target moves beyond the end stops of tracker's pitch", plant,
                                   shipped_scenario("tracking")));
}

void test_slow_cameras_are_a_warning() {
  ScenarioConfig scenario = shipped_scenario("tracking");
  scenario.camera.frame_rate_hz = 16.0;
  TEST_ASSERT_EQUAL(1, warnings_of("camera.frame_rate_hz", shipped_plant("tracker"), scenario));
  scenario.camera.frame_rate_hz = 17.0;
  TEST_ASSERT_EQUAL(0, check_scenario(shipped_plant("tracker"), scenario).size());
}

void test_speeds_that_end_at_the_stops_or_beyond_motor_and_gyro_are_warnings() {
  const PlantConfig plant = shipped_plant("tracker");
  ScenarioConfig scenario = shipped_scenario("steady_speed");
  scenario.axes = {true, false};
  scenario.initial_joint_angle_rad = {0.0, 0.0};
  const auto count = [&](double speed_deg_s) {
    scenario.speeds_rad_s = {speed_deg_s * kRadPerDeg};
    return warnings_of("speeds_deg_s", plant, scenario);
  };
  TEST_ASSERT_EQUAL(0, count(280.0 / 23.0 - 0.01));
  TEST_ASSERT_EQUAL(1, count(280.0 / 23.0 + 0.01));
  TEST_ASSERT_EQUAL(0, count(-280.0 / 23.0 + 0.01));
  TEST_ASSERT_EQUAL(1, count(-280.0 / 23.0 - 0.01));
  TEST_ASSERT_EQUAL(2, count(500.0));                          // and the gyro's 490 deg/s
  TEST_ASSERT_EQUAL(3, count(48.0 / 2.5 / kRadPerDeg + 1.0));  // and the supply
  ScenarioConfig sine = shipped_scenario("sine");
  sine.axes = {true, false};
  sine.frequency_hz = 0.1;  // 2 A / w = 280 deg
  sine.speeds_rad_s = {(140.0 * 2.0 * kPi * 0.1 - 0.1) * kRadPerDeg};
  TEST_ASSERT_EQUAL(0, warnings_of("speeds_deg_s", plant, sine));
  sine.speeds_rad_s = {(140.0 * 2.0 * kPi * 0.1 + 0.1) * kRadPerDeg};
  TEST_ASSERT_EQUAL(1, warnings_of("speeds_deg_s", plant, sine));
}

void test_torques_that_the_motor_cannot_give_are_warnings() {
  PlantConfig plant = shipped_plant("tracker");
  CHECK_NEAR("limited by the drive in Nm", 16.0 * 2.5, available_torque_nm(plant, kAzimuth), 1e-9);
  ScenarioConfig step = shipped_scenario("step_disturbed");
  step.axes = {true, false};
  step.initial_joint_angle_rad = {0.0, 0.0};
  step.disturbance_frequency_hz = 10.0;
  step.disturbance_amplitude_rad_s = 0.99 * 40.0 / (6.0 * 2.0 * kPi * 10.0);
  TEST_ASSERT_EQUAL(0, check_scenario(plant, step).size());
  step.disturbance_amplitude_rad_s = 1.01 * 40.0 / (6.0 * 2.0 * kPi * 10.0);
  TEST_ASSERT_EQUAL(1, warnings_of("disturbance_amplitude_deg_s: needs 40.4 Nm", plant, step));

  ScenarioConfig quiet = shipped_scenario("low_speed_start");
  plant.axis[kPitch].friction.negative.breakaway_nm = 24.0 / 1.07;  // 24 Nm with both eccentricities
  TEST_ASSERT_EQUAL(0, check_scenario(plant, quiet).size());
  plant.axis[kPitch].friction.negative.breakaway_nm = 24.1 / 1.07;
  TEST_ASSERT_EQUAL(1, warnings_of("pitch.friction.negative.breakaway_nm: the seal's largest holding torque is 24.1 Nm",
                                   plant, quiet));
  plant.friction_model = FrictionModel::kNone;
  TEST_ASSERT_EQUAL(0, check_scenario(plant, quiet).size());

  plant.supply.voltage_v = 12.5;
  CHECK_NEAR("limited by the supply in Nm", 10.0 * 2.5, available_torque_nm(plant, kAzimuth), 1e-9);
}

void test_less_than_a_period_of_a_sine_is_a_warning() {
  ScenarioConfig scenario = shipped_scenario("sine");
  scenario.duration_s = 20.0;  // one period after one to settle
  TEST_ASSERT_EQUAL(0, check_scenario(shipped_plant("paper_simulation"), scenario).size());
  scenario.duration_s = 19.9;
  TEST_ASSERT_EQUAL(1, warnings_of("duration_s: analyses only 9.9 s", shipped_plant("paper_simulation"), scenario));
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_shipped_scenarios_need_no_warning_on_their_plants);
  RUN_TEST(test_a_start_beyond_the_end_stops_is_refused_with_its_line);
  RUN_TEST(test_a_target_straight_above_or_going_round_is_refused);
  RUN_TEST(test_a_target_that_leaves_the_travel_is_a_warning);
  RUN_TEST(test_slow_cameras_are_a_warning);
  RUN_TEST(test_speeds_that_end_at_the_stops_or_beyond_motor_and_gyro_are_warnings);
  RUN_TEST(test_torques_that_the_motor_cannot_give_are_warnings);
  RUN_TEST(test_less_than_a_period_of_a_sine_is_a_warning);
  return UNITY_END();
}
