// SPDX-License-Identifier: Apache-2.0
// The Stribeck curve, eq. (3): g(v) = Tc + (Ts - Tc) exp(-(v/vs)^2), and its slope.
//
// Both friction models of the plant use this level, so that they agree in steady sliding.
#ifndef TRACKSERVO_SIM_PLANT_STRIBECK_HPP
#define TRACKSERVO_SIM_PLANT_STRIBECK_HPP

#include <cmath>

#include "machine/config/plant_config.hpp"
#include "machine/plant/lanes.hpp"

namespace trackservo::sim {

// e^-x for an x that changes slowly from call to call: a Taylor polynomial around the last x for which the exponential
// was computed, accurate to 2e-12.
template <class Real>
class CreepingExponential {
 public:
  // Returns e^-x. In the lanes that are not `needed`, anything; what they remember is left as it is.
  Real of_minus(Real x, Mask<Real> needed) {
    Real back = anchor_ - x;
    const Mask<Real> far = both(needed, opposite(magnitude(back) < every<Real>(kReach)));
    if (any(far)) {
      move_anchor(x, far);
      back = anchor_ - x;
    }
    return value_ *
           (1.0 + back * (1.0 + back * (1.0 / 2.0 + back * (1.0 / 6.0 + back * (1.0 / 24.0 + back * (1.0 / 120.0))))));
  }

  static void exchange_lanes(Mask<Real> where, CreepingExponential& a, CreepingExponential& b) {
    exchange(where, a.anchor_, b.anchor_);
    exchange(where, a.value_, b.value_);
  }

 private:
  static constexpr double kReach = 1.0 / 32.0;  // kReach^6 / 6! = 1.3e-12

  void move_anchor(Real x, Mask<Real> where) {
    for (std::size_t i = 0; i < kLanes<Real>; ++i) {
      if (is_set(where, i)) {
        set_lane(anchor_, i, lane(x, i));
        set_lane(value_, i, std::exp(-lane(x, i)));
      }
    }
  }

  Real anchor_{};
  Real value_ = every<Real>(1.0);
};

template <class Real>
struct StribeckPoint {
  Real level_nm;          // g(v) > 0
  Real inverse_1_nm;      // 1 / g(v)
  Real relative_slope_v;  // v g'(v) / g(v), dimensionless, <= 0
};

// One direction of motion in each lane.
template <class Real>
class Stribeck {
 public:
  void set(std::size_t i, const StribeckConfig& direction) {
    set_lane(coulomb_nm_, i, direction.coulomb_nm);
    set_lane(excess_nm_, i, direction.breakaway_nm - direction.coulomb_nm);
    set_lane(inverse_speed_s_rad_, i, 1.0 / direction.stribeck_speed_rad_s);
    set_lane(viscous_nm_s_rad_, i, direction.viscous_nm_s_rad);
  }

  // Returns g and its slope at a joint rate [rad/s] of either sign; takes one exponential when the rate jumps. `level`
  // scales Tc and Ts, > 0. In the lanes that are not `needed`, anything.
  StribeckPoint<Real> at(Real joint_rate_rad_s, Real level, Mask<Real> needed) {
    constexpr double kGone =
        40.0;  // e^-40 = 4e-18 is negligible compared to Tc, and avoids the exponential's slow underflow
    const Real ratio = joint_rate_rad_s * inverse_speed_s_rad_;
    const Real square = ratio * ratio;
    const Mask<Real> near = square < every<Real>(kGone);
    const Real near_nm = level * excess_nm_ * exponential_.of_minus(square, both(needed, near));
    const Real excess_nm = select(near, near_nm, Real{});
    const Real level_nm = level * coulomb_nm_ + excess_nm;
    const Real inverse = 1.0 / level_nm;
    return {level_nm, inverse, -2.0 * square * excess_nm * inverse};
  }

  Real breakaway_nm() const { return coulomb_nm_ + excess_nm_; }  // Ts at level 1
  Real viscous_nm_s_rad() const { return viscous_nm_s_rad_; }

  static void exchange_lanes(Mask<Real> where, Stribeck& a, Stribeck& b) {
    exchange(where, a.coulomb_nm_, b.coulomb_nm_);
    exchange(where, a.excess_nm_, b.excess_nm_);
    exchange(where, a.inverse_speed_s_rad_, b.inverse_speed_s_rad_);
    exchange(where, a.viscous_nm_s_rad_, b.viscous_nm_s_rad_);
    CreepingExponential<Real>::exchange_lanes(where, a.exponential_, b.exponential_);
  }

 private:
  Real coulomb_nm_{};
  Real excess_nm_{};
  Real inverse_speed_s_rad_{};
  Real viscous_nm_s_rad_{};
  CreepingExponential<Real> exponential_;
};

}  // namespace trackservo::sim

#endif
