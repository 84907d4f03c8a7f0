// SPDX-License-Identifier: Apache-2.0
// Identification of the shipped machines, with all noise on, compared with their plant files; and its refusals.
#include <cmath>
#include <string>

#include "commissioning_bench.hpp"
#include "design/commissioning/commissioning.hpp"
#include "design/control_design.hpp"
#include "design/true_plant.hpp"
#include "gain_design/identified_plant_json.hpp"
#include "identification/result_json.hpp"
#include "support/check.h"

namespace identification = trackservo::identification;
namespace sim = trackservo::sim;
using commissioning_bench::BenchSetup;
using commissioning_bench::test_plan_of;
using identification::Identification;
using identification::Parameter;
using identification::Recording;
using trackservo::commissioning::TestPlan;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

constexpr std::uint64_t kSeed = 21;  // not one of the study's

// From the file of identify fit to gains: the same as for the true parameters.
void expect_gains_of_the_truth(const BenchSetup& setup, const nlohmann::ordered_json& result) {
  namespace design = trackservo::gain_design;
  design::IdentifiedPlant truth = sim::true_plant(setup.plant, setup.axis);
  truth.inertia_kg_m2 = sim::axis_inertia_kg_m2(setup.plant, setup.axis, setup.pitch_rad);
  const design::IdentifiedPlant found =
      design::read_identified_plant({"result.json", nlohmann::json::parse(result.dump())});
  TEST_ASSERT_EQUAL(0, found.modes.size());
  CHECK_NEAR("encoder's delay", truth.encoder.latency_s, found.encoder.latency_s, 5e-6);
  CHECK_NEAR("gyro's latency", truth.gyro.latency_s, found.gyro.latency_s, 20e-6);
  CHECK_RELATIVE("encoder's noise", truth.encoder.noise_rad, found.encoder.noise_rad, 0.15);
  CHECK_RELATIVE("gyro's noise", truth.gyro.noise_rad_s, found.gyro.noise_rad_s, 0.15);
  const axis_parameters present =
      sim::design_axis(setup.plant, setup.axis, sim::controller_spec("pi_vob_ftc"), sim::DesignOptions{});
  const design::GainRequirements requirements = sim::gain_requirements(setup.plant, setup.axis, TRACKER_PI);
  const design::GainDesign right = design::design_gains(truth, requirements, present);
  const design::GainDesign got = design::design_gains(found, requirements, present);
  CHECK_RELATIVE("kp", right.parameters.speed_loop.proportional_nm_s_rad,
                 got.parameters.speed_loop.proportional_nm_s_rad, 0.05);
  CHECK_RELATIVE("ki", right.parameters.speed_loop.integral_nm_rad, got.parameters.speed_loop.integral_nm_rad, 0.05);
  CHECK_NEAR("gain margin in dB", right.sliding.gain_margin_db, got.sliding.gain_margin_db, 0.5);
  CHECK_NEAR("phase margin in deg", right.sliding.phase_margin_deg, got.sliding.phase_margin_deg, 2.0);
}

// Every parameter within the required limits; at most one of the eleven outside its interval.
void expect_truth(const BenchSetup& setup, const Identification& result) {
  int outside = 0;
  for (const auto& [name, right] : commissioning_bench::truth_of(setup, result)) {
    const Parameter& found = result.parameter(name);
    TEST_ASSERT_EQUAL_STRING_MESSAGE("", found.refused.c_str(), name.c_str());
    CHECK_RELATIVE(name.c_str(), right, found.value, commissioning_bench::allowed_error(name));
    outside += found.interval.low <= right && right <= found.interval.high ? 0 : 1;
    CHECK_AT_MOST("width of the interval", 1.3, found.interval.high / found.interval.low);
  }
  CHECK_AT_MOST("parameters outside of their interval", 1, outside);
  TEST_ASSERT_TRUE(result.fit.converged);
}

void test_the_tracker_is_identified_in_its_wind() {
  const BenchSetup setup = commissioning_bench::setup_of("tracker", sim::kAzimuth, kSeed);
  const Recording recording = commissioning_bench::record(setup, test_plan_of(setup));
  const Identification result = identification::identify(recording);
  expect_truth(setup, result);
  CHECK_AT_MOST("correlation of whitened residuals", 0.05, result.largest_correlation);
  bool ripple_8 = false;
  bool ripple_24 = false;
  for (const identification::MotorHarmonic& harmonic : result.harmonics) {
    ripple_8 = ripple_8 || (harmonic.ripple && harmonic.per_turn == 8);
    ripple_24 = ripple_24 || (harmonic.ripple && harmonic.per_turn == 24);
  }
  TEST_ASSERT_TRUE_MESSAGE(ripple_8 && ripple_24, "the motor's ripple was not found");
  // The paper's damping ratio is wrong for this machine, and the result says so.
  CHECK_RELATIVE("damping ratio", 0.371, result.damping_ratio, 0.05);
  const auto json = identification::to_json(result, recording);
  TEST_ASSERT_TRUE(json.at("complete").get<bool>());
  CHECK_NEAR("inertia in JSON", result.parameter("inertia").value,
             json.at("parameters").at("inertia").at("value").get<double>(), 1e-12);
  expect_gains_of_the_truth(setup, json);
}

void test_the_papers_machine_is_identified() {
  const BenchSetup setup = commissioning_bench::setup_of("paper_simulation", sim::kAzimuth, kSeed);
  const Recording recording = commissioning_bench::record(setup, test_plan_of(setup));
  const Identification result = identification::identify(recording);
  expect_truth(setup, result);
  CHECK_RELATIVE("the paper's assumption holds on its own machine", identification::kPaperDampingRatio,
                 result.damping_ratio, 0.01);
}

void test_fast_sweeps_alone_are_refused_with_the_runs_that_are_missing() {
  const BenchSetup setup = commissioning_bench::setup_of("tracker", sim::kAzimuth, kSeed);
  TestPlan test_plan = test_plan_of(setup);
  test_plan.places.resize(2);
  for (trackservo::commissioning::Place& place : test_plan.places) {
    // Only the fastest speeds, in sequence, almost no reversals.
    const std::vector<stimulus_setup> all = place.experiments;
    place.experiments.clear();
    for (const stimulus_setup& experiment : all) {
      if (experiment.kind == STIMULUS_SWEEP && experiment.low_rad_s > 0.05F) {
        stimulus_setup alone = experiment;
        alone.count = 1;
        place.experiments = {alone};
      }
    }
  }
  const Recording recording = commissioning_bench::record(setup, test_plan);
  const Identification result = identification::identify(recording);
  TEST_ASSERT_FALSE(result.complete());
  const Parameter& stiffness = result.parameter("stiffness");
  TEST_ASSERT_TRUE_MESSAGE(stiffness.refused.find("hysteresis loops (kind 3)") != std::string::npos,
                           stiffness.refused.c_str());
  const Parameter& breakaway = result.parameter("breakaway_positive");
  TEST_ASSERT_TRUE_MESSAGE(breakaway.refused.find("speed sweep (kind 1)") != std::string::npos,
                           breakaway.refused.c_str());
  const auto json = identification::to_json(result, recording);
  TEST_ASSERT_TRUE(json.at("parameters").at("stiffness").at("value").is_null());
  TEST_ASSERT_TRUE(json.at("refused").size() >= 2);
}

Recording first_look(const BenchSetup& setup) {
  return commissioning_bench::record(
      setup, trackservo::commissioning::first_look(sim::motion_limits(setup.plant, setup.axis)));
}

// Within a factor of 1.5 of the truth; the Stribeck speed only where wind does not hide friction.
void expect_rough_truth(const BenchSetup& setup, const Identification& result, bool stribeck_shows = true) {
  const auto truth = commissioning_bench::truth_of(setup, result);
  const double coulomb_nm = 0.5 * (truth.at("coulomb_positive") + truth.at("coulomb_negative"));
  const auto check = [](const char *what, double right, double found) {
    CHECK_NEAR(what, 0.0, std::log(found / right), std::log(1.5));
  };
  check("Coulomb torque", coulomb_nm, result.rough.coulomb_nm);
  check("bristle length", coulomb_nm / truth.at("stiffness"), result.rough.bristle_rad);
  if (stribeck_shows) {
    check("Stribeck speed", truth.at("stribeck_speed_positive"), result.rough.stribeck_rad_s);
  }
  check("inertia", truth.at("inertia"), result.rough.inertia_kg_m2);
}

void test_a_first_look_of_a_minute_sizes_the_test_plan() {
  BenchSetup setup = commissioning_bench::setup_of("tracker", sim::kAzimuth, kSeed);
  auto& friction = setup.plant.axis[sim::kAzimuth].friction;
  friction.stiffness_nm_rad *= 0.1;
  friction.damping_nm_s_rad *= 0.3;
  for (sim::StribeckConfig *direction : {&friction.positive, &friction.negative}) {
    direction->coulomb_nm *= 0.1;
    direction->breakaway_nm *= 0.1;
    direction->viscous_nm_s_rad *= 0.1;
  }
  const Recording recording = first_look(setup);
  CHECK_AT_MOST("seconds", 90, static_cast<double>(recording.ticks()) * trackservo::kTick_s);
  const Identification result = identification::identify(recording);
  TEST_ASSERT_FALSE_MESSAGE(result.complete(), "two places and a minute cannot do for everything");
  expect_rough_truth(setup, result, false);
  const auto rough = identification::to_json(result, recording).at("rough");
  CHECK_SAME("bristle length in JSON", result.rough.bristle_rad, rough.at("bristle_rad").get<double>());
}

void test_a_coarse_encoder_leaves_quick_motion_to_the_gyro() {
  BenchSetup setup = commissioning_bench::setup_of("tracker", sim::kAzimuth, kSeed);
  setup.plant.axis[sim::kAzimuth].encoder.resolution_bits = 18;
  const Identification result = identification::identify(first_look(setup));
  TEST_ASSERT_TRUE(result.motion.fused);
  expect_rough_truth(setup, result);
  CHECK_RELATIVE("inertia", 5.738, result.rough.inertia_kg_m2, 0.05);
}

void expect_refusal(const Recording& recording, const char *said) {
  try {
    (void)identification::identify(recording);
    TEST_FAIL_MESSAGE(said);
  } catch (const identification::IdentificationError& error) {
    TEST_ASSERT_TRUE_MESSAGE(std::string(error.what()).find(said) != std::string::npos, error.what());
  }
}

void test_a_sensor_of_wrong_sign_is_reported() {
  const Recording good = first_look(commissioning_bench::setup_of("tracker", sim::kAzimuth, kSeed));
  Recording wrong = good;
  for (double& torque_nm : wrong.torque_nm) {
    torque_nm = -torque_nm;
  }
  expect_refusal(wrong, "its sign is opposite to that of the joint angle");
  wrong = good;
  for (double& rate_rad_s : wrong.inertial_rate_rad_s) {
    rate_rad_s = -rate_rad_s;
  }
  expect_refusal(wrong, "the gyro shows -1 times the joint rate");
}

void test_an_axis_that_stands_still_is_refused_at_once() {
  Recording recording;
  for (int tick = 0; tick < 5000; ++tick) {
    recording.time_s.push_back(tick * 1e-3);
    recording.run.push_back(1);
    recording.kind.push_back(identification::RunKind::kSpeedSweep);
    recording.joint_angle_rad.push_back(0.3 + 1e-8 * (tick % 3));
    recording.joint_rate_rad_s.push_back(0.0);
    recording.inertial_rate_rad_s.push_back(0.0);
    recording.torque_nm.push_back(0.1);
    recording.reference.push_back(0.0);
  }
  expect_refusal(recording, "hardly slides");
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_an_axis_that_stands_still_is_refused_at_once);
  RUN_TEST(test_a_sensor_of_wrong_sign_is_reported);
  RUN_TEST(test_fast_sweeps_alone_are_refused_with_the_runs_that_are_missing);
  RUN_TEST(test_a_first_look_of_a_minute_sizes_the_test_plan);
  RUN_TEST(test_a_coarse_encoder_leaves_quick_motion_to_the_gyro);
  RUN_TEST(test_the_tracker_is_identified_in_its_wind);
  RUN_TEST(test_the_papers_machine_is_identified);
  return UNITY_END();
}
