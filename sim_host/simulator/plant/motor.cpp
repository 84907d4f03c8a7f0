#include "plant/motor.hpp"

#include <algorithm>
#include <cmath>

namespace trackservo::sim {

DcMotor::DcMotor(const MotorConfig& config, double dt_s) : config_(config) {
  const double exponent = config.resistance_ohm * dt_s / config.inductance_h;
  conductance_s_ = 1.0 / config.resistance_ohm;
  decay_ = std::exp(-exponent);
  mean_share_ = -std::expm1(-exponent) / exponent;
  dead_share_ = 2.0 * config.dead_time_s / dt_s;
  // Half the peak-to-peak current ripple of unipolar modulation at half duty: below it the dead time has a partial
  // effect.
  dead_knee_a_per_v_ = dt_s / (8.0 * config.inductance_h);
}

void DcMotor::renew_shape(double joint_angle_rad) {
  shape_angle_rad_ = joint_angle_rad;
  ripple_ = 1.0;
  ripple_slope_1_rad_ = 0.0;
  for (const RippleConfig& ripple : config_.ripple) {
    const double argument = ripple.harmonic * joint_angle_rad + ripple.phase_rad;
    ripple_ += ripple.fraction * std::cos(argument);
    ripple_slope_1_rad_ -= ripple.fraction * ripple.harmonic * std::sin(argument);
  }
  cogging_nm_ = 0.0;
  cogging_slope_nm_rad_ = 0.0;
  for (const CoggingConfig& cogging : config_.cogging) {
    const double argument = cogging.harmonic * joint_angle_rad + cogging.phase_rad;
    cogging_nm_ += cogging.amplitude_nm * std::sin(argument);
    cogging_slope_nm_rad_ += cogging.amplitude_nm * cogging.harmonic * std::cos(argument);
  }
}

// The mean current of the period.
double DcMotor::step_open(double back_emf_v, double supply_v) {
  const double before_a = current_a_;
  if (before_a == 0.0) {
    return 0.0;
  }
  const double final_a = (std::copysign(supply_v, -before_a) - back_emf_v) * conductance_s_;
  const double after_a = final_a + (before_a - final_a) * decay_;
  const bool gone = after_a * before_a <= 0.0;
  current_a_ = gone ? 0.0 : after_a;
  // Nearly a straight line; it ends within the period in which the current reaches zero.
  const double share = gone ? before_a / (before_a - after_a) : 1.0;
  return 0.5 * (before_a + current_a_) * share;
}

double DcMotor::step(double voltage_v, double joint_rate_rad_s, double joint_angle_rad, double supply_v) {
  const double travel = joint_angle_rad - shape_angle_rad_;
  const double shape = share_ * (ripple_ + ripple_slope_1_rad_ * travel);
  double voltage = voltage_v;
  if (dead_share_ > 0.0) {
    const double knee_a = dead_knee_a_per_v_ * supply_v;
    voltage -= dead_share_ * supply_v * std::clamp(current_a_ / knee_a, -1.0, 1.0);
  }
  const double back_emf_v = config_.back_emf_constant_v_s_rad * shape * joint_rate_rad_s;
  if (open_) {
    return config_.torque_constant_nm_a * shape * step_open(back_emf_v, supply_v) + cogging_nm_ +
           cogging_slope_nm_rad_ * travel;
  }
  const double final_a = (voltage - back_emf_v) * conductance_s_;
  const double distance_a = current_a_ - final_a;
  const double mean_a = final_a + distance_a * mean_share_;
  current_a_ = final_a + distance_a * decay_;
  return config_.torque_constant_nm_a * shape * mean_a + cogging_nm_ + cogging_slope_nm_rad_ * travel;
}

}  // namespace trackservo::sim
