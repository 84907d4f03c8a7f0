// The emulated board beside the host's firmware: the same machine, the same noise, the same set-points over CAN.
//
// Each run: power on, enable both axes at 0.3 s, move from 1 s on. The figures are the experiments' (peak error of the
// true rate); the board's sensors have transport delays of their own, which the host's have not.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <functional>

#include "analysis/metrics.hpp"
#include "rig.hpp"
#include "unity.h"

using bench::BoardRig;
using bench::HostRig;
namespace sim = trackservo::sim;

void setUp(void) {}
void tearDown(void) {}

namespace {

constexpr double kDeg = sim::kPi / 180.0;
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

// The tolerated difference of two peak errors: a tenth, and what one count of the current's ADC (24 mA) makes of the
// rate in the loop's time of 5 ms: 2.5 Nm/A * 24 mA / 6 kg m2 * 5 ms = 0.003 deg/s in azimuth.
constexpr double kShare = 0.10;
constexpr double kQuantum_deg_s = 0.003;

void compare(const char *name, const Speed& speed, sim::Window window) {
  const sim::PlantConfig plant = bench::tracker_plant();
  HostRig host(plant);
  const sim::Trace on_host = run(host, speed, window.end_s);
  BoardRig board(plant);
  const std::clock_t begin = std::clock();
  const sim::Trace on_board = run(board, speed, window.end_s);
  const double cpu_s = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  for (const std::string& complaint : board.machine.chip().complaints.list()) {
    TEST_FAIL_MESSAGE(complaint.c_str());
  }
  TEST_ASSERT_EQUAL_INT(0, board.machine.chip().resets());
  for (int axis = 0; axis < sim::kAxes; ++axis) {
    const double expected = sim::peak_rate_error_rad_s(on_host, axis, window) / kDeg;
    const double found = sim::peak_rate_error_rad_s(on_board, axis, window) / kDeg;
    double sum = 0.0;
    int rows = 0;
    for (std::size_t i = 0; i < on_host.size(); ++i) {
      if (on_host[i].time_s >= window.begin_s) {
        const double difference = on_board[i].axis[static_cast<std::size_t>(axis)].rate_rad_s -
                                  on_host[i].axis[static_cast<std::size_t>(axis)].rate_rad_s;
        sum += difference * difference;
        ++rows;
      }
    }
    TEST_MESSAGE(fmt::format("{}, {}: peak error {:.5f} deg/s, host {:.5f}; rates differ by {:.5f} deg/s rms", name,
                             axis == sim::kAzimuth ? "azimuth" : "pitch", found, expected, std::sqrt(sum / rows) / kDeg)
                     .c_str());
    TEST_ASSERT_DOUBLE_WITHIN(kShare * expected + kQuantum_deg_s, expected, found);
  }
  TEST_MESSAGE(fmt::format("{:.1f} times real time", board.machine.time_s() / cpu_s).c_str());
}

void test_steady_speed_is_the_hosts() {
  compare("0.1 deg/s", [](double) { return 0.1 * kDeg; }, {3.0, 10.0});
  compare("1 deg/s", [](double) { return 1.0 * kDeg; }, {3.0, 10.0});
}

void test_sine_is_the_hosts() {
  compare("sine", [](double t) { return kDeg * std::sin(2.0 * sim::kPi * 0.1 * t); }, {5.0, 15.0});
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_steady_speed_is_the_hosts);
  RUN_TEST(test_sine_is_the_hosts);
  return UNITY_END();
}
