// SPDX-License-Identifier: Apache-2.0
// The emulated board beside the host's firmware: the same machine, the same noise, the same set-points over CAN.
//
// Each run: power on, enable both axes at 0.3 s, move from 1 s on. The figures are those of the experiments (peak error
// of the true rate); the board's sensors have transport delays of their own, which the host's do not have.
//
// TESTS_SIZE=large: every speed, over the experiments' whole windows.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdlib>
#include <functional>
#include <string>

#include "judge/analysis/metrics.hpp"
#include "rig.hpp"
#include "support/test_size.h"
#include "unity.h"

using bench::BoardRig;
using bench::HostRig;
namespace sim = trackservo::sim;

void setUp(void) {}
void tearDown(void) {}

namespace {

constexpr double kEnabledAt_s = 0.3;
constexpr double kMovesAt_s = 1.0;
constexpr int kCyclicVelocity = 9;

// From the frame on the bus to the drive's set-point: the tick that takes it, and one of interpolation.
constexpr int kSetPointDelay_ms = 2;

using Speed = std::function<double(double)>;  // [rad/s] of the time since the start of the motion

template <typename Rig>
sim::Trace run(Rig& rig, const Speed& speed, double duration_s) {
  rig.client.pass(static_cast<int>(1e3 * kEnabledAt_s));
  rig.client.start_node();
  TEST_ASSERT_TRUE_MESSAGE(rig.client.enable(kCyclicVelocity), "both axes must be enabled");
  while (rig.truth().time_s < kMovesAt_s) {
    rig.client.pass(1);
  }
  sim::Trace trace;
  for (int tick = 0; tick < static_cast<int>(1e3 * duration_s); ++tick) {
    const auto command = static_cast<std::int32_t>(std::lround(1e6 * speed(tick * sim::kTick_s)));
    rig.client.set_speeds(command, command);
    rig.client.pass(1);
    sim::TraceRow row{};
    row.time_s = tick * sim::kTick_s;
    const double wanted = speed(std::max(0, tick + 1 - kSetPointDelay_ms) * sim::kTick_s);
    const sim::TruthState truth = rig.truth();
    for (std::size_t i = 0; i < sim::kAxes; ++i) {
      row.axis[i].reference_rad_s = wanted;
      row.axis[i].rate_rad_s = truth.inertial_rate_rad_s[i];
    }
    trace.push_back(row);
  }
  return trace;
}

// One figure of the difference between two runs of the same machine, from `begin_s` on.
double rms_difference_deg_s(const sim::Trace& a, const sim::Trace& b, std::size_t axis, double begin_s) {
  double sum = 0.0;
  int rows = 0;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (a[i].time_s >= begin_s) {
      const double difference_rad_s = a[i].axis[axis].rate_rad_s - b[i].axis[axis].rate_rad_s;
      sum += difference_rad_s * difference_rad_s;
      ++rows;
    }
  }
  return std::sqrt(sum / rows) / sim::kRadPerDeg;
}

struct Motion {
  std::string name;
  Speed speed;
  sim::Window window;
};

sim::Trace on_host(const sim::PlantConfig& plant, const Motion& motion) {
  HostRig host(plant);
  return run(host, motion.speed, motion.window.end_s);
}

sim::Trace on_board(const sim::PlantConfig& plant, const Motion& motion) {
  BoardRig board(plant);
  const std::clock_t begin = std::clock();
  const sim::Trace trace = run(board, motion.speed, motion.window.end_s);
  const double cpu_s = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  for (const std::string& violation : board.machine.chip().violations.list()) {
    TEST_FAIL_MESSAGE(violation.c_str());
  }
  TEST_ASSERT_EQUAL_INT(0, board.machine.chip().resets());
  TEST_MESSAGE(fmt::format("{:.1f} times real time", board.machine.time_s() / cpu_s).c_str());
  return trace;
}

// A peak moves by about twice the rms of the added signal, on each side.
constexpr double kMaxPeakDifference = 2.0 * bench::kMaxDifference;

void compare(const Motion& motion, const sim::PlantConfig& plant, const sim::PlantConfig& without_errors) {
  const sim::Trace expected = on_host(plant, motion);
  const sim::Trace ideal = on_host(without_errors, motion);
  const sim::Trace found = on_board(plant, motion);
  for (int axis = 0; axis < sim::kAxes; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    const double s_deg_s = rms_difference_deg_s(expected, ideal, i, motion.window.begin_s);
    const double difference_deg_s = rms_difference_deg_s(found, expected, i, motion.window.begin_s);
    const double host_peak_deg_s = sim::peak_rate_error_rad_s(expected, axis, motion.window) / sim::kRadPerDeg;
    const double board_peak_deg_s = sim::peak_rate_error_rad_s(found, axis, motion.window) / sim::kRadPerDeg;
    TEST_MESSAGE(
        fmt::format("{}, {}: peak error {:.5f} deg/s, host {:.5f} (+-{:.5f} allowed); rates differ by {:.5f} rms "
                    "({:.5f} allowed)",
                    motion.name, sim::axis_name(axis), board_peak_deg_s, host_peak_deg_s, kMaxPeakDifference * s_deg_s,
                    difference_deg_s, bench::kMaxDifference * s_deg_s)
            .c_str());
    TEST_ASSERT_TRUE_MESSAGE(difference_deg_s <= bench::kMaxDifference * s_deg_s, "the rates differ");
    TEST_ASSERT_DOUBLE_WITHIN(kMaxPeakDifference * s_deg_s, host_peak_deg_s, board_peak_deg_s);
  }
}

// Only encoder, current and duty in steps: the difference is that of the quantisation.
void compare_without_noise(const Motion& motion) {
  const sim::PlantConfig plant = bench::tracker_plant();
  compare(motion, bench::without_sensor_noise(plant), bench::without_quantisation(plant));
}

// Like the experiments: with all noise.
void compare_with_noise(const Motion& motion) {
  const sim::PlantConfig plant = bench::tracker_plant();
  compare(motion, plant, bench::without_quantisation(plant));
}

// The windows of the experiments instead of shorter ones that begin earlier.
bool whole_windows() { return test_size_wanted() == TEST_LARGE; }

Motion steady(double speed_deg_s) {
  return {fmt::format("{} deg/s", speed_deg_s), [speed_deg_s](double) { return speed_deg_s * sim::kRadPerDeg; },
          whole_windows() ? sim::Window{3.0, 23.0} : sim::Window{3.0, 10.0}};
}

Motion sine() {
  return {"sine", [](double t) { return sim::kRadPerDeg * std::sin(2.0 * sim::kPi * 0.1 * t); },
          whole_windows() ? sim::Window{10.0, 30.0} : sim::Window{5.0, 15.0}};
}

void test_steady_speed_is_the_hosts_within_quantisation() {
  compare_without_noise(steady(0.1));
  for (const double speed_deg_s : {0.2, 0.4, 1.0, 2.0}) {
    if (whole_windows()) {
      compare_without_noise(steady(speed_deg_s));
    }
  }
}

void test_sine_is_the_hosts_within_quantisation() { compare_without_noise(sine()); }

void test_with_all_noise_the_figures_are_the_hosts_within_noise() {
  compare_with_noise(steady(1.0));
  if (whole_windows()) {
    for (const double speed_deg_s : {0.1, 0.2, 0.4, 2.0}) {
      compare_with_noise(steady(speed_deg_s));
    }
    compare_with_noise(sine());
  }
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_steady_speed_is_the_hosts_within_quantisation);
  RUN_TEST(test_sine_is_the_hosts_within_quantisation);
  RUN_TEST(test_with_all_noise_the_figures_are_the_hosts_within_noise);
  return UNITY_END();
}
