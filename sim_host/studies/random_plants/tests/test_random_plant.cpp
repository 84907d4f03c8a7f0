// SPDX-License-Identifier: Apache-2.0
// Random plants differ from the nominal one in every number that has a tolerance, and in no other.
#include "studies/random_plants/random_plant.hpp"

#include <algorithm>

#include "machine/config/plant_keys.hpp"
#include "support/bench.hpp"
#include "support/check.h"

extern "C" void setUp(void) {}
extern "C" void tearDown(void) {}

namespace {

using namespace trackservo::sim;

constexpr double kShare = 0.3;

// With a structure, which the shipped tracker does not have, so that its keys are tested too.
PlantConfig nominal() {
  PlantConfig plant = bench::shipped_plant("tracker");
  plant.axis[kAzimuth].structure = StructureConfig{80.0, 0.02, 0.1};
  return plant;
}

bool is_angle(const std::string& key) {
  for (const char *end : {"phase_deg", "direction_deg", "neutral_deg"}) {
    const std::string ending = end;
    if (key.size() >= ending.size() && key.compare(key.size() - ending.size(), ending.size(), ending) == 0) {
      return true;
    }
  }
  return false;
}

// Checks the keys of one table of the plant file, for example "motor.".
template <class Owner>
void every_key_is_varied_or_kept(const RandomPlant& plant, const std::string& table, const Keys<Owner>& keys) {
  for (const Key<Owner>& key : keys) {
    if (key.text.type != KeyType::kNumber || is_angle(key.text.name)) {
      continue;
    }
    const std::string name = table + key.text.name;
    const std::vector<std::string>& kept = retained_keys();
    const bool is_kept = std::find(kept.begin(), kept.end(), name) != kept.end();
    const bool shares_a_factor = name == "motor.back_emf_constant_v_s_rad";
    const bool is_varied =
        std::any_of(plant.deviations.begin(), plant.deviations.end(),
                    [&](const Deviation& deviation) { return deviation.key.find(name) != std::string::npos; });
    TEST_ASSERT_TRUE_MESSAGE(is_varied != (is_kept || shares_a_factor), name.c_str());
  }
}

void test_every_number_of_the_plant_file_is_varied_or_kept_for_a_reason() {
  const RandomPlant plant = random_plant(nominal(), kShare, 1);
  every_key_is_varied_or_kept(plant, "supply.", supply_keys());
  every_key_is_varied_or_kept(plant, "adc.", adc_keys());
  every_key_is_varied_or_kept(plant, "base_tilt.", base_tilt_keys());
  every_key_is_varied_or_kept(plant, "", axis_keys());
  every_key_is_varied_or_kept(plant, "motor.", motor_keys());
  every_key_is_varied_or_kept(plant, "motor.ripple.", ripple_keys());
  every_key_is_varied_or_kept(plant, "motor.cogging.", cogging_keys());
  every_key_is_varied_or_kept(plant, "friction.", friction_keys());
  every_key_is_varied_or_kept(plant, "friction.positive.", stribeck_keys());
  every_key_is_varied_or_kept(plant, "friction.negative.", stribeck_keys());
  every_key_is_varied_or_kept(plant, "load.", load_keys());
  every_key_is_varied_or_kept(plant, "structure.", structure_keys());
  every_key_is_varied_or_kept(plant, "base_sway.", base_sway_keys());
  every_key_is_varied_or_kept(plant, "encoder.", encoder_keys());
  every_key_is_varied_or_kept(plant, "gyro.", gyro_keys());
}

void test_factors_fill_the_share_and_keep_within_it() {
  double least = 1.0;
  double most = 1.0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    for (const Deviation& deviation : random_plant(nominal(), kShare, seed).deviations) {
      least = std::min(least, deviation.factor);
      most = std::max(most, deviation.factor);
    }
  }
  CHECK_NEAR("least factor", 0.7, least, 1e-3);
  CHECK_NEAR("most factor", 1.3, most, 1e-3);
  TEST_ASSERT_TRUE(least >= 0.7 && most <= 1.3);
}

void test_a_plant_is_its_nominal_and_its_seed() {
  const RandomPlant first = random_plant(nominal(), kShare, 7);
  const RandomPlant again = random_plant(nominal(), kShare, 7);
  const RandomPlant other = random_plant(nominal(), kShare, 8);
  const double inertia_kg_m2 = first.config.axis[kAzimuth].inertia_kg_m2;
  TEST_ASSERT_TRUE(inertia_kg_m2 == again.config.axis[kAzimuth].inertia_kg_m2);
  TEST_ASSERT_TRUE(inertia_kg_m2 != other.config.axis[kAzimuth].inertia_kg_m2);
  TEST_ASSERT_TRUE(first.deviations.size() == other.deviations.size());
}

void test_without_a_share_only_angles_differ() {
  const PlantConfig wanted = nominal();
  const PlantConfig plant = random_plant(wanted, 0.0, 1).config;
  const AxisConfig& axis = plant.axis[kAzimuth];
  TEST_ASSERT_TRUE(axis.inertia_kg_m2 == wanted.axis[kAzimuth].inertia_kg_m2);
  TEST_ASSERT_TRUE(axis.gyro.latency_s == wanted.axis[kAzimuth].gyro.latency_s);
  TEST_ASSERT_TRUE(axis.motor.ripple[1].phase_rad != wanted.axis[kAzimuth].motor.ripple[1].phase_rad);
}

void test_flux_is_one_and_breakaway_never_below_coulomb() {
  int raised = 0;
  for (std::uint64_t seed = 1; seed <= 200; ++seed) {
    const AxisConfig axis = random_plant(nominal(), kShare, seed).config.axis[kAzimuth];
    TEST_ASSERT_TRUE(axis.motor.torque_constant_nm_a == axis.motor.back_emf_constant_v_s_rad);
    TEST_ASSERT_TRUE(axis.friction.positive.breakaway_nm >= axis.friction.positive.coulomb_nm);
    raised += axis.friction.positive.breakaway_nm == axis.friction.positive.coulomb_nm ? 1 : 0;
  }
  TEST_ASSERT_TRUE_MESSAGE(raised > 0 && raised < 40, "the limit is met by some");
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_every_number_of_the_plant_file_is_varied_or_kept_for_a_reason);
  RUN_TEST(test_factors_fill_the_share_and_keep_within_it);
  RUN_TEST(test_a_plant_is_its_nominal_and_its_seed);
  RUN_TEST(test_without_a_share_only_angles_differ);
  RUN_TEST(test_flux_is_one_and_breakaway_never_below_coulomb);
  return UNITY_END();
}
