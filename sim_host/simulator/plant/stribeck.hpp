// The Stribeck curve, eq. (3): g(v) = Tc + (Ts - Tc) exp(-(v/vs)^2), and its slope.
//
// Both friction models of the plant use this level, so that they agree in steady sliding.
#ifndef TRACKSERVO_SIM_PLANT_STRIBECK_HPP
#define TRACKSERVO_SIM_PLANT_STRIBECK_HPP

#include <cmath>

#include "config/plant_config.hpp"

namespace trackservo::sim {

// e^-x for an x that changes slowly from call to call: a Taylor polynomial around the last x for which the exponential
// was computed, accurate to 2e-12.
class CreepingExponential {
 public:
  double of_minus(double x) {
    const double back = anchor_ - x;
    if (!(std::abs(back) < kReach)) {
      anchor_ = x;
      value_ = std::exp(-x);
      return value_;
    }
    return value_ *
           (1.0 + back * (1.0 + back * (1.0 / 2.0 + back * (1.0 / 6.0 + back * (1.0 / 24.0 + back * (1.0 / 120.0))))));
  }

 private:
  static constexpr double kReach = 1.0 / 32.0;  // kReach^6 / 6! = 1.3e-12

  double anchor_ = 0.0;
  double value_ = 1.0;
};

struct StribeckPoint {
  double level_nm;          // g(v) > 0
  double inverse_1_nm;      // 1 / g(v)
  double relative_slope_v;  // v g'(v) / g(v), dimensionless, <= 0
};

class Stribeck {
 public:
  explicit Stribeck(const StribeckConfig& direction)
      : coulomb_nm_(direction.coulomb_nm),
        excess_nm_(direction.breakaway_nm - direction.coulomb_nm),
        inverse_speed_s_rad_(1.0 / direction.stribeck_speed_rad_s),
        viscous_nm_s_rad_(direction.viscous_nm_s_rad) {}

  // g and its slope at a joint rate [rad/s] of either sign; takes one exponential when the rate jumps. `level` scales
  // Tc and Ts, > 0.
  StribeckPoint at(double joint_rate_rad_s, double level) {
    constexpr double kGone =
        40.0;  // e^-40 = 4e-18 is negligible compared to Tc, and avoids the exponential's slow underflow
    const double ratio = joint_rate_rad_s * inverse_speed_s_rad_;
    const double square = ratio * ratio;
    const double excess_nm = square < kGone ? level * excess_nm_ * exponential_.of_minus(square) : 0.0;
    const double level_nm = level * coulomb_nm_ + excess_nm;
    const double inverse = 1.0 / level_nm;
    return {level_nm, inverse, -2.0 * square * excess_nm * inverse};
  }

  double breakaway_nm() const { return coulomb_nm_ + excess_nm_; }  // Ts at level 1
  double viscous_nm_s_rad() const { return viscous_nm_s_rad_; }

 private:
  double coulomb_nm_;
  double excess_nm_;
  double inverse_speed_s_rad_;
  double viscous_nm_s_rad_;
  CreepingExponential exponential_;
};

}  // namespace trackservo::sim

#endif
