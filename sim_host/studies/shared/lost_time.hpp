// SPDX-License-Identifier: Apache-2.0
// How long a target is lost: from the first time at which the line of sight is more than kLost_rad off, to the last.
//
// The time-optimal plan of the azimuth follows the target until it needs more than a limit of rate or acceleration,
// turns at these limits, and meets the target with its rate. Leaving the target earlier, to turn ahead of it, does not
// help: the mirrored plan takes as long, and each plan between the two takes longer, because then more of the time in
// which the target is fastest lies in the middle.
#ifndef TRACKSERVO_SIM_STUDIES_SHARED_LOST_TIME_HPP
#define TRACKSERVO_SIM_STUDIES_SHARED_LOST_TIME_HPP

#include <algorithm>
#include <limits>

#include "machine/config/scenario_config.hpp"

namespace trackservo::sim {

constexpr double kLost_rad = 50e-6;

class LostTime {
 public:
  // Call it once per tick, in the order of time.
  void add(double time_s, double angle_rad) {
    is_lost_ = !(angle_rad <= kLost_rad);
    if (is_lost_) {
      first_s_ = std::min(first_s_, time_s);
      last_s_ = time_s + kTick_s;
    }
  }

  // Returns the time for which it is lost; 0: never lost; infinite: lost at the end.
  double seconds() const {
    return is_lost_ ? std::numeric_limits<double>::infinity() : std::max(0.0, last_s_ - first_s_);
  }

 private:
  bool is_lost_ = false;
  double first_s_ = std::numeric_limits<double>::infinity();
  double last_s_ = 0;
};

// Of the azimuth.
struct TurnLimits {
  double rate_rad_s = 0;
  double acceleration_rad_s2 = std::numeric_limits<double>::infinity();
};

// Returns the time-optimal plan [s], to 1 ms; 0: the target is never faster than the limits.
double optimal_lost_s(const PassConfig& pass, const TurnLimits& limits);

// What is required of a pass that no azimuth can follow: at most this share of the time-optimal plan.
constexpr double kLostGoal = 1.2;

}  // namespace trackservo::sim

#endif
