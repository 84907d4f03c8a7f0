#include "identification/motion.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "identification/low_pass.hpp"
#include "identification/sensor_noise.hpp"

namespace trackservo::identification {

namespace {

// Mean rates between ticks, from the smoothed angle. The first tick of a stretch takes the second's.
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

// What the gyro sees and the encoder does not.
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

}  // namespace

Motion analyse_motion(const Recording& recording, double cutoff_hz) {
  Motion motion;
  motion.stretches = stretches(recording);
  motion.joint_rate_rad_s.assign(recording.ticks(), 0.0);
  motion.base_rate_rad_s.assign(recording.ticks(), 0.0);
  std::vector<double> smooth_rad(recording.ticks());
  const LowPass filter(cutoff_hz);
  for (const Stretch& stretch : motion.stretches) {
    filter.smooth(recording.joint_angle_rad, stretch.first, stretch.last, smooth_rad);
    joint_rates(smooth_rad, stretch, motion.joint_rate_rad_s);
  }
  motion.angle_noise_rad = white_noise_rms(recording.joint_angle_rad, motion.stretches);
  if (recording.has_gyro()) {
    motion.gyro = fit_gyro(recording, motion);
    if (motion.gyro.fitted) {
      motion.gyro.noise_rad_s = white_noise_rms(recording.inertial_rate_rad_s, motion.stretches);
      find_base_motion(recording, motion);
    }
  }
  return motion;
}

}  // namespace trackservo::identification
