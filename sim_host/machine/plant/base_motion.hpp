// SPDX-License-Identifier: Apache-2.0
// Rotation of the base on which the tracker stands, as on a vehicle or a ship: a sum of sines about three axes.
// Together with base_sway.hpp, the small sway of a mast, which is added about the axes of the joints.
//
// The attitude turns the base's frame (x ahead, y to the left, z up) into the ground's by exact rotations: first the
// yaw about z, then the pitch, which raises x (about -y), then the roll about x:
//
//     R = Rz(yaw) Ry(-pitch) Rx(roll)
//
// Rates and accelerations are those of this product, in the base's frame. A spectrum is given as its lines.
#ifndef TRACKSERVO_SIM_PLANT_BASE_MOTION_HPP
#define TRACKSERVO_SIM_PLANT_BASE_MOTION_HPP

#include <Eigen/Core>
#include <vector>

#include "machine/config/plant_config.hpp"

namespace trackservo::sim {

struct BaseState {
  Eigen::Matrix3d attitude = Eigen::Matrix3d::Identity();  // from the base's frame to the ground's
  Eigen::Vector3d rate_rad_s = Eigen::Vector3d::Zero();    // in the base's frame, as the next one
  Eigen::Vector3d acceleration_rad_s2 = Eigen::Vector3d::Zero();
};

class BaseMotion {
 public:
  explicit BaseMotion(std::vector<BaseMotionLine> lines) : lines_(std::move(lines)), start_(turned(0.0)) {}

  bool moves() const { return !lines_.empty(); }

  BaseState at(double time_s) const { return moves() ? turned(time_s) : start_; }

 private:
  BaseState turned(double time_s) const;

  std::vector<BaseMotionLine> lines_;
  BaseState start_;
};

// Rates of the azimuth stage without its joint's own rate, in the stage's frame: x ahead, y to the left. So the base
// turns the pitch axis, which raises the line of sight, by -y.
struct StageRates {
  double x_rad_s = 0;
  double y_rad_s = 0;
  double z_rad_s = 0;
};
StageRates stage_rates(const Eigen::Vector3d& base_rate_rad_s, double azimuth_rad);

}  // namespace trackservo::sim

#endif
