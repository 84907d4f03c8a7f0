// SPDX-License-Identifier: Apache-2.0
// Gains for one machine on others of its type: some here, a thousand in `sim_host random-plants`.
#include "studies/random_plants/random_plants.hpp"

#include <cstdio>

#include "bench.hpp"
#include "studies/random_plants/random_plant.hpp"
#include "studies/random_plants/random_plants_report.hpp"
#include "support/test_size.h"
#include "unity.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using namespace trackservo::sim;

// The paper's tightest speed and the slowest, and friction parameters wrong by 15 % each, which is worse than
// identified.
RandomPlantsSetup setup_of(std::uint64_t count) {
  RandomPlantsSetup setup;
  setup.study = bench::study("steady_speed", "tracker");
  setup.study.scenario.speeds_rad_s = {0.1 * bench::kRadPerDeg, 1.0 * bench::kRadPerDeg};
  setup.paper = experiment_named("steady_speed", load_experiments("sim_host")).paper;
  setup.count = count;
  return setup;
}

servo_params gains_of(const Study& study) {
  return design_controller(study.plant, controller_spec("pi_vob_ftc"), design_options(study));
}

void test_random_plants_are_stable_and_err_less_than_the_paper() {
  const RandomPlants tried = try_random_plants(setup_of(static_cast<std::uint64_t>(by_size(10, 50, 1000))),
                                               [](int, int, const std::string&) {});
  const RandomPlantsSummary summary = summary_of(tried);
  const AxisSummary& azimuth = summary.axis[kAzimuth];
  char text[160];
  for (const ErrorDistribution& error : azimuth.errors) {
    (void)std::snprintf(text, sizeof text, "%s: peak error, 95 %% of plants %.5f deg/s, largest %.5f, paper %g",
                        error.case_name.c_str(), error.percentile_95, error.largest, error.paper);
    TEST_MESSAGE(text);
    TEST_ASSERT_TRUE_MESSAGE(error.percentile_95 <= error.paper, text);
  }
  (void)std::snprintf(text, sizeof text, "failing %d; least margins %.1f dB, %.0f deg", summary.failing,
                      azimuth.min_gain_margin_db, azimuth.min_phase_margin_deg);
  TEST_MESSAGE(text);
  TEST_ASSERT_EQUAL_INT(0, azimuth.unstable);
  TEST_ASSERT_EQUAL_INT(0, summary.axis[kPitch].unstable);
}

// The reverse: an unstable loop is detected, by computation and separately in the run.
void test_a_machine_that_is_far_too_light_is_called_unstable() {
  RandomPlantsSetup setup = setup_of(1);
  setup.share = 0.0;
  const servo_params heavy = gains_of(setup.study);
  AxisConfig& azimuth = setup.study.plant.axis[kAzimuth];
  azimuth.inertia_kg_m2 /= 6.0;
  azimuth.inertia_swing_kg_m2 /= 6.0;
  const TriedPlant tried = try_plant(setup, heavy, 1);
  TEST_ASSERT_FALSE(tried.axis[kAzimuth].stable);
  TEST_ASSERT_FALSE(tried.axis[kAzimuth].stable_at_zenith);
  TEST_ASSERT_TRUE(tried.axis[kAzimuth].max_ripple_share > kMaxRippleShare);
  TEST_ASSERT_TRUE(tried.axis[kPitch].stable);
}

std::vector<double> factors_of(const RandomPlantsSetup& setup, const std::vector<TriedPlant>& plants,
                               const std::string& key) {
  std::vector<double> factors;
  for (const TriedPlant& plant : plants) {
    for (const Deviation& deviation : random_plant(setup.study.plant, setup.share, plant.seed).deviations) {
      if (deviation.key == key) {
        factors.push_back(deviation.factor);
      }
    }
  }
  return factors;
}

// A motor that is stronger than the firmware assumes takes margin away, a heavier machine adds some.
void test_margins_know_of_the_motor_and_of_the_inertia() {
  RandomPlantsSetup setup = setup_of(1);
  const servo_params gains = gains_of(setup.study);
  setup.study.scenario.speeds_rad_s.clear();  // margins alone
  std::vector<TriedPlant> plants;
  std::vector<double> margins_db;
  for (std::uint64_t seed = 1; seed <= 60; ++seed) {
    plants.push_back(try_plant(setup, gains, seed));
    margins_db.push_back(plants.back().axis[kAzimuth].gain_margin_db);
  }
  TEST_ASSERT_TRUE(correlation(margins_db, factors_of(setup, plants, "azimuth.motor.torque_constant_nm_a")) < -0.5);
  TEST_ASSERT_TRUE(correlation(margins_db, factors_of(setup, plants, "azimuth.inertia_kg_m2")) > 0.3);
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_random_plants_are_stable_and_err_less_than_the_paper);
  RUN_TEST(test_a_machine_that_is_far_too_light_is_called_unstable);
  RUN_TEST(test_margins_know_of_the_motor_and_of_the_inertia);
  return UNITY_END();
}
