// SPDX-License-Identifier: Apache-2.0
#include "machine/plant/base_motion.hpp"

#include <Eigen/Geometry>
#include <array>
#include <cmath>

#include "machine/base/axis.hpp"

namespace trackservo::sim {
namespace {

struct Turn {
  double angle_rad = 0;
  double rate_rad_s = 0;
  double acceleration_rad_s2 = 0;
};

// A vector of a frame and its derivative, seen from a frame that is turned by `turn` about `axis` against it.
struct Moving {
  Eigen::Vector3d value;
  Eigen::Vector3d slope;
};

Moving seen_after(const Turn& turn, const Eigen::Vector3d& axis, const Moving& before) {
  const Eigen::Matrix3d back = Eigen::AngleAxisd(-turn.angle_rad, axis).toRotationMatrix();
  const Eigen::Vector3d value = back * before.value;
  return {value + axis * turn.rate_rad_s,
          back * before.slope - turn.rate_rad_s * axis.cross(value) + axis * turn.acceleration_rad_s2};
}

}  // namespace

BaseState BaseMotion::turned(double time_s) const {
  std::array<Turn, 3> turns;
  for (const BaseMotionLine& line : lines_) {
    const double w = 2.0 * kPi * line.frequency_hz;
    const double sine = line.amplitude_rad * std::sin(w * time_s + line.phase_rad);
    Turn& turn = turns.at(static_cast<std::size_t>(line.axis));
    turn.angle_rad += sine;
    turn.rate_rad_s += w * line.amplitude_rad * std::cos(w * time_s + line.phase_rad);
    turn.acceleration_rad_s2 -= w * w * sine;
  }
  const Turn& roll = turns[static_cast<std::size_t>(BaseAxis::kRoll)];
  const Turn& pitch = turns[static_cast<std::size_t>(BaseAxis::kPitch)];
  const Turn& yaw = turns[static_cast<std::size_t>(BaseAxis::kYaw)];
  const Eigen::Vector3d z = Eigen::Vector3d::UnitZ();
  const Eigen::Vector3d raises = -Eigen::Vector3d::UnitY();
  const Eigen::Vector3d x = Eigen::Vector3d::UnitX();
  const Moving rate = seen_after(roll, x, seen_after(pitch, raises, {z * yaw.rate_rad_s, z * yaw.acceleration_rad_s2}));
  BaseState state;
  state.attitude = (Eigen::AngleAxisd(yaw.angle_rad, z) * Eigen::AngleAxisd(pitch.angle_rad, raises) *
                    Eigen::AngleAxisd(roll.angle_rad, x))
                       .toRotationMatrix();
  state.rate_rad_s = rate.value;
  state.acceleration_rad_s2 = rate.slope;
  return state;
}

StageRates stage_rates(const Eigen::Vector3d& base_rate_rad_s, double azimuth_rad) {
  const double cosine = std::cos(azimuth_rad);
  const double sine = std::sin(azimuth_rad);
  return {cosine * base_rate_rad_s.x() + sine * base_rate_rad_s.y(),
          cosine * base_rate_rad_s.y() - sine * base_rate_rad_s.x(), base_rate_rad_s.z()};
}

}  // namespace trackservo::sim
