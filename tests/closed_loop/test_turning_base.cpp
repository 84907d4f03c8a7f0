// SPDX-License-Identifier: Apache-2.0
// A base that turns: isolation against the linear loop of the textbook, the line of sight while tracking, and the
// azimuth's margins over the pitch.
#include <algorithm>
#include <cmath>
#include <complex>
#include <cstdio>
#include <cstring>
#include <stdexcept>
#include <string>
#include <vector>

#include "bench.hpp"
#include "design/control_design.hpp"
#include "machine/run/scenario_check.hpp"
#include "studies/base_motion/base_motion.hpp"
#include "studies/node_tracking/node_tracking.hpp"
#include "support/check.h"
#include "support/test_size.h"
#include "unity.h"

namespace sim = trackservo::sim;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using sim::kRadPerDeg;
using Complex = std::complex<double>;

sim::PlantConfig tracker_plant() { return sim::load_plant("sim_host/plants/tracker.toml"); }

double decibel(Complex gain) { return 20.0 * std::log10(std::abs(gain)); }

// PI on an inertia, continuous and without delays, from the requirements of the plant: kp, ki and J.
struct Textbook {
  double kp, ki, inertia_kg_m2, viscous_nm_s_rad;

  Complex controller(Complex s) const { return kp + ki / s; }

  // Inertial rate over the base's, with feedback of the inertial rate: only the seal's friction moves the axis.
  Complex with_gyro(Complex s) const {
    return viscous_nm_s_rad / (inertia_kg_m2 * s + viscous_nm_s_rad + controller(s));
  }

  // With feedback of joint rate + lowpass(gyro - joint rate): above the crossover the axis turns with the base.
  Complex fused(Complex s, double crossover_rad_s) const {
    const Complex unseen = s / (s + crossover_rad_s);
    return (viscous_nm_s_rad + controller(s) * unseen) / (inertia_kg_m2 * s + viscous_nm_s_rad + controller(s));
  }
};

Textbook textbook_of(const sim::PlantConfig& plant, int axis) {
  const sim::PiRequirement pi = sim::pi_requirement(plant, axis, {});
  const double inertia_kg_m2 = sim::axis_inertia_kg_m2(plant, axis, 0.0);
  const double w = pi.natural_frequency_rad_s;
  return {2.0 * pi.damping * w * inertia_kg_m2, w * w * inertia_kg_m2, inertia_kg_m2,
          plant.axis[static_cast<std::size_t>(axis)].friction.positive.viscous_nm_s_rad};
}

// A seal that is viscous alone, and a gyro without noise: 0.03 mrad/s is left at 0.5 Hz, of which its noise is a tenth.
sim::PlantConfig viscous_plant() {
  sim::PlantConfig plant = tracker_plant();
  for (sim::AxisConfig& axis : plant.axis) {
    for (sim::StribeckConfig *direction : {&axis.friction.positive, &axis.friction.negative}) {
      direction->coulomb_nm = 1e-4;
      direction->breakaway_nm = 1e-4;
      direction->viscous_nm_s_rad = axis.friction.positive.viscous_nm_s_rad;
    }
    axis.friction.eccentricity_once = 0.0;
    axis.friction.eccentricity_twice = 0.0;
    axis.motor.cogging.clear();
    axis.load.cable_stiffness_nm_rad = 0.0;
    axis.load.imbalance_nm = 0.0;
    axis.gyro.noise_density_rad_s_rthz = 0.0;
  }
  return plant;
}

// At 0.5 deg and 5 Hz an axis that follows the base would need more torque than its motor has.
constexpr double kAmplitude_rad = 0.1 * kRadPerDeg;

void expect_isolation(sim::FeedbackSource feedback, double frequency_hz) {
  sim::PlantConfig plant = viscous_plant();
  const sim::IsolationPoint point =
      sim::isolation_at(plant, "pi", feedback, kAmplitude_rad, frequency_hz, bench::kSeeds[0]);
  const Complex s(0.0, 2.0 * sim::kPi * frequency_hz);
  for (int axis = 0; axis < sim::kAxes; ++axis) {
    plant.design[static_cast<std::size_t>(axis)].feedback = feedback;
    const Textbook textbook = textbook_of(plant, axis);
    const double crossover_rad_s = 2.0 * sim::kPi * plant.design[static_cast<std::size_t>(axis)].fusion_crossover_hz;
    const Complex left = feedback == sim::FeedbackSource::kGyro    ? textbook.with_gyro(s)
                         : feedback == sim::FeedbackSource::kFused ? textbook.fused(s, crossover_rad_s)
                                                                   : textbook.fused(s, 0.0);
    char text[120];
    (void)std::snprintf(text, sizeof text, "%s, %s, %g Hz: %.2f dB, textbook %.2f dB", sim::feedback_name(feedback),
                        sim::axis_name(axis), frequency_hz, point.isolation_db[static_cast<std::size_t>(axis)],
                        -decibel(left));
    TEST_MESSAGE(text);
    TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(1.0, -decibel(left), point.isolation_db[static_cast<std::size_t>(axis)], text);
  }
}

void test_isolation_is_that_of_the_linear_loop_for_every_source_of_the_rate() {
  for (const double frequency_hz : {0.5, 1.0, 5.0}) {
    expect_isolation(sim::FeedbackSource::kGyro, frequency_hz);
    expect_isolation(sim::FeedbackSource::kFused, frequency_hz);
    expect_isolation(sim::FeedbackSource::kEncoder, frequency_hz);
  }
}

// With the seal's own friction, which reverses in every period.
void test_the_gyro_isolates_by_40_db_at_1_hz_and_half_a_degree() {
  const sim::IsolationPoint point =
      sim::isolation_at(tracker_plant(), "pi_vob_ftc", sim::FeedbackSource::kGyro, sim::kIsolationGoal_rad,
                        sim::kIsolationGoal_hz, bench::kSeeds[0]);
  for (int axis = 0; axis < sim::kAxes; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    CHECK_AT_LEAST("isolation, dB", sim::kIsolationGoal_db, point.isolation_db[i]);
    CHECK_AT_LEAST("with noise and harmonics, dB", sim::kIsolationGoal_db, point.residual_db[i]);
  }
}

// The azimuth's gyro on the base, the pitch's on the azimuth stage: what they do not see is the joint's own motion,
// which the encoder adds.
void test_gyros_below_the_joints_isolate_as_well() {
  sim::PlantConfig plant = tracker_plant();
  plant.axis[sim::kAzimuth].gyro.mounting = sim::GyroMounting::kBase;
  plant.axis[sim::kPitch].gyro.mounting = sim::GyroMounting::kStage;
  const sim::IsolationPoint point =
      sim::isolation_at(plant, "pi_vob_ftc", sim::FeedbackSource::kGyro, sim::kIsolationGoal_rad,
                        sim::kIsolationGoal_hz, bench::kSeeds[0]);
  for (int axis = 0; axis < sim::kAxes; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    LOG_VALUE("isolation, dB", point.isolation_db[i]);
    LOG_VALUE("with noise and harmonics, dB", point.residual_db[i]);
    CHECK_AT_LEAST("isolation, dB", sim::kIsolationGoal_db, point.isolation_db[i]);
    CHECK_AT_LEAST("with noise and harmonics, dB", sim::kIsolationGoal_db, point.residual_db[i]);
  }
}

// By 1 degree: about each axis, or the one motion of the small size.
std::vector<sim::TrackingOnBase> motions_of_the_base() {
  if (by_size(0, 1, 1) == 0) {
    return {{sim::BaseAxis::kRoll, 0.3, 60.0 * kRadPerDeg, {}}};
  }
  std::vector<sim::TrackingOnBase> motions;
  for (const sim::BaseAxis turns : {sim::BaseAxis::kRoll, sim::BaseAxis::kPitch, sim::BaseAxis::kYaw}) {
    for (const double frequency_hz : {0.1, 0.3}) {
      for (const double pitch_deg : {0.0, 60.0}) {
        motions.push_back({turns, frequency_hz, pitch_deg * kRadPerDeg, {}});
      }
    }
  }
  return motions;
}

void test_gyros_on_the_line_of_sight_hold_it_on_a_turning_base() {
  sim::BaseMotionSetup setup;
  setup.plant = tracker_plant();
  for (const sim::TrackingOnBase& motion : motions_of_the_base()) {
    const auto sigma_rad = sim::tracking_on_base(setup, motion, sim::GyroMounting::kLineOfSight, bench::kSeeds[0]);
    char text[120];
    (void)std::snprintf(text, sizeof text, "%s, %g Hz, pitch %g deg: %.2f and %.2f urad",
                        sim::base_axis_name(motion.base_axis), motion.frequency_hz, motion.pitch_rad / kRadPerDeg,
                        1e6 * sigma_rad[0], 1e6 * sigma_rad[1]);
    TEST_MESSAGE(text);
    CHECK_AT_MOST(text, sim::kBaseSigmaGoal_rad, std::max(sigma_rad[0], sigma_rad[1]));
  }
}

// About the axis ahead, at pitch 60 degrees: a gyro on the stage does not see what the roll does to the picture.
void test_a_gyro_on_the_stage_does_not_see_the_roll() {
  sim::BaseMotionSetup setup;
  setup.plant = tracker_plant();
  const sim::TrackingOnBase choice{sim::BaseAxis::kRoll, 0.3, 60.0 * kRadPerDeg, {}};
  const auto along = sim::tracking_on_base(setup, choice, sim::GyroMounting::kLineOfSight, bench::kSeeds[0]);
  const auto across = sim::tracking_on_base(setup, choice, sim::GyroMounting::kJoint, bench::kSeeds[0]);
  CHECK_AT_LEAST("gyro on the stage, rad", 5.0 * along[0], across[0]);
}

void expect_margins(double pitch_deg, bool pre_sliding) {
  const sim::PitchMargins margins =
      sim::azimuth_margins(tracker_plant(), pitch_deg * kRadPerDeg, pre_sliding, bench::kSeeds[0]);
  char text[160];
  (void)std::snprintf(
      text, sizeof text, "%g deg, %s: computed %.1f dB, %.1f deg; measured %.1f dB, %.1f deg; fixed %.1f", pitch_deg,
      pre_sliding ? "pre-sliding" : "sliding", margins.computed.gain_margin_db, margins.computed.phase_margin_deg,
      margins.measured.gain_margin_db, margins.measured.phase_margin_deg, margins.fixed.phase_margin_deg);
  TEST_MESSAGE(text);
  TEST_ASSERT_TRUE_MESSAGE(sim::keeps_margins(margins.computed) && sim::keeps_margins(margins.measured), text);
  if (!pre_sliding) {
    TEST_ASSERT_DOUBLE_WITHIN_MESSAGE(4.0, margins.computed.phase_margin_deg, margins.measured.phase_margin_deg, text);
    if (pitch_deg > 85.0) {
      CHECK_AT_MOST("with fixed gains, deg", 40.0, margins.fixed.phase_margin_deg);
    }
  }
}

void test_the_azimuth_keeps_its_margins_at_every_pitch_angle() {
  for (const double pitch_deg : {0.0, 45.0, 80.0, 89.0}) {
    expect_margins(pitch_deg, false);
    if (by_size(0, 1, 1) != 0) {
      expect_margins(pitch_deg, true);
    }
  }
}

// The joints swing by several deg/s: with gyro feedback that is no oscillation of the loop.
void test_on_a_vehicle_the_node_tracks_without_a_fault() {
  const sim::PlantConfig plant = tracker_plant();
  const std::vector<sim::NodeTrackingCase> shipped = sim::shipped_node_tracking(plant, "sim_host");
  const auto found =
      std::find_if(shipped.begin(), shipped.end(), [](const auto& one) { return one.name == "fly-by, on a vehicle"; });
  TEST_ASSERT_TRUE(found != shipped.end());
  sim::NodeTrackingCase vehicle = *found;
  vehicle.scenario.duration_s = vehicle.count_from_s + 8.0;
  const sim::NodeTrackingRun run = sim::run_of(sim::NodeSetup(plant), vehicle, bench::kSeeds[0]);
  CHECK_AT_MOST("cross-elevation, rad", sim::kBaseSigmaGoal_rad, run.sigma_rad[sim::kAzimuth]);
  CHECK_AT_MOST("elevation, rad", sim::kBaseSigmaGoal_rad, run.sigma_rad[sim::kPitch]);
}

template <class Action>
std::string refusal_of(Action action) {
  try {
    action();
  } catch (const std::exception& error) {
    return error.what();
  }
  return "";
}

void test_what_makes_no_sense_on_a_turning_base_is_refused_with_its_reason() {
  sim::PlantConfig plant = tracker_plant();
  const sim::ScenarioConfig per_axis = sim::load_scenario("sim_host/scenarios/tracking.toml");
  TEST_ASSERT_EQUAL_STRING("", refusal_of([&] { (void)sim::check_scenario(plant, per_axis); }).c_str());
  plant.base_motion = {{sim::BaseAxis::kRoll, 0.2, 0.01, 0.0}};
  const std::string refused = refusal_of([&] { (void)sim::check_scenario(plant, per_axis); });
  TEST_ASSERT_NOT_NULL_MESSAGE(std::strstr(refused.c_str(), "each joint by itself"), refused.c_str());
  plant.axis[sim::kPitch].gyro.mounting = sim::GyroMounting::kBase;
  const std::string gyro = refusal_of([&] { (void)sim::design_controller(plant, sim::controller_spec("pi"), {}); });
  TEST_ASSERT_NOT_NULL_MESSAGE(std::strstr(gyro.c_str(), "pitch.gyro.mounting"), gyro.c_str());
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_isolation_is_that_of_the_linear_loop_for_every_source_of_the_rate);
  RUN_TEST(test_the_gyro_isolates_by_40_db_at_1_hz_and_half_a_degree);
  RUN_TEST(test_gyros_below_the_joints_isolate_as_well);
  RUN_TEST(test_gyros_on_the_line_of_sight_hold_it_on_a_turning_base);
  RUN_TEST(test_a_gyro_on_the_stage_does_not_see_the_roll);
  RUN_TEST(test_the_azimuth_keeps_its_margins_at_every_pitch_angle);
  RUN_TEST(test_on_a_vehicle_the_node_tracks_without_a_fault);
  RUN_TEST(test_what_makes_no_sense_on_a_turning_base_is_refused_with_its_reason);
  return UNITY_END();
}
