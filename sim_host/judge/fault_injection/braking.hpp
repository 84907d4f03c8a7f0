// SPDX-License-Identifier: Apache-2.0
// How far an axis moves from the detection of a fault until it stands still.
#ifndef TRACKSERVO_SIM_FAULT_INJECTION_BRAKING_HPP
#define TRACKSERVO_SIM_FAULT_INJECTION_BRAKING_HPP

#include <cmath>

#include "machine/plant/truth.hpp"

namespace trackservo::sim {

class Braking {
 public:
  Braking() = default;
  explicit Braking(double from_rad) : from_rad_(from_rad) {}

  // Call it once a tick; returns true in the tick in which the axis comes to rest. The travel ends there.
  bool step(const TruthState& truth, int axis) {
    constexpr double kStandstill_rad_s = 2e-3;
    if (at_rest_) {
      return false;
    }
    const auto i = static_cast<std::size_t>(axis);
    travel_rad_ = truth.joint_angle_rad[i] - from_rad_;
    at_rest_ = std::abs(truth.joint_rate_rad_s[i]) < kStandstill_rad_s;
    return at_rest_;
  }

  bool at_rest() const { return at_rest_; }
  double travel_rad() const { return travel_rad_; }  // signed

 private:
  double from_rad_ = 0;
  double travel_rad_ = 0;
  bool at_rest_ = false;
};

}  // namespace trackservo::sim

#endif
