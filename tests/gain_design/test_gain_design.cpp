// SPDX-License-Identifier: Apache-2.0
// From an identified plant and requirements to gains: shipped gains are reproduced, and predictions match measurements.
#include <cmath>

#include "gain_design/design_bench.hpp"
#include "machine/run/machine.hpp"

extern "C" void setUp(void) {}
extern "C" void tearDown(void) {}

namespace {

using namespace design_bench;

void test_requirements_of_the_shipped_plants_give_the_shipped_gains() {
  for (const char *name : {"tracker", "paper_simulation"}) {
    const sim::PlantConfig plant = bench::shipped_plant(name);
    for (int axis = 0; axis < sim::kAxes; ++axis) {
      const axis_parameters before = present(plant, axis);
      const GainDesign design =
          design_gains(sim::true_plant(plant, axis), sim::gain_requirements(plant, axis, TRACKER_PI), before);
      const axis_parameters& now = design.parameters;
      CHECK_RELATIVE("kp", before.speed_loop.proportional_nm_s_rad, now.speed_loop.proportional_nm_s_rad, 1e-6);
      CHECK_RELATIVE("ki", before.speed_loop.integral_nm_rad, now.speed_loop.integral_nm_rad, 1e-6);
      CHECK_RELATIVE("anti-windup", before.speed_loop.tracking_rate_per_s, now.speed_loop.tracking_rate_per_s, 1e-6);
      CHECK_RELATIVE("observer", before.observer.bandwidth_rad_s, now.observer.bandwidth_rad_s, 1e-6);
      CHECK_RELATIVE("position", before.position_loop.proportional_per_s, now.position_loop.proportional_per_s, 1e-6);
      CHECK_RELATIVE("stiffness", before.friction.stiffness_nm_rad, now.friction.stiffness_nm_rad, 1e-6);
      CHECK_SAME("notch", 0.0, now.filters.notch_hz);
      CHECK_SAME("low-pass", 0.0, now.filters.lowpass_hz);
      if (plant.name == "tracker") {
        CHECK_RELATIVE("tracking", before.tracking_loop.integral_per_s2, now.tracking_loop.integral_per_s2, 1e-6);
        TEST_ASSERT_EQUAL(0, design.notes.size());
      } else {  // its speed loop of 2.6 Hz is too slow for a tracking loop of 2 Hz
        TEST_ASSERT_EQUAL(1, design.notes.size());
        TEST_ASSERT_TRUE(mentions(design.notes, "Tracking loop lowered from 2 Hz to "));
      }
    }
  }
}

void test_without_requirements_the_margins_are_used_up_as_predicted() {
  for (const char *name : {"tracker", "paper_simulation"}) {
    const sim::PlantConfig plant = bench::shipped_plant(name);
    const GainDesign design = design_gains(sim::true_plant(plant, sim::kAzimuth), {}, present(plant, sim::kAzimuth));
    CHECK_NEAR("phase margin with its reserve", 42.5, design.sliding.phase_margin_deg, 1.0);
    CHECK_AT_LEAST("PI alone, Hz", 50.0, design.speed_loop_bandwidth_hz);
    TEST_ASSERT_TRUE(mentions(design.notes, "the highest that margins and torque noise allow"));
    expect_as_predicted(plant, sim::kAzimuth, design);
  }
}

void test_the_observer_is_lowered_first() {
  const sim::PlantConfig plant = bench::shipped_plant("tracker");
  GainRequirements requirements;
  requirements.speed_loop_bandwidth_hz = 60.0;
  requirements.observer_bandwidth_hz = 80.0;
  const GainDesign design =
      design_gains(sim::true_plant(plant, sim::kPitch), requirements, present(plant, sim::kPitch));
  CHECK_NEAR("speed loop", 60.0, design.speed_loop_bandwidth_hz, 0.5);
  CHECK_AT_MOST("observer, rad/s", 2.0 * M_PI * 40.0, design.parameters.observer.bandwidth_rad_s);
  TEST_ASSERT_TRUE(mentions(design.notes, "Observer lowered from 80 Hz to "));
  TEST_ASSERT_FALSE(mentions(design.notes, "PI alone lowered"));
  TEST_ASSERT_TRUE(mentions(design.notes, "With the required values, the loop has "));
  expect_as_predicted(plant, sim::kPitch, design);
}

void test_requirements_beyond_all_delays_are_lowered_to_where_the_margins_hold() {
  const sim::PlantConfig plant = bench::shipped_plant("tracker");
  GainRequirements requirements;
  requirements.speed_loop_bandwidth_hz = 250.0;
  requirements.observer_bandwidth_hz = 80.0;
  requirements.position_bandwidth_hz = 100.0;
  const GainDesign design =
      design_gains(sim::true_plant(plant, sim::kPitch), requirements, present(plant, sim::kPitch));
  TEST_ASSERT_TRUE(mentions(design.notes, "Speed loop with PI alone lowered from 250 Hz to "));
  TEST_ASSERT_TRUE(mentions(design.notes, "Position loop lowered from 100 Hz to "));
  CHECK_AT_LEAST("phase margin", 42.0, design.sliding.phase_margin_deg);
  CHECK_AT_MOST("position loop, 1/s", 2.0 * M_PI * 60.0, design.parameters.position_loop.proportional_per_s);
  expect_as_predicted(plant, sim::kPitch, design);
}

void test_more_margin_costs_bandwidth() {
  const sim::PlantConfig plant = bench::shipped_plant("tracker");
  GainRequirements requirements;
  requirements.least = {12.0, 55.0};
  const IdentifiedPlant known = sim::true_plant(plant, sim::kAzimuth);
  const GainDesign design = design_gains(known, requirements, present(plant, sim::kAzimuth));
  CHECK_AT_LEAST("gain margin", 12.0, std::min(design.sliding.gain_margin_db, design.pre_sliding.gain_margin_db));
  CHECK_AT_LEAST("phase margin", 55.0, std::min(design.sliding.phase_margin_deg, design.pre_sliding.phase_margin_deg));
  const GainDesign usual = design_gains(known, {}, present(plant, sim::kAzimuth));
  CHECK_AT_MOST("bandwidth", 0.9 * usual.bandwidth_hz, design.bandwidth_hz);
}

// Only the encoder's noise moves the axis, which stands still.
double simulated_torque_noise_nm(sim::PlantConfig plant, const axis_parameters& designed) {
  for (sim::AxisConfig& axis : plant.axis) {
    axis.load = {};
    axis.base_sway = {};
    axis.gyro.bias_rad_s = 0.0;  // otherwise it creeps through the bristles, and friction follows
    axis.motor.cogging.clear();
  }
  plant.base_tilt = {};
  sim::Machine machine(plant, params_with(plant, sim::kAzimuth, designed), 3, {0.0, 0.0});
  for (servo_axis_command& command : machine.command().axis) {
    command.mode = SERVO_SPEED;
  }
  constexpr int kSettleTicks = 3000;
  constexpr int kTicks = 20000;
  double sum = 0.0;
  double squares = 0.0;
  for (int tick = 0; tick < kSettleTicks + kTicks; ++tick) {
    machine.advance_tick();
    if (tick >= kSettleTicks) {
      const auto torque_nm = static_cast<double>(machine.firmware(sim::kAzimuth).commanded_nm);
      sum += torque_nm;
      squares += torque_nm * torque_nm;
    }
  }
  return std::sqrt(squares / kTicks - std::pow(sum / kTicks, 2));
}

void test_the_torque_noise_is_that_of_the_simulated_axis() {
  sim::PlantConfig plant = bench::shipped_plant("tracker");
  plant.axis[sim::kAzimuth].encoder.jitter_rms_rad = 0.5e-6;
  const GainDesign design = design_gains(sim::true_plant(plant, sim::kAzimuth),
                                         sim::gain_requirements(plant, sim::kAzimuth, TRACKER_PI), present(plant, 0));
  LOG_VALUE("predicted", design.torque_noise_nm);
  CHECK_RELATIVE("torque noise", design.torque_noise_nm, simulated_torque_noise_nm(plant, design.parameters), 0.1);
}

void test_a_noisy_encoder_gets_a_low_pass_and_then_a_slower_loop() {
  sim::PlantConfig plant = bench::shipped_plant("tracker");
  plant.axis[sim::kAzimuth].encoder.jitter_rms_rad = 0.5e-6;
  const IdentifiedPlant known = sim::true_plant(plant, sim::kAzimuth);
  GainRequirements requirements = sim::gain_requirements(plant, sim::kAzimuth, TRACKER_PI);
  requirements.max_torque_noise_nm = 0.35;
  const GainDesign filtered = design_gains(known, requirements, present(plant, sim::kAzimuth));
  CHECK_AT_LEAST("low-pass", 100.0, filtered.parameters.filters.lowpass_hz);
  CHECK_AT_MOST("torque noise", 0.35, filtered.torque_noise_nm);
  TEST_ASSERT_TRUE(mentions(filtered.notes, "Low-pass at "));
  TEST_ASSERT_TRUE(mentions(filtered.notes, "more torque noise than 0.35 Nm"));
  requirements.max_torque_noise_nm = 0.05;
  const GainDesign slow = design_gains(known, requirements, present(plant, sim::kAzimuth));
  CHECK_AT_MOST("torque noise", 0.05, slow.torque_noise_nm);
  CHECK_AT_MOST("observer", 0.9F * filtered.parameters.observer.bandwidth_rad_s,
                slow.parameters.observer.bandwidth_rad_s);
  TEST_ASSERT_TRUE(mentions(slow.notes, "Observer lowered from 35 Hz to "));
}

std::string refusal(const IdentifiedPlant& plant, const GainRequirements& requirements,
                    const axis_parameters& present) {
  try {
    design_gains(plant, requirements, present);
  } catch (const GainDesignError& error) {
    return error.what();
  }
  return "";
}

void check_says(const std::string& text, const std::string& part) {
  TEST_ASSERT_TRUE_MESSAGE(text.find(part) != std::string::npos, (part + " in: " + text).c_str());
}

void test_what_no_gains_can_keep_is_an_error() {
  const sim::PlantConfig plant = bench::shipped_plant("tracker");
  const IdentifiedPlant known = sim::true_plant(plant, sim::kAzimuth);
  const axis_parameters before = present(plant, sim::kAzimuth);
  GainRequirements requirements;
  requirements.least.phase_margin_deg = 89.0;
  check_says(refusal(known, requirements, before),
             "no gains meet the requirements: even with the slowest ones tried the loop has ");
  check_says(refusal(known, requirements, before), "89 deg");
  requirements = {};
  requirements.speed_loop_bandwidth_hz = 100.0;
  requirements.max_torque_noise_nm = 1e-6;
  check_says(refusal(known, requirements, before), "at most 1e-06 Nm are required");
  axis_parameters weak = before;
  weak.motor.current_limit_a = 3.0F;
  check_says(refusal(known, {}, weak),
             "the motor gives 7.5 Nm at its current limit, but the axis breaks away at 9.45 Nm");
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_requirements_of_the_shipped_plants_give_the_shipped_gains);
  RUN_TEST(test_without_requirements_the_margins_are_used_up_as_predicted);
  RUN_TEST(test_the_observer_is_lowered_first);
  RUN_TEST(test_requirements_beyond_all_delays_are_lowered_to_where_the_margins_hold);
  RUN_TEST(test_more_margin_costs_bandwidth);
  RUN_TEST(test_the_torque_noise_is_that_of_the_simulated_axis);
  RUN_TEST(test_a_noisy_encoder_gets_a_low_pass_and_then_a_slower_loop);
  RUN_TEST(test_what_no_gains_can_keep_is_an_error);
  return UNITY_END();
}
