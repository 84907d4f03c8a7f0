// SPDX-License-Identifier: Apache-2.0
// Homing of the tracker's azimuth, +-280 degrees with an encoder of one turn: wind, friction, noise and elastic end
// stops.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <string>

#include "bench.hpp"
#include "device/driven_node.hpp"
#include "device/node_setup.hpp"

namespace sim = trackservo::sim;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

constexpr double kDeg = sim::kPi / 180.0;
constexpr double kContact_rad_s = 5.0 * kDeg;
constexpr std::int8_t kHoming = 6;
constexpr std::uint16_t kBits = 0x3400;
constexpr std::uint16_t kAtRest = 0x0400;
constexpr std::uint16_t kDone = 0x1400;

// A homing, from the start of the node to its end.
struct Homing {
  double end_deg = 0;
  double error_rad = 0;      // of the position in 6064
  double contact_rad_s = 0;  // fastest at an end stop
  double peak_rad_s = 0;
  double seconds = 0;
  bool touched = false;
  std::uint16_t bits = 0;
  fault_id fault = FAULT_NONE;
};

Homing home(const sim::NodeSetup& setup, double start_deg, std::int64_t method, std::uint64_t seed) {
  sim::DrivenNode node(setup, seed, {start_deg * kDeg, 0.4});
  node.machine().fit_holding_brakes();
  node.write(sim::kAzimuth, 0x6098, 0, method);
  node.enable(kHoming);
  node.write(sim::kAzimuth, 0x6040, 0, 0x1F);
  Homing result;
  const auto& stops = *setup.plant.axis[sim::kAzimuth].end_stops;
  const int longest_ticks = 150000;
  for (int tick = 0; tick < longest_ticks && (tick < 20 || (result.bits & kAtRest) == 0); ++tick) {
    node.write(sim::kAzimuth, 0x6040, 0, 0x1F); /* a master that speaks */
    node.tick();
    const double angle_rad = node.machine().truth().joint_angle_rad[sim::kAzimuth];
    const double speed_rad_s = std::abs(node.machine().truth().joint_rate_rad_s[sim::kAzimuth]);
    result.peak_rad_s = std::max(result.peak_rad_s, speed_rad_s);
    if (angle_rad < stops.lower_rad || angle_rad > stops.upper_rad) {
      result.touched = true;
      result.contact_rad_s = std::max(result.contact_rad_s, speed_rad_s);
    }
    const servo_node_axis& axis = node.axis(sim::kAzimuth);
    result.bits = axis.objects.state.statusword & kBits;
    result.fault = axis.drive.fault;
    result.end_deg = angle_rad / kDeg;
    result.error_rad = axis.objects.position.actual * 1e-7 - angle_rad;
    result.seconds = (tick + 1) * sim::kTick_s;
    if (result.fault != FAULT_NONE) {
      break;
    }
  }
  return result;
}

void expect_homed(double start_deg, std::int64_t method, bool contact) {
  const sim::NodeSetup setup(sim::load_plant("sim_host/plants/tracker.toml"));
  for (const std::uint64_t seed : {1, 2}) {
    const Homing h = home(setup, start_deg, method, seed);
    const std::string text = fmt::format(
        "start at {:.0f} deg, method {}, seed {}: {} deg after {:.1f} s, contact at {:.2f} deg/s, peak {:.2f} deg/s, "
        "fault {}, bits {:04X}, position wrong by {:.6f} rad",
        start_deg, method, seed, std::lround(h.end_deg), h.seconds, h.contact_rad_s / kDeg, h.peak_rad_s / kDeg,
        static_cast<int>(h.fault), h.bits, h.error_rad);
    std::printf("%s\n", text.c_str());
    TEST_ASSERT_EQUAL_HEX16_MESSAGE(kDone, h.bits, text.c_str());
    TEST_ASSERT_TRUE_MESSAGE(std::abs(h.error_rad) < 1e-3, text.c_str());
    TEST_ASSERT_EQUAL_MESSAGE(contact, h.touched, text.c_str());
    TEST_ASSERT_TRUE_MESSAGE(h.peak_rad_s <= kContact_rad_s && h.contact_rad_s <= kContact_rad_s, text.c_str());
  }
}

void test_an_axis_with_room_is_homed_without_a_contact() { expect_homed(100.0, -1, false); }

void test_at_the_lower_end_stop_it_turns_round() { expect_homed(-260.0, -1, true); }

void test_at_the_upper_end_stop_it_turns_round() { expect_homed(240.0, -2, true); }

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_an_axis_with_room_is_homed_without_a_contact);
  RUN_TEST(test_at_the_lower_end_stop_it_turns_round);
  RUN_TEST(test_at_the_upper_end_stop_it_turns_round);
  return UNITY_END();
}
