// SPDX-License-Identifier: Apache-2.0
// What acts on a closed speed loop, and what it does to rate and torque.
//
//   rate error = mechanics / (1 + L) disturbance - drive feedback / (1 + L) (angle noise_angle + gyro noise_gyro)
//
// L and the transfers are those of loop_gain.hpp. The set-point is constant, the base is at rest, friction is its
// linear model. What is left out: ripple, eccentricity, bias and scale of the sensors, which a constant rate does not
// average.
#ifndef TRACKSERVO_GAIN_DESIGN_RATE_ERROR_HPP
#define TRACKSERVO_GAIN_DESIGN_RATE_ERROR_HPP

#include "gain_design/disturbance.hpp"
#include "gain_design/loop_gain.hpp"

namespace trackservo::gain_design {

// Noise of the sensors: white from tick to tick.
struct SensorNoise {
  double angle_rad = 0.0;   // rms of the encoder's reading
  double gyro_rad_s = 0.0;  // rms of the gyro's reading
};

// Rms of the joint rate, by its causes.
struct RateError {
  double disturbance_rad_s = 0.0;
  double encoder_rad_s = 0.0;
  double gyro_rad_s = 0.0;

  double rad_s() const;  // of all
};

// The part of the rate error around one frequency.
struct RateErrorLine {
  double frequency_hz = 0.0;
  std::complex<double> loop_gain;
  RateError error;
};

// Returns the parts from 0.01 Hz up to half the tick's rate.
std::vector<RateErrorLine> rate_error_spectrum(const LinearMachine& machine, const speed_loop_params& params,
                                               const Disturbance& disturbance, const SensorNoise& noise);

// Returns their sum.
RateError rate_error(const LinearMachine& machine, const speed_loop_params& params, const Disturbance& disturbance,
                     const SensorNoise& noise);

// Returns the rms of the torque command that the sensors' noise causes in the closed loop [Nm], up to half the tick's
// rate.
double torque_noise_nm(const LinearMachine& machine, const speed_loop_params& params, const SensorNoise& noise);

}  // namespace trackservo::gain_design

#endif
