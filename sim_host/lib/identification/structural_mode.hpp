// SPDX-License-Identifier: Apache-2.0
// Resonances of the structure beyond the rigid body; identification finds them, gains are designed with them.
#ifndef TRACKSERVO_IDENTIFICATION_STRUCTURAL_MODE_HPP
#define TRACKSERVO_IDENTIFICATION_STRUCTURAL_MODE_HPP

#include <complex>
#include <vector>

namespace trackservo::gain_design {

// One resonance. The free axis (no friction) turns with
//
//     joint rate / torque = 1/(J s) (1 + sum of share s^2 / (s^2 + 2 damping w s + w^2))
//
// Two masses on a spring are exactly that: with the encoder on the motor's side, share = inertia behind the spring over
// inertia before it; with the encoder behind the spring, share = -1.
struct StructuralMode {
  double frequency_rad_s = 1.0;
  double damping = 0.02;  // ratio
  double share = 0.0;
};

// Returns the factor of the structure on the rigid body at s = jw.
inline std::complex<double> structural_factor(const std::vector<StructuralMode>& modes, std::complex<double> s) {
  std::complex<double> factor = 1.0;
  for (const StructuralMode& mode : modes) {
    const double w = mode.frequency_rad_s;
    factor += mode.share * s * s / (s * s + 2.0 * mode.damping * w * s + w * w);
  }
  return factor;
}

// Returns the rate behind the spring over the joint rate, for an encoder on the motor's side. The antiresonance of the
// joint is the resonance of what is behind it.
inline std::complex<double> payload_factor(const StructuralMode& mode, std::complex<double> s) {
  const double w2 = mode.frequency_rad_s * mode.frequency_rad_s / (1.0 + mode.share);
  const std::complex<double> spring = 2.0 * mode.damping / mode.frequency_rad_s * w2 * s + w2;
  return spring / (s * s + spring);
}

// Returns the height of the mode above the rigid body at its resonance; 1 is none.
inline double relative_height(const StructuralMode& mode) {
  return std::abs(std::complex<double>(1.0, 0.5 * mode.share / mode.damping));
}

}  // namespace trackservo::gain_design

#endif
