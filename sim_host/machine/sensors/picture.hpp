// SPDX-License-Identifier: Apache-2.0
// Where a target appears in the picture of a camera on two joints, by rotation matrices in double. It judges the
// firmware's geometry (firmware/control/line_of_sight.h), so it shares nothing with it.
//
// Frames: x ahead, y to the left, z up. The base stands on the ground with `base`, the azimuth turns about z, the pitch
// raises the optical axis (a rotation about -y), and the sensor is turned by `roll_rad` about the optical axis.
// A pinhole camera measures tangents: direction d has y/x along the rows and z/x along the columns.
#ifndef TRACKSERVO_SIM_SENSORS_PICTURE_HPP
#define TRACKSERVO_SIM_SENSORS_PICTURE_HPP

#include <Eigen/Core>
#include <array>

#include "machine/base/axis.hpp"

namespace trackservo::sim {

struct PictureMounting {
  double roll_rad = 0;         // of the sensor, counter-clockwise in the picture
  double boresight_x_rad = 0;  // place at which the target is to be held, along the unrolled picture axes
  double boresight_y_rad = 0;
};

// What the joints and the base do to the camera.
struct PicturePose {
  std::array<double, kAxes> joint_angle_rad{};
  Eigen::Matrix3d base = Eigen::Matrix3d::Identity();  // from the base's frame to the ground's
};

// Returns the camera's axes in the ground's frame: columns of the matrix are the optical axis, along the rows, along
// the columns.
Eigen::Matrix3d camera_axes_of(const PicturePose& pose, double roll_rad);

// Returns the place along the camera's own rows (kAzimuth) and columns (kPitch) [tangent]; NaN behind the camera.
// `target_m` is in the ground's frame, from the camera.
std::array<double, kAxes> picture_of(const Eigen::Vector3d& target_m, const PicturePose& pose,
                                     const PictureMounting& mounting);

// Returns how far the target is from the boresight, along cross-elevation (kAzimuth) and elevation (kPitch).
std::array<double, kAxes> pointing_error_of(const Eigen::Vector3d& target_m, const PicturePose& pose,
                                            const PictureMounting& mounting);

}  // namespace trackservo::sim

#endif
