// SPDX-License-Identifier: Apache-2.0
// First- or second-order low-pass of unit gain, discretised exactly.
//
//   order 1: 1 / (1 + s/w),   order 2: 1 / (1 + sqrt(2) s/w + (s/w)^2),   w = 2 pi bandwidth (the -3 dB point of both)
//
// advance() is exact for an input that is linear between calls (ramp-invariant), advance_held() for one that is
// constant (step-invariant).
#ifndef TRACKSERVO_SIM_SENSORS_LOW_PASS_HPP
#define TRACKSERVO_SIM_SENSORS_LOW_PASS_HPP

#include <array>

namespace trackservo::sim {

class LowPass {
 public:
  // Makes a filter. bandwidth_hz > 0, order 1 or 2, dt_s > 0: time between calls.
  LowPass(double bandwidth_hz, int order, double dt_s);

  // Returns the output for the new input; the input is linear since the last call.
  double advance(double input) {
    const double first = a00_ * first_ + last_[0] * previous_ + new_[0] * input;
    if (second_order_) {
      const double cross = a01_ * second_;
      second_ = a10_ * first_ + a11_ * second_ + last_[1] * previous_ + new_[1] * input;
      first_ = first + cross;
    } else {
      first_ = first;
    }
    previous_ = input;
    return first_;
  }

  // Returns the output for an input that is constant since the last call.
  double advance_held(double input) {
    previous_ = input;
    return advance(input);
  }

 private:
  bool second_order_;
  double a00_, a01_, a10_, a11_;  // transition of the state
  std::array<double, 2> last_;    // weights of the previous and the new input
  std::array<double, 2> new_;
  double first_ = 0;   // output
  double second_ = 0;  // its derivative, in units of w
  double previous_ = 0;
};

}  // namespace trackservo::sim

#endif
