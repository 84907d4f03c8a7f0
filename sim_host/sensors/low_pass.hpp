// First- or second-order low-pass of unit gain, discretised exactly.
//
//   order 1: 1 / (1 + s/w),   order 2: 1 / (1 + sqrt(2) s/w + (s/w)^2),   w = 2 pi bandwidth (the -3 dB point of both)
//
// advance() is exact for an input that is linear between calls (ramp-invariant), advance_held() for one that is
// constant (step-invariant).
#ifndef TRACKSERVO_SIM_SENSORS_LOW_PASS_HPP
#define TRACKSERVO_SIM_SENSORS_LOW_PASS_HPP

#include <Eigen/Core>

namespace trackservo::sim {

class LowPass {
 public:
  // bandwidth_hz > 0, order 1 or 2, dt_s > 0: time between calls.
  LowPass(double bandwidth_hz, int order, double dt_s);

  // Output for the new input, reached linearly from the last.
  double advance(double input) {
    const Eigen::Vector2d next = transition_ * state_ + from_last_ * last_ + from_new_ * input;
    state_ = next;
    last_ = input;
    return state_[0];
  }

  // Output for an input that holds since the last call.
  double advance_held(double input) {
    last_ = input;
    return advance(input);
  }

 private:
  Eigen::Matrix2d transition_ = Eigen::Matrix2d::Zero();
  Eigen::Vector2d from_last_ = Eigen::Vector2d::Zero();
  Eigen::Vector2d from_new_ = Eigen::Vector2d::Zero();
  Eigen::Vector2d state_ = Eigen::Vector2d::Zero();
  double last_ = 0;
};

}  // namespace trackservo::sim

#endif
