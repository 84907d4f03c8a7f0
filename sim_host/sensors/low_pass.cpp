#include "sensors/low_pass.hpp"

#include <cmath>
#include <unsupported/Eigen/MatrixFunctions>

#include "plant/axis.hpp"

namespace trackservo::sim {

LowPass::LowPass(double bandwidth_hz, int order, double dt_s) {
  const double w = 2.0 * kPi * bandwidth_hz;
  // State, input, and input slope in one homogeneous system; its exponential holds all coefficients.
  Eigen::Matrix4d system = Eigen::Matrix4d::Zero();
  if (order == 1) {
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
  transition_ = exponential.topLeftCorner<2, 2>();
  from_new_ = exponential.topRightCorner<2, 1>();
  from_last_ = exponential.block<2, 1>(0, 2) - from_new_;
  if (order == 1) {
    transition_(1, 1) = 0.0;  // unused state
  }
}

}  // namespace trackservo::sim
