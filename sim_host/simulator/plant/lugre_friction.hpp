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

#include "config/plant_config.hpp"
#include "plant/stribeck.hpp"

namespace trackservo::sim {

// Friction torque over one step as a function of the joint rate at its theta point: constant_nm + slope * rate.
struct AffineFriction {
  double constant_nm = 0;
  double slope_nm_s_rad = 0;
  double theta = 0.5;  // point of the step at which rate and torque are taken, 1/2..1
  double inverse_theta = 2;
};

class LugreFriction {
 public:
  // dt_s: the step length [s], the only one that it accepts.
  LugreFriction(const FrictionConfig& config, double dt_s)
      : positive_(config.positive),
        negative_(config.negative),
        stiffness_nm_rad_(config.stiffness_nm_rad),
        damping_per_step_nm_rad_(config.damping_nm_s_rad / dt_s),
        stiffness_dt_nm_s_rad_(config.stiffness_nm_rad * dt_s),
        dt_s_(dt_s) {}

  void relax() { deflection_rad_ = middle_rad_ = 0.0; }

  // Linearises the step around the predicted rate at its middle [rad/s]. `level` scales Tc and Ts. `min_slope` is a
  // lower bound of the (possibly negative) slope, so that the joint's equation stays well posed.
  AffineFriction linearise(double rate_rad_s, double level, double min_slope_nm_s_rad) {
    Stribeck& direction = rate_rad_s >= 0.0 ? positive_ : negative_;
    const StribeckPoint point = direction.at(rate_rad_s, level);
    const double per_travel = stiffness_nm_rad_ * point.inverse_1_nm;
    const double speed_rad_s = std::abs(rate_rad_s);
    const double relaxation = per_travel * speed_rad_s;              // [1/s]
    const double stretch_nm = stiffness_dt_nm_s_rad_ * speed_rad_s;  // by g(v): the decay over the step
    AffineFriction affine;
    if (stretch_nm > 2.0 * point.level_nm) {
      affine.theta = 1.0 - point.level_nm / stretch_nm;
      affine.inverse_theta = 1.0 / affine.theta;
    }
    double rate_share = std::copysign(per_travel, rate_rad_s) * middle_rad_ * (1.0 - point.relative_slope_v);  // dN/dv
    const double gain_s = dt_s_ * point.level_nm / (point.level_nm + affine.theta * stretch_nm);
    const double torque_per_step_nm_rad = affine.theta * stiffness_nm_rad_ + damping_per_step_nm_rad_;
    const double viscous_nm_s_rad = direction.viscous_nm_s_rad();
    step_slope_s_ = gain_s * (1.0 - rate_share);
    affine.slope_nm_s_rad = torque_per_step_nm_rad * step_slope_s_ + viscous_nm_s_rad;
    if (affine.slope_nm_s_rad < min_slope_nm_s_rad) {
      rate_share = 1.0;  // Picard instead of Newton: slower convergence, never badly posed
      step_slope_s_ = 0.0;
      affine.slope_nm_s_rad = viscous_nm_s_rad;
    }
    step_constant_rad_ = gain_s * (rate_share * rate_rad_s - relaxation * deflection_rad_);
    affine.constant_nm = stiffness_nm_rad_ * deflection_rad_ + torque_per_step_nm_rad * step_constant_rad_;
    return affine;
  }

  // Moves the point of linearisation to a better estimate before another linearise() of the same step.
  void refine(double rate_rad_s, double theta) { middle_rad_ = deflection_rad_ + theta * step_rad(rate_rad_s); }

  // Completes the step with the solved rate at its theta point.
  void commit(double rate_rad_s) {
    const double step = step_rad(rate_rad_s);
    deflection_rad_ += step;
    middle_rad_ = deflection_rad_ + 0.5 * step;  // prediction for the middle of the next step
  }

  double deflection_rad() const { return deflection_rad_; }

 private:
  // Change of z over the step for a rate at its theta point, from the linearised eq. (2).
  double step_rad(double rate_rad_s) const { return step_constant_rad_ + step_slope_s_ * rate_rad_s; }

  Stribeck positive_;
  Stribeck negative_;
  double stiffness_nm_rad_;
  double damping_per_step_nm_rad_;  // sigma1 / dt
  double stiffness_dt_nm_s_rad_;    // sigma0 dt
  double dt_s_;

  double deflection_rad_ = 0;  // z
  double middle_rad_ = 0;      // estimate of z in the middle of the step

  // The current step's linearisation.
  double step_constant_rad_ = 0;
  double step_slope_s_ = 0;
};

}  // namespace trackservo::sim

#endif
