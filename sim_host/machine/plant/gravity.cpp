// SPDX-License-Identifier: Apache-2.0
#include "machine/plant/gravity.hpp"

#include <cmath>

namespace trackservo::sim {

Gravity::Gravity(const PlantConfig& plant)
    : moment_nm_{plant.axis[kAzimuth].load.imbalance_nm, plant.axis[kPitch].load.imbalance_nm},
      phase_rad_{plant.axis[kAzimuth].load.imbalance_phase_rad, plant.axis[kPitch].load.imbalance_phase_rad},
      up_(std::sin(plant.base_tilt.tilt_rad) * std::cos(plant.base_tilt.direction_rad),
          std::sin(plant.base_tilt.tilt_rad) * std::sin(plant.base_tilt.direction_rad),
          std::cos(plant.base_tilt.tilt_rad)),
      direction_rad_(plant.base_tilt.direction_rad),
      sin_tilt_(std::sin(plant.base_tilt.tilt_rad)),
      cos_tilt_(std::cos(plant.base_tilt.tilt_rad)) {}

void Gravity::turn_base(const Eigen::Matrix3d& attitude) {
  const Eigen::Vector3d up = attitude.transpose() * up_;
  direction_rad_ = std::atan2(up.y(), up.x());
  sin_tilt_ = std::hypot(up.x(), up.y());
  cos_tilt_ = up.z();
}

double Gravity::potential_j(const std::array<double, kAxes>& joint_angle_rad) const {
  const double p = joint_angle_rad[kPitch] + phase_rad_[kPitch];
  const double a = joint_angle_rad[kAzimuth] - direction_rad_;
  return moment_nm_[kPitch] * (std::sin(p) * cos_tilt_ + std::cos(p) * sin_tilt_ * std::cos(a)) +
         moment_nm_[kAzimuth] * sin_tilt_ * std::cos(a - phase_rad_[kAzimuth]);
}

Gravity::Torque Gravity::torque(const std::array<double, kAxes>& joint_angle_rad) const {
  Torque result;
  if (moment_nm_[kPitch] == 0.0 && moment_nm_[kAzimuth] == 0.0) {
    return result;
  }
  const double p = joint_angle_rad[kPitch] + phase_rad_[kPitch];
  const double a = joint_angle_rad[kAzimuth] - direction_rad_;
  const double sin_p = std::sin(p);
  const double cos_p = std::cos(p);
  const double across = moment_nm_[kPitch] * sin_tilt_ * std::sin(a);
  const double along = moment_nm_[kPitch] * sin_tilt_ * std::cos(a);
  const double upright = moment_nm_[kPitch] * cos_tilt_;
  const double own = moment_nm_[kAzimuth] * sin_tilt_;
  result.load_nm[kAzimuth] = -cos_p * across - own * std::sin(a - phase_rad_[kAzimuth]);
  result.load_nm[kPitch] = cos_p * upright - sin_p * along;
  result.slope_nm_rad(kAzimuth, kAzimuth) = -cos_p * along - own * std::cos(a - phase_rad_[kAzimuth]);
  result.slope_nm_rad(kPitch, kPitch) = -sin_p * upright - cos_p * along;
  result.slope_nm_rad(kAzimuth, kPitch) = sin_p * across;
  result.slope_nm_rad(kPitch, kAzimuth) = sin_p * across;
  return result;
}

}  // namespace trackservo::sim
