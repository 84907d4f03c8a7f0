// SPDX-License-Identifier: Apache-2.0
// The true state of the simulated machine, and the readings of its electronics.
//
// Errors are measured on TruthState; controllers get only TickSamples and PwmSample. Signs: positive torque of the
// motor drives forward; friction and load are counted positive against forward motion, so that J d(inertial rate)/dt =
// motor_torque - friction_torque - load_torque. J is the inertia before the spring of a structure, whose torque is a
// load.
#ifndef TRACKSERVO_SIM_PLANT_TRUTH_HPP
#define TRACKSERVO_SIM_PLANT_TRUTH_HPP

#include <Eigen/Core>
#include <array>

#include "machine/base/axis.hpp"
#include "machine/base/firmware.hpp"
#include "machine/sensors/picture.hpp"

namespace trackservo::sim {

// State at the end of the last PWM period; torques are means over that period.
struct TruthState {
  double time_s = 0;
  std::array<double, kAxes> joint_angle_rad{};   // moving part relative to the base, not wrapped
  std::array<double, kAxes> joint_rate_rad_s{};  // its rate, at the seal
  std::array<double, kAxes>
      inertial_angle_rad{};  // line of sight: of the optics, with the sway; in the frame of `base`
  std::array<double, kAxes> inertial_rate_rad_s{};
  std::array<double, kAxes> base_rate_rad_s{};
  std::array<double, kAxes> motor_torque_nm{};     // with ripple and cogging
  std::array<double, kAxes> friction_torque_nm{};  // positive against forward motion
  std::array<double, kAxes> load_torque_nm{};      // wind + cable + imbalance + coupling + end stop, same sign
  std::array<double, kAxes> end_stop_torque_nm{};  // its share of load_torque_nm
  std::array<double, kAxes> current_a{};
  Eigen::Matrix3d base = Eigen::Matrix3d::Identity();          // from the turned base's frame to the ground's
  Eigen::Vector3d base_turns_rad_s = Eigen::Vector3d::Zero();  // in that frame; without the sway of a mast
  std::array<double, kAxes> line_of_sight_rad_s{};             // inertial rates along cross-elevation and elevation
  double bus_voltage_v = 0;
};

// Returns what a camera's picture depends on, for a camera on both joints.
inline PicturePose pose_of(const TruthState& truth) { return {truth.inertial_angle_rad, truth.base}; }

// Delivered once per 1 ms tick.
struct TickSamples {
  std::array<hal_axis_samples, kAxes> axis{};
  double bus_voltage_v = 0;
};

// Delivered once per PWM period and axis.
struct PwmSample {
  double current_a = 0;
  double bus_voltage_v = 0;
};

}  // namespace trackservo::sim

#endif
