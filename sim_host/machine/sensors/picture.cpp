// SPDX-License-Identifier: Apache-2.0
#include "machine/sensors/picture.hpp"

#include <Eigen/Geometry>
#include <limits>

namespace trackservo::sim {

Eigen::Matrix3d camera_axes_of(const PicturePose& pose, double roll_rad) {
  const Eigen::AngleAxisd azimuth(pose.joint_angle_rad[kAzimuth], Eigen::Vector3d::UnitZ());
  const Eigen::AngleAxisd pitch(-pose.joint_angle_rad[kPitch], Eigen::Vector3d::UnitY());
  const Eigen::AngleAxisd roll(roll_rad, Eigen::Vector3d::UnitX());
  return pose.base * (azimuth * pitch * roll).toRotationMatrix();
}

namespace {

// The tangents of a direction in the frame of the camera, whose sensor is turned by `roll_rad`.
std::array<double, kAxes> tangents(const Eigen::Vector3d& target_m, const PicturePose& pose, double roll_rad) {
  const Eigen::Vector3d seen = camera_axes_of(pose, roll_rad).transpose() * target_m;
  if (!(seen.x() > 0.0)) {
    constexpr double kNowhere = std::numeric_limits<double>::quiet_NaN();
    return {kNowhere, kNowhere};
  }
  return {seen.y() / seen.x(), seen.z() / seen.x()};
}

}  // namespace

std::array<double, kAxes> picture_of(const Eigen::Vector3d& target_m, const PicturePose& pose,
                                     const PictureMounting& mounting) {
  return tangents(target_m, pose, mounting.roll_rad);
}

std::array<double, kAxes> pointing_error_of(const Eigen::Vector3d& target_m, const PicturePose& pose,
                                            const PictureMounting& mounting) {
  const std::array<double, kAxes> place = tangents(target_m, pose, 0.0);
  return {place[kAzimuth] - mounting.boresight_x_rad, place[kPitch] - mounting.boresight_y_rad};
}

}  // namespace trackservo::sim
