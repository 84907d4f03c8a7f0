// SPDX-License-Identifier: Apache-2.0
#include "machine/plant/motor.hpp"

namespace trackservo::sim {

MotorShape motor_shape(const MotorConfig& config, double joint_angle_rad) {
  MotorShape shape{1.0, 0.0, 0.0, 0.0};
  for (const RippleConfig& ripple : config.ripple) {
    const double argument = ripple.harmonic * joint_angle_rad + ripple.phase_rad;
    shape.ripple += ripple.fraction * std::cos(argument);
    shape.ripple_slope_1_rad -= ripple.fraction * ripple.harmonic * std::sin(argument);
  }
  for (const CoggingConfig& cogging : config.cogging) {
    const double argument = cogging.harmonic * joint_angle_rad + cogging.phase_rad;
    shape.cogging_nm += cogging.amplitude_nm * std::sin(argument);
    shape.cogging_slope_nm_rad += cogging.amplitude_nm * cogging.harmonic * std::cos(argument);
  }
  return shape;
}

}  // namespace trackservo::sim
