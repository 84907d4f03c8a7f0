// SPDX-License-Identifier: Apache-2.0
// The base's rates in the running node: a ship rolls, pitches and yaws under a target that stands, off to the side and
// high, so that every rate has its part in both axes. An inertial sensor on the base sends its rates over CAN.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "bench.hpp"
#include "support/check.h"
#include "tracking_bench.hpp"
#include "unity.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace sim = trackservo::sim;

namespace {

constexpr double kTarget_m = 1000.0;
constexpr double kAzimuth_rad = 40.0 * sim::kRadPerDeg;
constexpr double kPitch_rad = 50.0 * sim::kRadPerDeg;
constexpr double kSettle_s = 6.0;
constexpr double kFlight_s = 20.0;
constexpr double kUrad = 1e-6;

sim::BaseMotionLine turns(sim::BaseAxis axis, double amplitude_deg, double frequency_hz) {
  sim::BaseMotionLine line;
  line.axis = axis;
  line.amplitude_rad = amplitude_deg * sim::kRadPerDeg;
  line.frequency_hz = frequency_hz;
  return line;
}

sim::PlantConfig at_sea(sim::FeedbackSource feedback) {
  sim::PlantConfig plant = bench::tracker_setup().plant;
  plant.base_motion = {turns(sim::BaseAxis::kRoll, 1.0, 0.3), turns(sim::BaseAxis::kPitch, 0.5, 0.2),
                       turns(sim::BaseAxis::kYaw, 0.5, 0.15)};
  for (sim::DesignConfig& design : plant.design) {
    design.feedback = feedback;
  }
  return plant;
}

sim::ScenarioConfig standing_target() {
  sim::ScenarioConfig scenario = bench::tracking_scenario();
  scenario.camera.geometry = sim::CameraGeometry::kLineOfSight;
  scenario.fly_by = {};
  scenario.fly_by.start_position_m = {kTarget_m * std::cos(kPitch_rad) * std::cos(kAzimuth_rad),
                                      kTarget_m * std::cos(kPitch_rad) * std::sin(kAzimuth_rad),
                                      kTarget_m * std::sin(kPitch_rad)};
  scenario.duration_s = kFlight_s;
  return scenario;
}

// Of cross-elevation and elevation, the larger one.
double sigma_rad(sim::FeedbackSource feedback, bool base_sensor) {
  const sim::NodeSetup setup(at_sea(feedback));
  bench::TrackingNode tracking(setup, standing_target(), bench::kSeeds[0], bench::designed_tracker(TRACKER_PREDICTIVE),
                               base_sensor);
  bench::Spread spread;
  while (tracking.time_s() < kFlight_s) {
    if (tracking.time_s() > kSettle_s) {
      spread.add(tracking.error_rad());
    }
    tracking.tick();
  }
  return std::max(spread.sigma_rad()[sim::kAzimuth], spread.sigma_rad()[sim::kPitch]);
}

void expect(sim::FeedbackSource feedback, double with_rad, double without_rad) {
  const double with = sigma_rad(feedback, true);
  const double without = sigma_rad(feedback, false);
  char text[120];
  (void)std::snprintf(text, sizeof text, "1 sigma %.2f urad with base rates, %.2f urad without", with / kUrad,
                      without / kUrad);
  TEST_MESSAGE(text);
  CHECK_AT_MOST("with base rates, rad", with_rad, with);
  CHECK_AT_LEAST("without, rad", without_rad, without);
}

void test_a_gyro_on_the_stage_and_base_rates_hold_the_line_of_sight() {
  expect(sim::FeedbackSource::kGyro, 5.0 * kUrad, 100.0 * kUrad);
}

void test_base_rates_stand_in_for_gyros() { expect(sim::FeedbackSource::kEncoder, 14.0 * kUrad, 200.0 * kUrad); }

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_a_gyro_on_the_stage_and_base_rates_hold_the_line_of_sight);
  RUN_TEST(test_base_rates_stand_in_for_gyros);
  return UNITY_END();
}
