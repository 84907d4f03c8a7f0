// SPDX-License-Identifier: Apache-2.0
#include "machine/sensors/low_pass.hpp"

#include <Eigen/Core>
#include <cmath>
#include <unsupported/Eigen/MatrixFunctions>

#include "machine/base/axis.hpp"

namespace trackservo::sim {

LowPass::LowPass(double bandwidth_hz, int order, double dt_s) : second_order_(order == 2) {
  const double w = 2.0 * kPi * bandwidth_hz;
  // State, input, and input slope in one homogeneous system; its exponential holds all coefficients.
  Eigen::Matrix4d system = Eigen::Matrix4d::Zero();
  if (!second_order_) {
    system(0, 0) = -w;
    system(0, 2) = w;
  } else {
    system(0, 1) = w;  // the second state is the derivative in units of w
    system(1, 0) = -w;
    system(1, 1) = -std::sqrt(2.0) * w;
    system(1, 2) = w;
  }
  system(2, 3) = 1.0 / dt_s;  // the fourth state is the input's change over the step
  const Eigen::Matrix4d scaled = system * dt_s;
  const Eigen::Matrix4d exponential = scaled.exp();
  a00_ = exponential(0, 0);
  a01_ = exponential(0, 1);
  a10_ = exponential(1, 0);
  a11_ = exponential(1, 1);
  new_ = {exponential(0, 3), exponential(1, 3)};
  last_ = {exponential(0, 2) - new_[0], exponential(1, 2) - new_[1]};
}

}  // namespace trackservo::sim
