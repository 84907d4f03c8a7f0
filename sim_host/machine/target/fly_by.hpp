// SPDX-License-Identifier: Apache-2.0
// Line of sight to a UAV that flies past: a straight course plus sinusoidal weaving to the side and up, and evasion.
//
//   p(t) = p0 + v t + across * A1 sin(2 pi t / T1) + up * A2 sin(2 pi t / T2) + evasion(t)
//   azimuth = bearing of p, pitch = atan2(z, hypot(x, y)), with exact first and second time derivatives.
//
// Tracker at the origin, x ahead, y to the left, z up. Azimuth is continuous as long as the target stays within half a
// turn of its first bearing. Used by the tracking scenario: reference angle, rate and acceleration of the target.
#ifndef TRACKSERVO_SIM_TARGET_FLY_BY_HPP
#define TRACKSERVO_SIM_TARGET_FLY_BY_HPP

#include <Eigen/Core>
#include <array>

#include "machine/config/scenario_config.hpp"
#include "machine/target/evasion.hpp"

namespace trackservo::sim {

// Gains of the tracking loop (2011:2 and :4) for straight passes close by. The estimator lags by jerk / bandwidth^3:
// 22 urad at the closest approach at 150 m. Faster ones let more noise of the centroid through.
constexpr float kPassProportional_per_s = 30.0F;
constexpr float kPassEstimator_rad_s = 6.0F;

// Per axis (kAzimuth, kPitch): angle [rad], rate [rad/s], acceleration [rad/s2]; distance [m].
struct LineOfSight {
  std::array<double, kAxes> angle_rad{};
  std::array<double, kAxes> rate_rad_s{};
  std::array<double, kAxes> acceleration_rad_s2{};
  double range_m = 0;
};

class FlyBy {
 public:
  explicit FlyBy(const FlyByConfig& config);

  // Returns the position at a time [m], any finite value.
  Eigen::Vector3d position_m(double time_s) const;

  // Returns the line of sight at a time [s], any finite value. A target straight overhead (closer than 1 mm to the
  // vertical axis) has no azimuth; the caller's geometry must avoid it.
  LineOfSight at(double time_s) const;

 private:
  struct Motion;
  Motion motion(double time_s) const;

  FlyByConfig config_;
  Evasion evasion_;
  Eigen::Vector3d start_;
  Eigen::Vector3d velocity_;
  Eigen::Vector3d across_;
  double first_bearing_rad_ = 0;
};

}  // namespace trackservo::sim

#endif
