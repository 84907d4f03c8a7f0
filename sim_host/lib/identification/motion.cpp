// SPDX-License-Identifier: Apache-2.0
#include "identification/motion.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "identification/low_pass.hpp"
#include "identification/sensor_noise.hpp"

namespace trackservo::identification {

namespace {

// Noise of a coarse encoder must not hide the gyro's delay: they are compared below this.
constexpr double kCoarseCutoff_hz = 25;

// Mean rates between ticks, from the smoothed angle. The first tick of a stretch uses the second's.
void joint_rates(const std::vector<double>& angle_rad, const Stretch& stretch, std::vector<double>& rate_rad_s) {
  for (std::size_t i = stretch.first + 1; i < stretch.last; ++i) {
    rate_rad_s[i] = (angle_rad[i] - angle_rad[i - 1]) / kTick_s;
  }
  if (stretch.ticks() > 1) {
    rate_rad_s[stretch.first] = rate_rad_s[stretch.first + 1];
  }
}

// Joint rate and acceleration at a tick, from the mean rates on both sides; not for the ends of a stretch.
double rate_at(const Motion& motion, std::size_t i) {
  return 0.5 * (motion.joint_rate_rad_s[i] + motion.joint_rate_rad_s[i + 1]);
}
double acceleration_at(const Motion& motion, std::size_t i) {
  return (motion.joint_rate_rad_s[i + 1] - motion.joint_rate_rad_s[i]) / kTick_s;
}

GyroFit fit_gyro(const Recording& recording, const Motion& motion) {
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Eigen::Vector3d right = Eigen::Vector3d::Zero();
  for (const Stretch& stretch : motion.stretches) {
    for (std::size_t i = stretch.first + 1; i + 1 < stretch.last; ++i) {
      const double rate = rate_at(motion, i);
      const Eigen::Vector3d shape(1.0, rate, -acceleration_at(motion, i));
      normal += shape * shape.transpose();
      right += shape * (recording.inertial_rate_rad_s[i] - rate);
    }
  }
  const Eigen::FullPivLU<Eigen::Matrix3d> solver(normal);
  if (!solver.isInvertible()) {
    return {};
  }
  const Eigen::Vector3d solution = solver.solve(right);
  return {true, solution[0], solution[1], solution[2]};
}

// Motion that the gyro measures and the encoder does not.
void find_base_motion(const Recording& recording, Motion& motion) {
  std::vector<double> left(recording.ticks(), 0.0);
  for (const Stretch& stretch : motion.stretches) {
    for (std::size_t i = stretch.first + 1; i + 1 < stretch.last; ++i) {
      const double shown = motion.gyro.bias_rad_s + (1.0 + motion.gyro.scale_error) * rate_at(motion, i) -
                           motion.gyro.delay_s * acceleration_at(motion, i);
      left[i] = recording.inertial_rate_rad_s[i] - shown;
    }
    LowPass(kBaseCutoff_hz).smooth(left, stretch.first, stretch.last, motion.base_rate_rad_s);
  }
}

// The gyro's integral, without its bias, scale error and delay, replaces the encoder above kBaseCutoff_hz.
void let_gyro_have_quick_motion(const Recording& recording, Motion& motion) {
  const LowPass filter(kBaseCutoff_hz);
  std::vector<double> difference(recording.ticks());
  std::vector<double> turned(recording.ticks());
  std::vector<double> slow(recording.ticks());
  for (const Stretch& stretch : motion.stretches) {
    double integral_rad = recording.joint_angle_rad[stretch.first];
    double last_rad_s = 0;
    for (std::size_t i = stretch.first; i < stretch.last; ++i) {
      const double rate_rad_s =
          (recording.inertial_rate_rad_s[i] - motion.gyro.bias_rad_s) / (1.0 + motion.gyro.scale_error);
      integral_rad += i == stretch.first ? 0.0 : 0.5 * (last_rad_s + rate_rad_s) * kTick_s;
      last_rad_s = rate_rad_s;
      turned[i] = integral_rad + motion.gyro.delay_s * rate_rad_s;
      difference[i] = recording.joint_angle_rad[i] - turned[i];
    }
    filter.smooth(difference, stretch.first, stretch.last, slow);
    for (std::size_t i = stretch.first; i < stretch.last; ++i) {
      motion.joint_angle_rad[i] = turned[i] + slow[i];
    }
  }
  motion.fused = true;
}

void find_rates(double cutoff_hz, Motion& motion) {
  std::vector<double> smooth_rad(motion.joint_angle_rad.size());
  const LowPass filter(cutoff_hz);
  for (const Stretch& stretch : motion.stretches) {
    filter.smooth(motion.joint_angle_rad, stretch.first, stretch.last, smooth_rad);
    joint_rates(smooth_rad, stretch, motion.joint_rate_rad_s);
  }
}

}  // namespace

Motion analyse_motion(const Recording& recording, double cutoff_hz, bool fuse) {
  Motion motion;
  motion.stretches = stretches(recording);
  motion.joint_angle_rad = recording.joint_angle_rad;
  motion.joint_rate_rad_s.assign(recording.ticks(), 0.0);
  motion.base_rate_rad_s.assign(recording.ticks(), 0.0);
  find_rates(fuse ? kCoarseCutoff_hz : cutoff_hz, motion);
  if (recording.has_gyro()) {
    motion.gyro = fit_gyro(recording, motion);
    if (motion.gyro.fitted) {
      motion.gyro.noise_rad_s = white_noise_rms(recording.inertial_rate_rad_s, motion.stretches);
      find_base_motion(recording, motion);
    }
  }
  if (fuse && motion.gyro.fitted) {
    let_gyro_have_quick_motion(recording, motion);
    find_rates(cutoff_hz, motion);
  }
  motion.encoder_noise_rad = white_noise_rms(recording.joint_angle_rad, motion.stretches);
  motion.angle_noise_rad = white_noise_rms(motion.joint_angle_rad, motion.stretches);
  return motion;
}

}  // namespace trackservo::identification
