// SPDX-License-Identifier: Apache-2.0
/* Random targets that move already when the camera sees them first, off the centre of its picture: half of them hop,
 * and half of the cameras state a wrong age. */
#ifndef TRACKSERVO_TESTS_SUPPORT_MOVING_TARGET_HPP
#define TRACKSERVO_TESTS_SUPPORT_MOVING_TARGET_HPP

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <random>
#include <string>

struct MovingTarget {
  int period_ticks = 20; /* of the pictures: 500 to 10 Hz */
  int age_ticks = 20;    /* of a picture when its frame arrives */
  int stated_ticks = 20;
  double offset_rad = 0; /* in the first picture, from the axis */
  double rate_rad_s = 0;
  double hop_rad = 0;
  int hop_ticks = 100;

  double angle_rad(int tick) const {
    return offset_rad + rate_rad_s * 1e-3 * tick + (tick / hop_ticks % 2 == 0 ? 0.0 : hop_rad);
  }

  std::string text() const {
    return fmt::format(
        "picture every {} ms, {} ms old, stated {}; {:.1f} mrad off, {:.4f} rad/s, hops {:.1f} mrad in {} ms",
        period_ticks, age_ticks, stated_ticks, 1e3 * offset_rad, rate_rad_s, 1e3 * hop_rad, hop_ticks);
  }
};

/* The n-th, from 0 on. */
inline MovingTarget moving_target(int n) {
  std::mt19937_64 draw(static_cast<std::uint64_t>(n) + 1);
  const auto between = [&draw](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(draw);
  };
  const auto ticks = [&between](double low, double high) { return static_cast<int>(std::lround(between(low, high))); };
  MovingTarget target;
  target.period_ticks = static_cast<int>(std::lround(100.0 * std::pow(0.02, between(0.0, 1.0))));
  target.age_ticks = ticks(5.0, 120.0);
  target.stated_ticks = n % 4 < 2 ? target.age_ticks : std::clamp(target.age_ticks + ticks(-100.0, 100.0), 0, 220);
  target.rate_rad_s = std::copysign(0.005 * std::pow(20.0, between(0.0, 1.0)), between(-1.0, 1.0));
  target.offset_rad = between(-0.005, 0.005);
  target.hop_rad = n % 8 < 4 ? 0.0 : between(0.0, 0.003);
  target.hop_ticks = ticks(50.0, 500.0);
  return target;
}

#endif
