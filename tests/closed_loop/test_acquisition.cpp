// SPDX-License-Identifier: Apache-2.0
// The device's experiments on the simulated tracker: they record the firmware's signals, and limits hold.
#include <algorithm>
#include <cmath>
#include <string>

#include "bench.hpp"
#include "design/commissioning/acquisition.hpp"
#include "design/control_design.hpp"
#include "support/check.h"
#include "unity.h"

namespace sim = trackservo::sim;
namespace identification = trackservo::identification;
using identification::RunKind;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

constexpr experiment_limits kLimits = {0.2F, 0.2F, 20.0F, 60.0F};
constexpr double kPlace_rad = 0.45;

sim::PlantConfig tracker() { return sim::load_plant("sim_host/plants/tracker.toml"); }

// At one place, which the axis starts towards from 0.4 rad.
sim::Acquisition record(const sim::PlantConfig& plant, const std::vector<stimulus_setup>& experiments,
                        std::uint64_t seed = 3, const experiment_limits& limits = kLimits) {
  sim::AcquisitionSetup setup;
  setup.plant = &plant;
  setup.params = sim::design_controller(plant, sim::controller_spec("pi_vob_ftc"), {});
  setup.axis = sim::kPitch;
  setup.start_angle_rad = {0.1, 0.4};
  setup.seed = seed;
  trackservo::commissioning::TestPlan test_plan;
  test_plan.places = {{kPlace_rad, experiments}};
  test_plan.moving_rad_s = 0.1;
  test_plan.limits = limits;
  return sim::acquire(setup, test_plan);
}

stimulus_setup sweep() {
  stimulus_setup setup{};
  setup.kind = STIMULUS_SWEEP;
  setup.low_rad_s = 0.01F;
  setup.speed_ratio = 2.0F;
  setup.count = 2;
  setup.dwell_s = 1.0F;
  setup.acceleration_rad_s2 = 0.5F;
  return setup;
}

// The fastest speed reverses at the end of the travel, so the sweep ends far from its start.
void test_experiments_begin_at_their_place_wherever_the_one_before_has_ended() {
  stimulus_setup fast = sweep();
  fast.low_rad_s = 0.05F;
  fast.speed_ratio = 1.6F;
  fast.count = 3;
  fast.dwell_s = 1.6F;
  fast.acceleration_rad_s2 = 1.0F;
  const sim::Acquisition done = record(tracker(), {fast, fast, fast});
  const auto [lowest, highest] =
      std::minmax_element(done.recording.joint_angle_rad.begin(), done.recording.joint_angle_rad.end());
  CHECK_AT_LEAST("lowest angle, rad", kPlace_rad - 1.05 * static_cast<double>(kLimits.travel_rad), *lowest);
  CHECK_AT_MOST("highest angle, rad", kPlace_rad + 1.05 * static_cast<double>(kLimits.travel_rad), *highest);
}

stimulus_setup loops() {
  stimulus_setup setup{};
  setup.kind = STIMULUS_HYSTERESIS;
  setup.count = 2;
  setup.dwell_s = 2.0F;
  setup.amplitude_rad = 2e-3F;
  return setup;
}

void test_a_move_a_sweep_and_loops_are_recorded_tick_by_tick() {
  constexpr int kMove = 1;
  constexpr int kSweep = 2;  // then a rest
  constexpr int kLoops = 4;
  const sim::Acquisition acquired = record(tracker(), {sweep(), loops()});
  const identification::Recording& recording = acquired.recording;
  TEST_ASSERT_EQUAL(2, acquired.ended.size());
  double forward_s = 0.0;
  double error_rad_s = 0.0;
  double largest_loop_rad = 0.0;
  for (std::size_t i = 0; i < recording.ticks(); ++i) {
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, 1e-3 * static_cast<double>(i), recording.time_s[i]);
    TEST_ASSERT_EQUAL(recording.run[i] == kLoops ? RunKind::kHysteresis : RunKind::kSpeedSweep, recording.kind[i]);
    if (recording.run[i] == kSweep && std::abs(recording.reference[i] - 0.02) < 1e-9) {
      forward_s += 1e-3;
      error_rad_s += 1e-3 * (recording.inertial_rate_rad_s[i] - recording.reference[i]);
    }
    if (recording.run[i] == kLoops) {
      largest_loop_rad = std::max(largest_loop_rad, std::abs(recording.joint_angle_rad[i] - recording.reference[i]));
    }
    TEST_ASSERT_TRUE(recording.run[i] == kMove || std::abs(recording.joint_angle_rad[i] - kPlace_rad) < 0.21);
    TEST_ASSERT_TRUE(std::abs(recording.torque_nm[i]) < 20.0);
  }
  TEST_ASSERT_DOUBLE_WITHIN(0.02, 1.0, forward_s);
  TEST_ASSERT_DOUBLE_WITHIN(2e-4, 0.0, error_rad_s / forward_s);
  TEST_ASSERT_TRUE(largest_loop_rad < 1e-3);
}

void test_the_same_seed_records_the_same() {
  const identification::Recording a = record(tracker(), {loops()}, 5).recording;
  const identification::Recording b = record(tracker(), {loops()}, 5).recording;
  const identification::Recording c = record(tracker(), {loops()}, 6).recording;
  TEST_ASSERT_TRUE(a.torque_nm == b.torque_nm);
  TEST_ASSERT_TRUE(a.joint_angle_rad == b.joint_angle_rad);
  TEST_ASSERT_FALSE(a.torque_nm == c.torque_nm);
}

void test_an_experiment_that_ends_early_is_named_with_its_reason() {
  stimulus_setup runaway{};
  runaway.kind = STIMULUS_TORQUE_RAMPS;
  runaway.count = 1;
  runaway.dwell_s = 4.0F;
  runaway.amplitude_nm = 15.0F;
  try {
    record(tracker(), {loops(), runaway}, 3, {0.01F, 0.2F, 20.0F, 60.0F});
    TEST_FAIL_MESSAGE("it must not come to its end");
  } catch (const sim::ExperimentError& error) {
    TEST_ASSERT_EQUAL_STRING("pitch, experiment 2 (torque ramps) at 26.3 deg: the axis exceeded its travel limit.",
                             error.what());
  }
  stimulus_setup wide = loops();
  wide.amplitude_rad = 1.0F;
  try {
    record(tracker(), {wide});
    TEST_FAIL_MESSAGE("it must be refused");
  } catch (const sim::ExperimentError& error) {
    TEST_ASSERT_EQUAL_STRING("pitch, experiment 1 (hysteresis loops): it does not fit its own limits.", error.what());
  }
}

void test_what_is_written_is_read_again() {
  const identification::Recording recording = record(tracker(), {loops()}).recording;
  const std::string file = "build/test_acquisition.csv";
  identification::write_recording(recording, file);
  const identification::Recording read = identification::load_recording(file);
  TEST_ASSERT_EQUAL(recording.ticks(), read.ticks());
  for (std::size_t i = 0; i < read.ticks(); ++i) {
    TEST_ASSERT_EQUAL(recording.run[i], read.run[i]);
    TEST_ASSERT_DOUBLE_WITHIN(1e-9, recording.joint_angle_rad[i], read.joint_angle_rad[i]);
    TEST_ASSERT_DOUBLE_WITHIN(1e-5, recording.torque_nm[i], read.torque_nm[i]);
  }
  try {
    identification::write_recording(recording, "build/no/such/folder/x.csv");
    TEST_FAIL_MESSAGE("it must not be written");
  } catch (const identification::RecordingError& error) {
    TEST_ASSERT_TRUE(std::string(error.what()).find("no/such/folder/x.csv") != std::string::npos);
  }
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_experiments_begin_at_their_place_wherever_the_one_before_has_ended);
  RUN_TEST(test_a_move_a_sweep_and_loops_are_recorded_tick_by_tick);
  RUN_TEST(test_the_same_seed_records_the_same);
  RUN_TEST(test_an_experiment_that_ends_early_is_named_with_its_reason);
  RUN_TEST(test_what_is_written_is_read_again);
  return UNITY_END();
}
