// Identification of the shipped machines, with all noise on, against their plant files; and what it refuses.
#include <cmath>
#include <string>

#include "identification/result_json.hpp"
#include "truth.hpp"
#include "unit/support/check.h"

namespace identification = trackservo::identification;
namespace sim = trackservo::sim;
using commissioning::BenchSetup;
using commissioning::Programme;
using identification::Identification;
using identification::Parameter;
using identification::Recording;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

constexpr std::uint64_t kSeed = 21;  // not one of the study's

BenchSetup setup_of(const char *plant) {
  BenchSetup setup;
  setup.plant = sim::load_plant(std::string("sim_host/plants/") + plant + ".toml");
  setup.seed = kSeed;
  return setup;
}

Programme programme_of(const BenchSetup& setup) {
  return commissioning::programme_for(commissioning::rough_machine(setup.plant, setup.axis, setup.pitch_rad));
}

// Every parameter within the limits; at most one of the eleven outside of its interval.
void expect_truth(const BenchSetup& setup, const Identification& result) {
  int outside = 0;
  for (const auto& [name, right] : commissioning::truth_of(setup, result.position_terms)) {
    const Parameter& found = result.parameter(name);
    TEST_ASSERT_EQUAL_STRING_MESSAGE("", found.refused.c_str(), name.c_str());
    CHECK_RELATIVE(name.c_str(), right, found.value, commissioning::allowed_error(name));
    outside += found.interval.low <= right && right <= found.interval.high ? 0 : 1;
    CHECK_AT_MOST("width of the interval", 1.3, found.interval.high / found.interval.low);
  }
  CHECK_AT_MOST("parameters outside of their interval", 1, outside);
  TEST_ASSERT_TRUE(result.fit.converged);
}

void test_the_tracker_is_identified_in_its_wind() {
  const BenchSetup setup = setup_of("tracker");
  const Recording recording = commissioning::record(setup, programme_of(setup));
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
  // The paper's damping ratio is wrong for this machine, and that is said.
  CHECK_RELATIVE("damping ratio", 0.371, result.damping_ratio, 0.05);
  const auto json = identification::to_json(result, recording);
  TEST_ASSERT_TRUE(json.at("complete").get<bool>());
  CHECK_NEAR("inertia in JSON", result.parameter("inertia").value,
             json.at("parameters").at("inertia").at("value").get<double>(), 1e-12);
}

void test_the_papers_machine_is_identified() {
  const BenchSetup setup = setup_of("paper_simulation");
  const Recording recording = commissioning::record(setup, programme_of(setup));
  const Identification result = identification::identify(recording);
  expect_truth(setup, result);
  CHECK_RELATIVE("the paper's assumption holds on its own machine", identification::kPaperDampingRatio,
                 result.damping_ratio, 0.01);
}

void test_fast_sweeps_alone_are_refused_with_the_runs_that_are_missing() {
  const BenchSetup setup = setup_of("tracker");
  Programme programme = programme_of(setup);
  programme.places.resize(2);
  for (commissioning::Place& place : programme.places) {
    // The fastest speeds only, one after the other, hardly any turns.
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
  const Recording recording = commissioning::record(setup, programme);
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

// Nothing is known yet: speeds over three decades, loops of amplitudes over three decades, a chirp of any torque.
Programme first_look(double chirp_nm, double acceleration_rad_s2) {
  Programme programme;
  programme.moving_rad_s = 0.25;
  programme.limits = {2.9F, 2.0F, 40.0F, 3600.0F};
  commissioning::Place place{-0.35, {}};
  stimulus_setup sweep{};
  sweep.kind = STIMULUS_SWEEP;
  sweep.low_rad_s = 0.35e-3F;
  sweep.speed_ratio = 1.78F;
  sweep.count = 13;
  sweep.dwell_s = 0.5F;
  sweep.acceleration_rad_s2 = static_cast<float>(acceleration_rad_s2);
  place.experiments.push_back(sweep);
  for (double amplitude_rad = 30e-6; amplitude_rad < 40e-3; amplitude_rad *= 3.16) {
    stimulus_setup loops{};
    loops.kind = STIMULUS_HYSTERESIS;
    loops.dwell_s = 0.8F;
    loops.count = 2;
    loops.amplitude_rad = static_cast<float>(amplitude_rad);
    place.experiments.push_back(loops);
  }
  stimulus_setup chirp{};
  chirp.kind = STIMULUS_CHIRP;
  chirp.low_rad_s = 0.03F;
  chirp.count = 1;
  chirp.dwell_s = 3.0F;
  chirp.amplitude_nm = static_cast<float>(chirp_nm);
  chirp.low_hz = 1.0F;
  chirp.high_hz = 40.0F;
  chirp.acceleration_rad_s2 = static_cast<float>(acceleration_rad_s2);
  place.experiments.push_back(chirp);
  programme.places = {place, place};
  programme.places.back().angle_rad = 0.3;
  return programme;
}

// Within a factor of 1.5 of the truth.
void expect_rough_truth(const BenchSetup& setup, const Identification& result) {
  const auto truth = commissioning::truth_of(setup, result.position_terms);
  const double coulomb_nm = 0.5 * (truth.at("coulomb_positive") + truth.at("coulomb_negative"));
  const auto check = [](const char *what, double right, double found) {
    CHECK_NEAR(what, 0.0, std::log(found / right), std::log(1.5));
  };
  check("Coulomb torque", coulomb_nm, result.rough.coulomb_nm);
  check("bristle length", coulomb_nm / truth.at("stiffness"), result.rough.bristle_rad);
  check("Stribeck speed", truth.at("stribeck_speed_positive"), result.rough.stribeck_rad_s);
  check("inertia", truth.at("inertia"), result.rough.inertia_kg_m2);
}

void test_a_first_look_of_a_minute_sizes_the_programme() {
  BenchSetup setup = setup_of("tracker");
  auto& friction = setup.plant.axis[sim::kAzimuth].friction;
  friction.stiffness_nm_rad *= 0.1;
  friction.damping_nm_s_rad *= 0.3;
  for (sim::StribeckConfig *direction : {&friction.positive, &friction.negative}) {
    direction->coulomb_nm *= 0.1;
    direction->breakaway_nm *= 0.1;
    direction->viscous_nm_s_rad *= 0.1;
  }
  const Recording recording = commissioning::record(setup, first_look(6.0, 2.8));
  CHECK_AT_MOST("seconds", 75, static_cast<double>(recording.ticks()) * identification::kTick_s);
  const Identification result = identification::identify(recording);
  TEST_ASSERT_FALSE_MESSAGE(result.complete(), "two places and a minute cannot do for everything");
  expect_rough_truth(setup, result);
  const auto rough = identification::to_json(result, recording).at("rough");
  CHECK_SAME("bristle length in JSON", result.rough.bristle_rad, rough.at("bristle_rad").get<double>());
}

void test_a_coarse_encoder_leaves_quick_motion_to_the_gyro() {
  BenchSetup setup = setup_of("tracker");
  setup.plant.axis[sim::kAzimuth].encoder.resolution_bits = 18;
  const Identification result = identification::identify(commissioning::record(setup, first_look(6.0, 2.8)));
  TEST_ASSERT_TRUE(result.motion.fused);
  expect_rough_truth(setup, result);
  CHECK_RELATIVE("inertia", 5.738, result.rough.inertia_kg_m2, 0.05);
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
  try {
    (void)identification::identify(recording);
  } catch (const identification::IdentificationError& error) {
    TEST_ASSERT_TRUE(std::string(error.what()).find("hardly slides") != std::string::npos);
    return;
  }
  TEST_FAIL_MESSAGE("something was identified");
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_an_axis_that_stands_still_is_refused_at_once);
  RUN_TEST(test_fast_sweeps_alone_are_refused_with_the_runs_that_are_missing);
  RUN_TEST(test_a_first_look_of_a_minute_sizes_the_programme);
  RUN_TEST(test_a_coarse_encoder_leaves_quick_motion_to_the_gyro);
  RUN_TEST(test_the_tracker_is_identified_in_its_wind);
  RUN_TEST(test_the_papers_machine_is_identified);
  return UNITY_END();
}
