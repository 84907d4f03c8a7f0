// SPDX-License-Identifier: Apache-2.0
// LuGre seal friction for the plant, eqs (1)-(3), solved together with the joint rate.
//
//   Tf = s0 z + s1 dz/dt + s2 v,   dz/dt = v - N(v, z),   N = s0 |v| z / g(v)
//
// The firmware holds the speed over its tick and uses the exponential solution. The plant deliberately uses another
// method: a linearly implicit (Rosenbrock-type) theta step of the pair (v, z). N is linearised at a predicted mid speed
// v*, and z is eliminated. The result is a friction torque affine in the unknown mid speed, a + b v, that Joint solves;
// commit() then advances z. theta is 1/2 (second order) and rises towards 1 where s0 |v| dt / g > 2, which keeps z
// monotone for any parameters. The paper's s1 is not reduced, also at high speed.
#ifndef TRACKSERVO_SIM_PLANT_LUGRE_FRICTION_HPP
#define TRACKSERVO_SIM_PLANT_LUGRE_FRICTION_HPP

#include <algorithm>
#include <cmath>

#include "machine/config/plant_config.hpp"
#include "machine/plant/lanes.hpp"
#include "machine/plant/stribeck.hpp"

namespace trackservo::sim {

// Friction torque over one step as a function of the joint rate at its theta point: constant_nm + slope * rate.
template <class Real>
struct AffineFriction {
  Real constant_nm{};
  Real slope_nm_s_rad{};
  Real theta = every<Real>(0.5);  // point of the step at which rate and torque are taken, 1/2..1
  Real inverse_theta = every<Real>(2.0);
};

template <class Real>
class LugreFriction {
 public:
  // Sets the friction of a lane, which is one axis. dt_s: the step length [s], the only one that it accepts.
  void set(std::size_t i, const FrictionConfig& config, double dt_s) {
    ahead_.set(i, config.positive);
    other_.set(i, config.negative);
    set_lane(stiffness_nm_rad_, i, config.stiffness_nm_rad);
    set_lane(damping_per_step_nm_rad_, i, config.damping_nm_s_rad / dt_s);
    set_lane(stiffness_dt_nm_s_rad_, i, config.stiffness_nm_rad * dt_s);
    dt_s_ = dt_s;
  }

  void relax(std::size_t i) {
    set_lane(deflection_rad_, i, 0.0);
    set_lane(middle_rad_, i, 0.0);
  }

  // Linearises the step around the predicted rate at its middle [rad/s]. `level` scales Tc and Ts. `min_slope` is a
  // lower bound of the (possibly negative) slope, so that the joint's equation stays well posed. Lanes that do not move
  // have no step.
  AffineFriction<Real> linearise(Real rate_rad_s, Real level, Real min_slope_nm_s_rad, Mask<Real> moves) {
    turn_to(rate_rad_s >= Real{});
    const StribeckPoint<Real> point = ahead_.at(rate_rad_s, level, moves);
    const Real per_travel = stiffness_nm_rad_ * point.inverse_1_nm;
    const Real speed_rad_s = magnitude(rate_rad_s);
    const Real relaxation = per_travel * speed_rad_s;              // [1/s]
    const Real stretch_nm = stiffness_dt_nm_s_rad_ * speed_rad_s;  // by g(v): the decay over the step
    AffineFriction<Real> affine;
    const Mask<Real> fast = stretch_nm > 2.0 * point.level_nm;
    if (any(fast)) {
      affine.theta = select(fast, 1.0 - point.level_nm / stretch_nm, affine.theta);
      affine.inverse_theta = select(fast, 1.0 / affine.theta, affine.inverse_theta);
    }
    Real rate_share = with_sign(per_travel, rate_rad_s) * middle_rad_ * (1.0 - point.relative_slope_v);  // dN/dv
    const Real gain_s = dt_s_ * point.level_nm / (point.level_nm + affine.theta * stretch_nm);
    const Real torque_per_step_nm_rad = affine.theta * stiffness_nm_rad_ + damping_per_step_nm_rad_;
    const Real viscous_nm_s_rad = ahead_.viscous_nm_s_rad();
    step_slope_s_ = gain_s * (1.0 - rate_share);
    affine.slope_nm_s_rad = torque_per_step_nm_rad * step_slope_s_ + viscous_nm_s_rad;
    const Mask<Real> badly_posed = affine.slope_nm_s_rad < min_slope_nm_s_rad;
    if (any(badly_posed)) {  // Picard instead of Newton: slower convergence, never badly posed
      rate_share = select(badly_posed, every<Real>(1.0), rate_share);
      step_slope_s_ = select(badly_posed, Real{}, step_slope_s_);
      affine.slope_nm_s_rad = select(badly_posed, viscous_nm_s_rad, affine.slope_nm_s_rad);
    }
    step_constant_rad_ = gain_s * (rate_share * rate_rad_s - relaxation * deflection_rad_);
    affine.constant_nm = stiffness_nm_rad_ * deflection_rad_ + torque_per_step_nm_rad * step_constant_rad_;
    return affine;
  }

  // Moves the point of linearisation to a better estimate before another linearise() of the same step.
  void refine(Real rate_rad_s, Real theta, Mask<Real> where) {
    middle_rad_ = select(where, deflection_rad_ + theta * step_rad(rate_rad_s), middle_rad_);
  }

  // Completes the step with the solved rate at its theta point.
  void commit(Real rate_rad_s, Mask<Real> moves) {
    const Real step = step_rad(rate_rad_s);
    const Real deflection_rad = deflection_rad_ + step;
    deflection_rad_ = select(moves, deflection_rad, deflection_rad_);
    middle_rad_ =
        select(moves, deflection_rad + 0.5 * step, middle_rad_);  // prediction for the middle of the next step
  }

  Real deflection_rad() const { return deflection_rad_; }

 private:
  // Returns the change of z over the step for a rate at its theta point, from the linearised eq. (2).
  Real step_rad(Real rate_rad_s) const { return step_constant_rad_ + step_slope_s_ * rate_rad_s; }

  // Puts the curve of the direction in which each lane moves into `ahead_`.
  void turn_to(Mask<Real> forward) {
    const Mask<Real> turned = forward != forward_;
    if (any(turned)) {
      Stribeck<Real>::exchange_lanes(turned, ahead_, other_);
      forward_ = forward;
    }
  }

  Stribeck<Real> ahead_;
  Stribeck<Real> other_;
  Mask<Real> forward_ = all_lanes<Real>();
  Real stiffness_nm_rad_{};
  Real damping_per_step_nm_rad_{};  // sigma1 / dt
  Real stiffness_dt_nm_s_rad_{};    // sigma0 dt
  double dt_s_ = 0;

  Real deflection_rad_{};  // z
  Real middle_rad_{};      // estimate of z in the middle of the step

  // The current step's linearisation.
  Real step_constant_rad_{};
  Real step_slope_s_{};
};

}  // namespace trackservo::sim

#endif
