// SPDX-License-Identifier: Apache-2.0
// Gravity torques of off-centre masses on a base that may be tilted.
//
//   U = G_p (sin p cos t + cos p sin t cos(a - d)) + G_a sin t cos(a - d - phase_a),   p = pitch + phase_p
//
// t, d: tilt of the base and its direction; G: imbalance torques. On a level base only pitch has a gravity torque, as
// cos(p); on a tilted base both torques depend on both angles. Torques are the exact gradient of U, so energy is
// conserved. Evaluated once per tick together with the second derivatives, which carry it through the tick.
#ifndef TRACKSERVO_SIM_PLANT_GRAVITY_HPP
#define TRACKSERVO_SIM_PLANT_GRAVITY_HPP

#include <Eigen/Core>
#include <array>

#include "machine/config/plant_config.hpp"

namespace trackservo::sim {

class Gravity {
 public:
  // Load torques (positive against forward motion) by axis, and their derivatives by the joint angles.
  struct Torque {
    Eigen::Vector2d load_nm = Eigen::Vector2d::Zero();
    Eigen::Matrix2d slope_nm_rad = Eigen::Matrix2d::Zero();
  };

  explicit Gravity(const PlantConfig& plant);

  // Turns the base by this attitude from now on, besides its tilt.
  void turn_base(const Eigen::Matrix3d& attitude);

  // Returns the potential energy [J] at joint angles [rad].
  double potential_j(const std::array<double, kAxes>& joint_angle_rad) const;

  // Returns its gradient and curvature there.
  Torque torque(const std::array<double, kAxes>& joint_angle_rad) const;

 private:
  std::array<double, kAxes> moment_nm_;
  std::array<double, kAxes> phase_rad_;
  Eigen::Vector3d up_;  // in the frame of the base at rest
  double direction_rad_;
  double sin_tilt_;
  double cos_tilt_;
};

}  // namespace trackservo::sim

#endif
