// SPDX-License-Identifier: Apache-2.0
// The motion in a recording: the rate of the joint in each tick, and the motion of the base.
//
// Friction follows the joint, inertia follows the inertial rate. The encoder is the better sensor of fast motion: a
// gyro is delayed by its filter, and a delay of 0.5 ms at 2 Hz looks like several percent of sigma2. Only the gyro
// measures the base. So the gyro is first compared with the encoder, gyro = bias + (1 + scale) rate - delay *
// acceleration, and only the remainder, low-passed, counts as base motion.
//
// If the encoder is too coarse for fast motion, the gyro is used above kBaseCutoff_hz: the angle is then the encoder's,
// low-passed, plus the gyro's integral above that frequency.
#ifndef TRACKSERVO_IDENTIFICATION_MOTION_HPP
#define TRACKSERVO_IDENTIFICATION_MOTION_HPP

#include <vector>

#include "identification/recording.hpp"

namespace trackservo::identification {

// The gyro's response to the joint's motion.
struct GyroFit {
  bool fitted = false;  // there is a gyro, and enough motion to compare
  double bias_rad_s = 0;
  double scale_error = 0;
  double delay_s = 0;
  double noise_rad_s = 0;  // rms, white from tick to tick
};

struct Motion {
  std::vector<Stretch> stretches;
  std::vector<double> joint_angle_rad;  // from the encoder, or from encoder and gyro together
  // Mean joint rate between the previous tick and this one, low-passed without phase: at standstill the encoder's noise
  // would move the bristles back and forth and relax them.
  std::vector<double> joint_rate_rad_s;
  std::vector<double> base_rate_rad_s;  // of the tick; 0 without a gyro
  GyroFit gyro;
  double angle_noise_rad = 0;    // rms of joint_angle_rad's noise, from its remainder at high frequency
  double encoder_noise_rad = 0;  // the same of the encoder alone
  bool fused = false;            // joint_angle_rad is from encoder and gyro
};

constexpr double kMotionCutoff_hz = 80;
constexpr double kBaseCutoff_hz = 10;

// Returns the motion with rates low-passed at `cutoff_hz`. `fuse`: use the gyro, if there is one, for fast motion.
Motion analyse_motion(const Recording& recording, double cutoff_hz = kMotionCutoff_hz, bool fuse = false);

}  // namespace trackservo::identification

#endif
