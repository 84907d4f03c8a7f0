// SPDX-License-Identifier: Apache-2.0
// White noise through a second-order filter, sampled without discretisation error.
//
//   dx/dt = A x + b w,  output x[0] with a given rms;  x_{k+1} = Phi x_k + S n_k,  Phi = e^(A dt),
//   S S^T = integral of e^(A t) b b^T e^(A^T t) dt (Van Loan 1978),  x_0 from the stationary distribution
//
// So mean power, spectrum and correlation at the samples are exact for any dt, and the process has no start-up. Wind
// gusts are two real poles, base sway is a resonance. next() takes two normal deviates.
#ifndef TRACKSERVO_SIM_PLANT_SHAPED_NOISE_HPP
#define TRACKSERVO_SIM_PLANT_SHAPED_NOISE_HPP

#include <Eigen/Core>

#include "machine/base/random.hpp"

namespace trackservo::sim {

class ShapedNoise {
 public:
  // Returns noise of two real poles [Hz, both > 0]; state: output and the signal before the second pole.
  static ShapedNoise two_poles(double first_hz, double second_hz, double rms, double dt_s, RandomStream stream);

  // Returns noise of a resonance [Hz > 0, damping > 0]; state: output and its time derivative.
  static ShapedNoise resonance(double frequency_hz, double damping, double rms, double dt_s, RandomStream stream);

  // Returns the present state, and the next one, dt later.
  const Eigen::Vector2d& state() const { return state_; }
  const Eigen::Vector2d& next();

 private:
  ShapedNoise(const Eigen::Matrix2d& dynamics, const Eigen::Vector2d& input, double rms, double dt_s,
              RandomStream stream);

  Eigen::Matrix2d transition_;
  Eigen::Matrix2d spread_;
  Eigen::Vector2d state_;
  RandomStream stream_;
};

}  // namespace trackservo::sim

#endif
