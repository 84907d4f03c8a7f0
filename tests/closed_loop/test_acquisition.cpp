// The device's experiments on the simulated tracker: what they record is what the firmware saw, and limits hold.
#include <algorithm>
#include <cmath>
#include <fstream>
#include <string>

#include "bench.hpp"
#include "commissioning/acquisition.hpp"
#include "experiments/control_design.hpp"
#include "unity.h"

namespace sim = trackservo::sim;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

constexpr experiment_limits kLimits = {0.2F, 0.2F, 20.0F, 60.0F};

sim::PlantConfig tracker() { return sim::load_plant("sim_host/plants/tracker.toml"); }

sim::Recording record(const sim::PlantConfig& plant, const std::vector<sim::PlannedExperiment>& plan,
                      std::uint64_t seed = 3) {
  const servo_params params = sim::design_controller(plant, sim::controller_spec("pi_vob_ftc"), {});
  return sim::run_experiments(plant, params, sim::kPitch, {0.1, 0.4}, plan, seed);
}

sim::PlannedExperiment sweep() {
  stimulus_setup setup{};
  setup.kind = STIMULUS_SWEEP;
  setup.low_rad_s = 0.01F;
  setup.speed_ratio = 2.0F;
  setup.count = 2;
  setup.dwell_s = 1.0F;
  setup.acceleration_rad_s2 = 0.5F;
  return {setup, kLimits};
}

sim::PlannedExperiment loops() {
  stimulus_setup setup{};
  setup.kind = STIMULUS_HYSTERESIS;
  setup.count = 2;
  setup.dwell_s = 2.0F;
  setup.amplitude_rad = 2e-3F;
  return {setup, kLimits};
}

void test_a_sweep_and_loops_are_recorded_tick_by_tick() {
  const sim::Recording recording = record(tracker(), {sweep(), loops()});
  TEST_ASSERT_EQUAL(2, recording.ended.size());
  double forward_s = 0.0;
  double error_rad_s = 0.0;
  double largest_loop_rad = 0.0;
  double last_s = 0.0;
  for (const sim::RecordedTick& tick : recording.ticks) {
    TEST_ASSERT_TRUE(tick.time_s > last_s);
    last_s = tick.time_s;
    TEST_ASSERT_EQUAL(tick.run == 1 ? STIMULUS_SWEEP : STIMULUS_HYSTERESIS, tick.kind);
    if (tick.run == 1 && std::abs(tick.reference - 0.02) < 1e-9) {
      forward_s += 1e-3;
      error_rad_s += 1e-3 * (tick.inertial_rate_rad_s - tick.reference);
    }
    if (tick.run == 2) {
      largest_loop_rad = std::max(largest_loop_rad, std::abs(tick.joint_angle_rad - tick.reference));
    }
    TEST_ASSERT_TRUE(std::abs(tick.joint_angle_rad - 0.4) < 0.2);
    TEST_ASSERT_TRUE(std::abs(tick.torque_nm) < 20.0);
  }
  TEST_ASSERT_DOUBLE_WITHIN(0.02, 1.0, forward_s);
  TEST_ASSERT_DOUBLE_WITHIN(2e-4, 0.0, error_rad_s / forward_s);
  TEST_ASSERT_TRUE(largest_loop_rad < 1e-3);
}

void test_the_same_seed_records_the_same() {
  const sim::Recording a = record(tracker(), {loops()}, 5);
  const sim::Recording b = record(tracker(), {loops()}, 5);
  const sim::Recording c = record(tracker(), {loops()}, 6);
  TEST_ASSERT_EQUAL(a.ticks.size(), b.ticks.size());
  bool differs = false;
  for (std::size_t i = 0; i < a.ticks.size(); ++i) {
    TEST_ASSERT_EQUAL_DOUBLE(a.ticks[i].torque_nm, b.ticks[i].torque_nm);
    differs = differs || a.ticks[i].torque_nm != c.ticks[i].torque_nm;
  }
  TEST_ASSERT_TRUE(differs);
}

void test_an_experiment_that_ends_early_is_named_with_its_reason() {
  sim::PlannedExperiment runaway{};
  runaway.setup.kind = STIMULUS_TORQUE_RAMPS;
  runaway.setup.count = 1;
  runaway.setup.dwell_s = 4.0F;
  runaway.setup.amplitude_nm = 15.0F;
  runaway.limits = {0.01F, 0.2F, 20.0F, 60.0F};
  try {
    record(tracker(), {loops(), runaway});
    TEST_FAIL_MESSAGE("it must not come to its end");
  } catch (const sim::ExperimentError& error) {
    TEST_ASSERT_EQUAL_STRING("experiment 2 (torque ramps): the axis left its travel limit.", error.what());
  }
  sim::PlannedExperiment wide = loops();
  wide.setup.amplitude_rad = 1.0F;
  try {
    record(tracker(), {wide});
    TEST_FAIL_MESSAGE("it must be refused");
  } catch (const sim::ExperimentError& error) {
    TEST_ASSERT_EQUAL_STRING("experiment 1 (hysteresis loops): it does not fit its own limits.", error.what());
  }
}

void test_the_file_has_a_header_with_units_and_a_row_a_tick() {
  const sim::Recording recording = record(tracker(), {loops()});
  const std::string file = "build/test_acquisition.csv";
  sim::write_recording(recording, file);
  std::ifstream stream(file);
  std::string line;
  std::getline(stream, line);
  TEST_ASSERT_EQUAL_STRING("time_s,run,kind,joint_angle_rad,joint_rate_rad_s,inertial_rate_rad_s,torque_nm,reference",
                           line.c_str());
  std::size_t rows = 0;
  while (std::getline(stream, line)) {
    TEST_ASSERT_EQUAL(7, std::count(line.begin(), line.end(), ','));
    ++rows;
  }
  TEST_ASSERT_EQUAL(recording.ticks.size(), rows);
  try {
    sim::write_recording(recording, "build/no/such/folder/x.csv");
    TEST_FAIL_MESSAGE("it must not be written");
  } catch (const std::runtime_error& error) {
    TEST_ASSERT_TRUE(std::string(error.what()).find("no/such/folder/x.csv") != std::string::npos);
  }
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_a_sweep_and_loops_are_recorded_tick_by_tick);
  RUN_TEST(test_the_same_seed_records_the_same);
  RUN_TEST(test_an_experiment_that_ends_early_is_named_with_its_reason);
  RUN_TEST(test_the_file_has_a_header_with_units_and_a_row_a_tick);
  return UNITY_END();
}
