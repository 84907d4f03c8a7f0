// SPDX-License-Identifier: Apache-2.0
// Spring-applied holding brake on a joint: springs close it, a coil with current opens it.
//
// A closed brake is dry friction of up to its torque in addition to the seal's. It holds the joint while all other
// torques are smaller, and slips beyond (Joint::brake). It closes and opens a fixed time after the coil's current
// changed, instantly and completely. The creep of a real brake by its backlash is not modelled. The firmware
// controls its coil (hal_release_brake).
//
// Use: power() whenever the coil's current changes, advance() once per PWM period, then torque_nm().
#ifndef TRACKSERVO_SIM_PLANT_HOLDING_BRAKE_HPP
#define TRACKSERVO_SIM_PLANT_HOLDING_BRAKE_HPP

#include "machine/config/plant_config.hpp"

namespace trackservo::sim {

class HoldingBrake {
 public:
  // Starts without current, closed. dt_s: the PWM period [s].
  HoldingBrake(const HoldingBrakeConfig& config, double dt_s) : config_(config), dt_s_(dt_s) {}

  void power(bool on) {
    left_s_ = on == powered_ ? left_s_ : (on ? config_.release_s : config_.engage_s);
    powered_ = on;
  }

  void advance() {
    left_s_ -= dt_s_;
    closed_ = left_s_ > 0.0 ? closed_ : !powered_;
  }

  bool is_open() const { return !closed_; }
  double torque_nm() const { return closed_ ? config_.torque_nm : 0.0; }

 private:
  HoldingBrakeConfig config_;
  double dt_s_;
  double left_s_ = 0;  // until the springs or the coil have moved it
  bool powered_ = false;
  bool closed_ = true;
};

}  // namespace trackservo::sim

#endif
