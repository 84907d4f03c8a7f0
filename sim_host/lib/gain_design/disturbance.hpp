// SPDX-License-Identifier: Apache-2.0
// A slow torque from outside, such as wind: white noise through two equal real poles.
//
//   S(f) = 4 rms^2 / (pi f_c) / (1 + (f / f_c)^2)^2,   one-sided, Nm^2/Hz
#ifndef TRACKSERVO_GAIN_DESIGN_DISTURBANCE_HPP
#define TRACKSERVO_GAIN_DESIGN_DISTURBANCE_HPP

#include <optional>
#include <vector>

namespace trackservo::gain_design {

struct Disturbance {
  double rms_nm = 0.0;
  double corner_hz = 1.0;  // > 0
};

// Returns S(f).
double density_nm2_hz(const Disturbance& disturbance, double frequency_hz);

// What an identification could not explain, as an autoregressive process of equidistant residuals r:
//   e_k = r_k + a_1 r_(k-1) + ... + a_p r_(k-p),   e white
struct ResidualNoise {
  double step_s = 0.0;                 // > 0
  double innovation_nm = 0.0;          // rms of e
  std::vector<double> autoregression;  // a
};

// Returns S_r(f) up to half the rate of the residuals.
double density_nm2_hz(const ResidualNoise& noise, double frequency_hz);

// Returns the disturbance whose spectrum is nearest to that of the residuals, on logarithmic scales, from 0.1 Hz to
// where theirs is lowest, at most 20 Hz: above, they are noise of the sensors. Nothing when their spectrum does not
// fall by a factor of ten.
std::optional<Disturbance> slow_disturbance(const ResidualNoise& noise);

}  // namespace trackservo::gain_design

#endif
