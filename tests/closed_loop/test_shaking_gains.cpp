// SPDX-License-Identifier: Apache-2.0
// Gains that make the axis shake: the oscillation monitor takes them back in time, and it does so for no other reason.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <string>
#include <vector>

#include "bench.hpp"
#include "design/loop_margins.hpp"
#include "device/driven_node.hpp"
#include "device/node_setup.hpp"
#include "judge/fault_injection/shaking_gains.hpp"
#include "machine/base/random.hpp"
#include "support/test_size.h"
#include "unity.h"

namespace sim = trackservo::sim;
using bench::kRadPerDeg;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

sim::PlantConfig tracker_plant() { return sim::load_plant("sim_host/plants/tracker.toml"); }

constexpr int kRunTicks = 3000;

struct Caught {
  fault_id fault = FAULT_NONE;
  double caught_s = -1.0;   // from the enabling until the fault
  double peak_deg_s = 0.0;  // of the rate error
};

// The node starts with such gains: there is nothing to take back.
Caught start_shaking(const sim::NodeSetup& setup, double rate_deg_s) {
  sim::DrivenNode node(setup, 7, {0.0, 0.6});
  node.enable(DRIVE_CYCLIC_VELOCITY);
  Caught caught;
  double rate_rad_s = 0.0;
  for (int tick = 0; tick < kRunTicks; ++tick) {
    rate_rad_s = std::min(rate_rad_s + 0.001, rate_deg_s * kRadPerDeg);
    node.set_rate(sim::kAzimuth, rate_rad_s);
    node.tick();
    const double error_rad_s = rate_rad_s - node.machine().truth().inertial_rate_rad_s[sim::kAzimuth];
    caught.fault = node.axis(sim::kAzimuth).drive.fault;
    if (caught.fault != FAULT_NONE) {
      caught.caught_s = tick * 1e-3;
      return caught;
    }
    caught.peak_deg_s = std::max(caught.peak_deg_s, std::abs(error_rad_s) / kRadPerDeg);
  }
  return caught;
}

struct Case {
  std::string name;
  std::function<void(axis_parameters&)> write;
};

const std::vector<Case> kCases = {
    {"low-pass 5 Hz", [](axis_parameters& p) { p.filters.lowpass_hz = 5.0F; }},
    {"low-pass 20 Hz", [](axis_parameters& p) { p.filters.lowpass_hz = 20.0F; }},
    {"Kp x 30", [](axis_parameters& p) { p.speed_loop.proportional_nm_s_rad *= 30.0F; }},
    {"Kp 20000", [](axis_parameters& p) { p.speed_loop.proportional_nm_s_rad = 20000.0F; }},
    {"Ki 1e8", [](axis_parameters& p) { p.speed_loop.integral_nm_rad = 1e8F; }},
    {"Kp x 10", [](axis_parameters& p) { p.speed_loop.proportional_nm_s_rad *= 10.0F; }},
};

void test_the_gains_that_shook_unnoticed_are_taken_back() {
  const sim::NodeSetup setup(tracker_plant());
  for (const Case& shaking : kCases) {
    for (const double rate_deg_s : {0.0, 20.0}) {
      axis_parameters gains = setup.parameters[sim::kAzimuth];
      shaking.write(gains);
      const sim::ShakingRun run = sim::shake(setup, sim::kAzimuth, gains, rate_deg_s, 5);
      const std::string text =
          fmt::format("{} at {:g} deg/s: after {:.3f} s, peak {:.2f} deg/s, travel {:.3f} deg; {}", shaking.name,
                      rate_deg_s, run.caught_s, run.peak_deg_s, run.travel_deg, sim::shaking_problem(run, rate_deg_s));
      std::printf("%s\n", text.c_str());
      TEST_ASSERT_EQUAL_MESSAGE(LOOP_REFUSED, run.verdict, text.c_str());
      TEST_ASSERT_TRUE_MESSAGE(run.taken_back && sim::shaking_problem(run, rate_deg_s).empty(), text.c_str());
    }
  }
}

void test_without_gains_to_take_back_the_axis_stops_with_its_own_fault() {
  for (const Case& shaking : kCases) {
    sim::NodeSetup setup(tracker_plant());
    shaking.write(setup.parameters[sim::kAzimuth]);
    for (const double rate_deg_s : {0.0, 10.0}) {
      const Caught caught = start_shaking(setup, rate_deg_s);
      const std::string text =
          fmt::format("{} at {:g} deg/s: fault {} after {:.3f} s, peak {:.2f} deg/s", shaking.name, rate_deg_s,
                      static_cast<int>(caught.fault), caught.caught_s, caught.peak_deg_s);
      std::printf("from the start, %s\n", text.c_str());
      TEST_ASSERT_EQUAL_MESSAGE(FAULT_OSCILLATION, caught.fault, text.c_str());
      TEST_ASSERT_TRUE_MESSAGE(caught.caught_s <= sim::kLongestShaking_s, text.c_str());
      TEST_ASSERT_TRUE_MESSAGE(caught.peak_deg_s <= sim::kShakingMoving_deg_s, text.c_str());
    }
  }
}

// A sample; `sim_host faults --shaking-gains 500` tries more.
void test_random_gains_that_shake_are_taken_back() {
  sim::ShakingOptions options;
  options.sets = by_size(10, 60, 500);
  options.seed = 1;
  const sim::ShakingGains result =
      sim::run_shaking_gains(tracker_plant(), options, [](int, int, const std::string&) {});
  std::printf("%s\n", sim::print(result).c_str());
  TEST_ASSERT_EQUAL_MESSAGE(0, result.errors.size(), result.errors.empty() ? "" : result.errors.front().c_str());
  TEST_ASSERT_EQUAL(options.sets, result.sets);
  for (const sim::ShakingRow& row : result.rows) {
    TEST_ASSERT_EQUAL(row.runs, row.refused);
    TEST_ASSERT_EQUAL(row.shook, row.caught);
    TEST_ASSERT_GREATER_THAN(row.runs * 3 / 4, row.shook);
  }
}

// Whether they hold the axis against its friction. Much weaker loops hunt: they stick and slip, at 1 deg/s and more.
bool are_strong(const axis_parameters& gains, const axis_parameters& designed) {
  return gains.speed_loop.proportional_nm_s_rad >= 0.3F * designed.speed_loop.proportional_nm_s_rad &&
         gains.observer.inertia_kg_m2 <= 10.0F * designed.observer.inertia_kg_m2;
}

// Gains that keep 6 dB and 40 degrees, new ones on a machine in wind: at rest, moving, with steps and reversals of the
// set-point.
void test_new_gains_with_margins_are_never_taken_back() {
  const sim::PlantConfig plant = tracker_plant();
  const sim::NodeSetup setup(plant);
  const int count = by_size(10, 100, 1000);
  sim::SplitMix64 random(2);
  int taken_back = 0;
  for (int i = 0; i < count;) {
    const int axis = i % 2;
    axis_parameters gains = sim::random_gains(setup.parameters[static_cast<std::size_t>(axis)], random);
    gains.speed_loop.tracking_rate_per_s =
        std::min(1000.0F, gains.speed_loop.integral_nm_rad / gains.speed_loop.proportional_nm_s_rad);
    servo_axis_params built;
    if (axis_parameters_build(&gains, &built) != CONTROL_OK ||
        !are_strong(gains, setup.parameters[static_cast<std::size_t>(axis)]) ||
        !sim::speed_loop_is_stable(plant, axis, built.speed) ||
        !sim::keeps_margins(sim::worst_margins(plant, axis, built.speed))) {
      continue;
    }
    sim::DrivenNode node(setup, 500 + static_cast<std::uint64_t>(i), {0.0, 0.6});
    node.enable(DRIVE_CYCLIC_VELOCITY);
    servo_node_axis& moved = node.node().axis[axis];
    servo_board& board = node.node().board;
    moved.tuning.staged = gains;
    TEST_ASSERT_EQUAL(CONTROL_OK, axis_tuning_apply(&moved.tuning, &board.app.axis[axis], &board.app.params.axis[axis],
                                                    SERVO_TICK_S));
    for (int tick = 0; tick < 6000 && !moved.tuning.proven_is_active && moved.drive.fault == FAULT_NONE; ++tick) {
      const double time_s = tick * 1e-3;
      const double slow_deg_s = 3.0 * std::sin(2.0 * sim::kPi * time_s);
      const double steps_deg_s = tick % 500 < 250 ? 1.0 : -1.0;
      node.set_rate(axis, kRadPerDeg * (tick < 1500 ? 0.0 : tick < 3500 ? slow_deg_s : steps_deg_s));
      node.tick();
    }
    if (moved.tuning.proven_is_active || moved.drive.fault != FAULT_NONE) {
      ++taken_back;
      std::printf("set %d, axis %d: fault %d\n", i, axis, static_cast<int>(moved.drive.fault));
    }
    ++i;
  }
  std::printf("%d sets with margins, %d taken back\n", count, taken_back);
  TEST_ASSERT_EQUAL(0, taken_back);
}

// A client's set-points that alternate fast, up to where they take all of the motor's torque, and gains that are new
// and good: what the motor does follows from the set-points.
void test_good_new_gains_are_kept_while_set_points_alternate_fast() {
  const sim::PlantConfig plant = tracker_plant();
  const sim::NodeSetup setup(plant);
  for (const double size_rad_s : {2e-3, 8e-3, 20e-3}) {
    for (const double frequency_hz : {10.0, 36.0, 77.0, 143.0, 333.0}) {
      sim::DrivenNode node(setup, 5, {0.0, 0.6});
      node.enable(DRIVE_CYCLIC_VELOCITY);
      for (int axis = 0; axis < SERVO_AXES; ++axis) {
        axis_tuning& tuning = node.node().axis[axis].tuning;
        tuning.staged = setup.parameters[static_cast<std::size_t>(axis)];
        tuning.staged.speed_loop.proportional_nm_s_rad *= 0.95F;
        servo_board& board = node.node().board;
        TEST_ASSERT_EQUAL(
            CONTROL_OK, axis_tuning_apply(&tuning, &board.app.axis[axis], &board.app.params.axis[axis], SERVO_TICK_S));
      }
      for (int tick = 0; tick < 2000; ++tick) {
        const double rate_rad_s = size_rad_s * std::sin(2.0 * sim::kPi * frequency_hz * tick * 1e-3);
        node.set_rate(sim::kAzimuth, rate_rad_s);
        node.set_rate(sim::kPitch, rate_rad_s);
        node.tick();
      }
      for (int axis = 0; axis < SERVO_AXES; ++axis) {
        const std::string text = fmt::format("axis {}, {:g} mrad/s at {:g} Hz, fault {}", axis, 1e3 * size_rad_s,
                                             frequency_hz, static_cast<int>(node.axis(axis).drive.fault));
        TEST_ASSERT_EQUAL_MESSAGE(FAULT_NONE, node.axis(axis).drive.fault, text.c_str());
        TEST_ASSERT_FALSE_MESSAGE(node.node().axis[axis].tuning.proven_is_active, text.c_str());
      }
    }
  }
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_the_gains_that_shook_unnoticed_are_taken_back);
  RUN_TEST(test_without_gains_to_take_back_the_axis_stops_with_its_own_fault);
  RUN_TEST(test_random_gains_that_shake_are_taken_back);
  RUN_TEST(test_new_gains_with_margins_are_never_taken_back);
  RUN_TEST(test_good_new_gains_are_kept_while_set_points_alternate_fast);
  return UNITY_END();
}
