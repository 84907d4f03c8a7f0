// SPDX-License-Identifier: Apache-2.0
#include "gain_design/speed_loop_pi.hpp"

#include <cmath>

namespace trackservo::gain_design {

pi_controller_params pi_params(const PiRequirement& requirement, double inertia_kg_m2) {
  const double w = requirement.natural_frequency_rad_s;
  pi_controller_params pi{};
  pi.proportional_gain = static_cast<float>(2.0 * requirement.damping * w * inertia_kg_m2);
  pi.integral_gain = static_cast<float>(w * w * inertia_kg_m2);
  pi.setpoint_weight = static_cast<float>(requirement.setpoint_weight);
  pi.tracking_rate_per_s = static_cast<float>(0.5 * w / requirement.damping);  // ki / kp
  return pi;
}

void set_pi(axis_parameters& parameters, const pi_controller_params& pi) {
  parameters.speed_loop.proportional_nm_s_rad = pi.proportional_gain;
  parameters.speed_loop.integral_nm_rad = pi.integral_gain;
  parameters.speed_loop.setpoint_weight = pi.setpoint_weight;
  parameters.speed_loop.tracking_rate_per_s = pi.tracking_rate_per_s;
}

double natural_frequency_rad_s(const LinearMachine& sliding, const speed_loop_params& loop, double bandwidth_hz,
                               double damping) {
  speed_loop_params alone = with_plain_set_point(pi_alone(loop));
  double natural_rad_s = 0.0;
  double low = 0.01 * bandwidth_hz;
  double high = 2.0 * M_PI * bandwidth_hz;
  for (int i = 0; i < 50; ++i) {
    natural_rad_s = 0.5 * (low + high);
    alone.pi = pi_params({natural_rad_s, damping, 1.0}, sliding.inertia_kg_m2);
    const double gain = std::abs(closed_loop_gain(sliding, alone, bandwidth_hz));
    (gain < M_SQRT1_2 ? low : high) = natural_rad_s;
  }
  return natural_rad_s;
}

speed_loop_params followed(speed_loop_params loop, float share) {
  loop.pi.proportional_gain *= share;
  loop.pi.integral_gain *= share;
  loop.acceleration_inertia_kg_m2 *= share;
  loop.observer.inertia_kg_m2 *= share;
  return loop;
}

speed_loop_params lowered(speed_loop_params loop, double pi_share, double observer_share) {
  const auto pi = static_cast<float>(pi_share);
  loop.pi.proportional_gain *= pi;
  loop.pi.integral_gain *= pi * pi;
  loop.pi.tracking_rate_per_s *= pi;
  loop.observer.bandwidth_rad_s *= static_cast<float>(observer_share);
  return loop;
}

speed_loop_params pi_alone(speed_loop_params loop) {
  loop.observer_on = false;
  return loop;
}

}  // namespace trackservo::gain_design
