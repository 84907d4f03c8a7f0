// SPDX-License-Identifier: Apache-2.0
// What the simulated machine does with given duties, for a comparison with other simulators.
//
// Usage: plant_trace PLANT.toml PITCH_RAD   Each line of the standard input holds the duties of both bridges for 1 ms;
// after each, a line with the motor current [A], the joint rate [rad/s] and the joint angle [rad] of azimuth, then of
// pitch. Pitch begins at rest at PITCH_RAD.
#include <fmt/format.h>

#include <array>
#include <cstdlib>
#include <exception>
#include <iostream>

#include "machine/base/axis.hpp"
#include "machine/config/plant_config.hpp"
#include "machine/plant/tracker.hpp"

using namespace trackservo::sim;

namespace {

void trace(const char *plant, double pitch_rad) {
  Tracker tracker(load_plant(plant), 1);
  tracker.place({0.0, pitch_rad});
  std::array<double, kAxes> duty{};
  while (std::cin >> duty[kAzimuth] >> duty[kPitch]) {
    for (int period = 0; period < kPwmPerTick; ++period) {
      tracker.step_pwm(duty);
    }
    const TruthState now = tracker.truth();
    for (std::size_t i = 0; i < kAxes; ++i) {
      fmt::print("{:.17g} {:.17g} {:.17g} ", now.current_a[i], now.joint_rate_rad_s[i], now.joint_angle_rad[i]);
    }
    fmt::print("\n");
  }
}

}  // namespace

int main(int argc, char **argv) {
  if (argc != 3) {
    fmt::print(stderr, "usage: plant_trace PLANT.toml PITCH_RAD < duties\n");
    return 2;
  }
  try {
    trace(argv[1], std::strtod(argv[2], nullptr));
  } catch (const std::exception& error) {
    fmt::print(stderr, "plant_trace: {}\n", error.what());
    return 2;
  }
  return 0;
}
