// SPDX-License-Identifier: Apache-2.0
#include "studies/shared/lost_time.hpp"

#include <algorithm>
#include <cmath>

namespace trackservo::sim {
namespace {

double distance_ahead_m(const PassConfig& pass) { return pass.height_m / std::tan(pass.elevation_rad); }

// Of the target, by the time since the closest approach.
struct AzimuthMotion {
  double angle_rad;
  double rate_rad_s;
  double acceleration_rad_s2;
};

AzimuthMotion azimuth_at(double speed_m_s, double ahead_m, double time_s) {
  const double along_m = speed_m_s * time_s;
  const double square_m2 = ahead_m * ahead_m + along_m * along_m;
  const double rate_rad_s = speed_m_s * ahead_m / square_m2;
  return {std::atan2(along_m, ahead_m), rate_rad_s, -2.0 * rate_rad_s * speed_m_s * along_m / square_m2};
}

bool is_within(const TurnLimits& limits, const AzimuthMotion& motion) {
  return motion.rate_rad_s <= limits.rate_rad_s && std::abs(motion.acceleration_rad_s2) <= limits.acceleration_rad_s2;
}

// In `time_s`, from one rate to the other; less than 0 when the time is too short for that.
double farthest_turn_rad(const TurnLimits& limits, double from_rad_s, double to_rad_s, double time_s) {
  const double top_rad_s = limits.rate_rad_s;
  const double up_s = (top_rad_s - from_rad_s) / limits.acceleration_rad_s2;
  const double down_s = (top_rad_s - to_rad_s) / limits.acceleration_rad_s2;
  if (time_s >= up_s + down_s) {
    return top_rad_s * time_s - 0.5 * ((top_rad_s - from_rad_s) * up_s + (top_rad_s - to_rad_s) * down_s);
  }
  const double highest_rad_s = 0.5 * (limits.acceleration_rad_s2 * time_s + from_rad_s + to_rad_s);
  if (highest_rad_s < std::max(from_rad_s, to_rad_s)) {
    return -1.0;
  }
  const double squares = from_rad_s * from_rad_s + to_rad_s * to_rad_s;
  return (highest_rad_s * highest_rad_s - 0.5 * squares) / limits.acceleration_rad_s2;
}

}  // namespace

double optimal_lost_s(const PassConfig& pass, const TurnLimits& limits) {
  constexpr double kStep_s = 1e-3;
  constexpr int kFarthest = 20000;
  const double ahead_m = distance_ahead_m(pass);
  const auto at = [&](int step) { return azimuth_at(pass.speed_m_s, ahead_m, kStep_s * step); };
  int first = -kFarthest;
  while (first < kFarthest && is_within(limits, at(first))) {
    ++first;
  }
  if (first == kFarthest) {
    return 0.0;
  }
  int last = kFarthest;
  while (is_within(limits, at(last))) {
    --last;
  }
  const AzimuthMotion left = at(first - 1);
  for (int end = last + 1; end < kFarthest; ++end) {
    const AzimuthMotion met = at(end);
    const double time_s = kStep_s * (end - first + 1);
    if (met.angle_rad - left.angle_rad <= farthest_turn_rad(limits, left.rate_rad_s, met.rate_rad_s, time_s)) {
      return time_s;
    }
  }
  return std::numeric_limits<double>::infinity();
}

}  // namespace trackservo::sim
