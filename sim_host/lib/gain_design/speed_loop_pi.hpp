// SPDX-License-Identifier: Apache-2.0
// The PI of the speed loop from natural frequency and damping on the bare inertia: kp = 2 zeta w J, ki = w^2 J.
#ifndef TRACKSERVO_GAIN_DESIGN_SPEED_LOOP_PI_HPP
#define TRACKSERVO_GAIN_DESIGN_SPEED_LOOP_PI_HPP

#include "gain_design/loop_gain.hpp"

namespace trackservo::gain_design {

struct PiRequirement {
  double natural_frequency_rad_s;
  double damping;
  double setpoint_weight;
};

// Returns the firmware's parameters for it; the integral leaves a limit at the rate ki / kp.
pi_controller_params pi_params(const PiRequirement& requirement, double inertia_kg_m2);

// Writes the PI into the device's parameters, object 0x2000.
void set_pi(axis_parameters& parameters, const pi_controller_params& pi);

// Returns the natural frequency at which the closed loop with PI alone and set-point weight 1 is at -3 dB at the
// bandwidth, delays included [rad/s]. Sensors and filters are those of `loop`. At most 2 pi times the bandwidth: above
// that, delays make the loop oscillate before it gets so fast.
double natural_frequency_rad_s(const LinearMachine& sliding, const speed_loop_params& loop, double bandwidth_hz,
                               double damping);

// Returns the loop with its PI's natural frequency and its observer's bandwidth scaled by these shares.
speed_loop_params lowered(speed_loop_params loop, double pi_share, double observer_share);

// Returns the loop as the firmware runs it where the motor turns this share of the inertia that it is designed for
// (speed_loop_follow).
speed_loop_params followed(speed_loop_params loop, float share);

// Returns the loop without its observer.
speed_loop_params pi_alone(speed_loop_params loop);

}  // namespace trackservo::gain_design

#endif
