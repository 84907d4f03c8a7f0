// SPDX-License-Identifier: Apache-2.0
#include "judge/fault_injection/motion.hpp"

#include <algorithm>
#include <cmath>

#include "machine/base/axis.hpp"

namespace trackservo::sim {
namespace {

constexpr double kRamp_rad_s2 = 1.0;

// A triangle of 5 deg/s and 1 Hz with sharp corners.
double reversal(double time_s) {
  const double phase = time_s - std::floor(time_s);
  const double triangle = phase < 0.25 ? 4.0 * phase : phase < 0.75 ? 2.0 - 4.0 * phase : 4.0 * phase - 4.0;
  return 5.0 * kRadPerDeg * triangle;
}

// Closest after 1.5 s, with the passage within half a second.
double fly_by(double time_s) {
  const double from_closest = (time_s - 1.5) / 0.5;
  return 12.0 * kRadPerDeg / (1.0 + from_closest * from_closest);
}

}  // namespace

std::string motion_name(Motion motion) {
  switch (motion) {
    case Motion::kStandstill:
      return "standstill";
    case Motion::kSlow:
      return "1 deg/s";
    case Motion::kFast:
      return "20 deg/s";
    case Motion::kReversal:
      return "reversal";
    case Motion::kTracking:
    default:
      return "tracking";
  }
}

double motion_rate_rad_s(Motion motion, double time_s) {
  const double reached = kRamp_rad_s2 * time_s;
  switch (motion) {
    case Motion::kStandstill:
      return 0.0;
    case Motion::kSlow:
      return std::min(reached, 1.0 * kRadPerDeg);
    case Motion::kFast:
      return std::min(reached, 20.0 * kRadPerDeg);
    case Motion::kReversal:
      return reversal(time_s);
    case Motion::kTracking:
    default:
      return std::min(reached, fly_by(time_s));
  }
}

}  // namespace trackservo::sim
