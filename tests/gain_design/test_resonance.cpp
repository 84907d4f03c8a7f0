// SPDX-License-Identifier: Apache-2.0
// A structural resonance, from the recorded chirp to a notch with which the loop keeps its margins.
#include <cmath>

#include "commissioning_bench.hpp"
#include "design/commissioning/commissioning.hpp"
#include "design/commissioning/tuned_gains.hpp"
#include "gain_design/design_bench.hpp"
#include "gain_design/notch.hpp"
#include "identification/resonances.hpp"
#include "support/test_size.h"

extern "C" void setUp(void) {}
extern "C" void tearDown(void) {}

namespace {

using namespace design_bench;
namespace identification = trackservo::identification;

constexpr sim::StructureConfig kStructure{90.0, 0.02, 0.3};

sim::PlantConfig flexible_plant(const sim::StructureConfig& structure) {
  sim::PlantConfig plant = bench::shipped_plant("tracker");
  plant.axis[sim::kAzimuth].structure = structure;
  return plant;
}

// The chirp that commissioning records for it.
identification::Recording recorded_chirp(const sim::PlantConfig& plant, int axis = sim::kAzimuth,
                                         std::uint64_t seed = 1) {
  commissioning_bench::BenchSetup setup;
  setup.plant = plant;
  setup.axis = axis;
  setup.seed = seed;
  setup.pitch_rad = 0.0;
  const double inertia_kg_m2 = axis == sim::kAzimuth ? 6.0 : 2.5;
  const trackservo::commissioning::RoughMachine machine{inertia_kg_m2, 2e-4, 5e-3, inertia_kg_m2};
  return commissioning_bench::record(
      setup, trackservo::commissioning::structure_look(sim::motion_limits(plant, axis), machine));
}

identification::RigidAxis rigid_axis(const sim::PlantConfig& plant) {
  const IdentifiedPlant truth = sim::true_plant(plant, sim::kAzimuth);
  return {truth.inertia_kg_m2, static_cast<double>(truth.friction.positive.viscous_nm_s_rad),
          truth.encoder.latency_s - kCurrentAge_s};
}

void test_a_resonance_is_found_where_the_plant_has_it() {
  for (const sim::StructureConfig& structure :
       {kStructure, sim::StructureConfig{45.0, 0.01, 0.05}, sim::StructureConfig{150.0, 0.03, 0.2}}) {
    const sim::PlantConfig plant = flexible_plant(structure);
    identification::AxisResponse response = identification::axis_response(recorded_chirp(plant));
    const std::vector<StructuralMode> found = identification::find_resonances(response, rigid_axis(plant));
    const StructuralMode truth = sim::true_plant(plant, sim::kAzimuth).modes.front();
    TEST_ASSERT_EQUAL(1, found.size());
    CHECK_RELATIVE("frequency", truth.frequency_rad_s, found.front().frequency_rad_s, 0.002);
    CHECK_RELATIVE("damping", truth.damping, found.front().damping, 0.25);  // the window widens narrow ones
    CHECK_RELATIVE("share", truth.share, found.front().share, 0.05);
    CHECK_RELATIVE("height", relative_height(truth), relative_height(found.front()), 0.2);
    response.windows = identification::kMinWindows - 1;  // its coherence would be meaningless
    TEST_ASSERT_EQUAL(0, identification::find_resonances(response, rigid_axis(plant)).size());
  }
}

void test_a_rigid_axis_has_no_resonance_and_its_response_is_that_of_the_inertia() {
  const sim::PlantConfig plant = bench::shipped_plant("tracker");
  const identification::RigidAxis rigid = rigid_axis(plant);
  const identification::AxisResponse response = identification::axis_response(recorded_chirp(plant));
  TEST_ASSERT_EQUAL(0, identification::find_resonances(response, rigid).size());
  int lines = 0;
  for (std::size_t i = 0; i < response.frequency_hz.size(); ++i) {
    if (response.frequency_hz[i] > 25.0 && response.frequency_hz[i] < 200.0) {
      const std::complex<double> s(0.0, 2.0 * M_PI * response.frequency_hz[i]);
      const std::complex<double> expected =
          std::exp(-s * rigid.delay_s) / (rigid.inertia_kg_m2 * s + rigid.viscous_nm_s_rad);
      CHECK_AT_LEAST("coherence", identification::kGoodCoherence, response.coherence[i]);
      CHECK_NEAR("measured over rigid", 1.0, std::abs(response.gain[i] / expected), 0.1);
      ++lines;
    }
  }
  CHECK_AT_LEAST("lines compared", 500, lines);
}

void test_no_wind_looks_like_a_resonance() {
  const sim::PlantConfig plant = bench::shipped_plant("tracker");
  for (const int axis : {sim::kAzimuth, sim::kPitch}) {
    const IdentifiedPlant truth = sim::true_plant(plant, axis);
    const identification::RigidAxis rigid{truth.inertia_kg_m2,
                                          static_cast<double>(truth.friction.positive.viscous_nm_s_rad),
                                          truth.encoder.latency_s - kCurrentAge_s};
    const std::vector<std::uint64_t> seeds{1, 5, 7, 14, 1001};
    for (std::size_t i = 0; i < static_cast<std::size_t>(by_size(1, 5, 5)); ++i) {
      const identification::AxisResponse response =
          identification::axis_response(recorded_chirp(plant, axis, seeds[i]));
      TEST_ASSERT_EQUAL(0, identification::find_resonances(response, rigid).size());
    }
  }
}

void test_without_torque_excitation_nothing_is_reported() {
  identification::Recording recording;
  for (int i = 0; i < 10000; ++i) {
    recording.time_s.push_back(1e-3 * i);
    recording.run.push_back(1);
    recording.kind.push_back(identification::RunKind::kSpeedSweep);
    recording.joint_angle_rad.push_back(1e-4 * i);
    recording.torque_nm.push_back(6.0);
  }
  const identification::AxisResponse response = identification::axis_response(recording);
  TEST_ASSERT_EQUAL(0, response.windows);
  TEST_ASSERT_EQUAL(0, response.frequency_hz.size());
  TEST_ASSERT_EQUAL(0, identification::find_resonances(response, {}).size());
}

// A design without knowledge of the resonance gives a loop that does not keep its margins.
void test_the_resonance_breaks_the_margins_of_a_design_that_does_not_know_it() {
  const sim::PlantConfig plant = flexible_plant(kStructure);
  IdentifiedPlant rigid = sim::true_plant(plant, sim::kAzimuth);
  rigid.modes.clear();
  const GainDesign design = design_gains(rigid, {}, present(plant, sim::kAzimuth));
  CHECK_AT_LEAST("predicted", 40.0, design.sliding.phase_margin_deg);
  const Margins found = margins_of(measured(plant, sim::kAzimuth, design.parameters, design.sliding, false));
  CHECK_AT_MOST("measured", 30.0, found.phase_margin_deg);
}

// From the recording alone: its chirp, the mode found in it, the notch for it.
void test_with_the_notch_the_margins_hold_as_predicted() {
  const sim::PlantConfig plant = flexible_plant(kStructure);
  IdentifiedPlant known = sim::true_plant(plant, sim::kAzimuth);
  known.modes =
      identification::find_resonances(identification::axis_response(recorded_chirp(plant)), rigid_axis(plant));
  const GainDesign design = design_gains(known, {}, present(plant, sim::kAzimuth));
  CHECK_NEAR("notch", 90.0, design.parameters.filters.notch_hz, 0.5);
  TEST_ASSERT_TRUE(mentions(design.notes, "Notch at 90.0 Hz"));
  expect_as_predicted(plant, sim::kAzimuth, design);
  CHECK_AT_LEAST("phase margin", 40.0, design.sliding.phase_margin_deg);
  LOG_VALUE("speed loop with PI alone, Hz", design.speed_loop_bandwidth_hz);
}

void test_commissioning_finds_the_resonance_and_gains_whose_margins_hold() {
  const sim::PlantConfig plant = flexible_plant({90.0, 0.02, 0.1});
  const sim::TunedGains gains = sim::tune(plant, sim::commission(plant, sim::kAzimuth, 1));
  TEST_ASSERT_EQUAL(1, gains.identified.modes.size());
  const StructuralMode truth = sim::true_plant(plant, sim::kAzimuth).modes.front();
  CHECK_RELATIVE("frequency", truth.frequency_rad_s, gains.identified.modes.front().frequency_rad_s, 0.002);
  CHECK_NEAR("gain margin, measured against predicted, dB", 0.0,
             gains.measured.gain_margin_db - gains.design.sliding.gain_margin_db, 1.0);
  CHECK_NEAR("phase margin, measured against predicted, deg", 0.0,
             gains.measured.phase_margin_deg - gains.design.sliding.phase_margin_deg, 4.0);
  TEST_ASSERT_TRUE(gains.kept);
}

void test_a_notch_is_the_inverse_of_the_mode() {
  const StructuralMode mode{2.0 * M_PI * 90.0, 0.02, 0.43};
  const NotchFilter notch = notch_for(mode);
  CHECK_RELATIVE("depth", 1.0 / relative_height(mode), notch.depth, 1e-9);
  CHECK_RELATIVE("zeros on the poles", 2.0 * mode.damping * notch.frequency_hz, notch.depth * notch.width_hz, 1e-9);
  const StructuralMode sharp{2.0 * M_PI * 90.0, 0.001, 0.003};  // small, but sharp
  CHECK_RELATIVE("width", 9.0, notch_for(sharp).width_hz, 1e-9);
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_a_resonance_is_found_where_the_plant_has_it);
  RUN_TEST(test_a_rigid_axis_has_no_resonance_and_its_response_is_that_of_the_inertia);
  RUN_TEST(test_no_wind_looks_like_a_resonance);
  RUN_TEST(test_without_torque_excitation_nothing_is_reported);
  RUN_TEST(test_the_resonance_breaks_the_margins_of_a_design_that_does_not_know_it);
  RUN_TEST(test_with_the_notch_the_margins_hold_as_predicted);
  if (test_size_wanted() != TEST_SMALL) {
    RUN_TEST(test_commissioning_finds_the_resonance_and_gains_whose_margins_hold);
  }
  RUN_TEST(test_a_notch_is_the_inverse_of_the_mode);
  return UNITY_END();
}
