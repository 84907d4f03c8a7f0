// LuGre seal friction for the plant, eqs (1)-(3), solved together with the joint rate.
//
//   Tf = s0 z + s1 dz/dt + s2 v,   dz/dt = v - N(v, z),   N = s0 |v| z / g(v)
//
// The firmware holds the speed over its tick and uses the exponential solution. This is another method on purpose: a
// linearly implicit (Rosenbrock-type) theta step of the pair (v, z). N is linearised at a predicted mid speed v*,
// z is eliminated, and what remains is a friction torque affine in the unknown mid speed, a + b v, that Joint solves;
// commit() then advances z. theta is 1/2 (second order) and rises towards 1 where s0 |v| dt / g > 2, which keeps z
// monotone for any parameters. The paper's s1 is used as it is, also at high speed.
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
  double theta = 0.5;  // where in the step the rate and the torque are taken, 1/2..1
};

class LugreFriction {
 public:
  explicit LugreFriction(const FrictionConfig& config) : config_(config) {}

  // Linearises the step of dt_s [s] around the predicted rate [rad/s]. `level` scales Tc and Ts. `least_slope` bounds
  // the (possibly negative) slope from below so that the joint's equation stays well posed.
  AffineFriction linearise(double rate_rad_s, double level, double dt_s, double least_slope_nm_s_rad) {
    const StribeckConfig& direction = rate_rad_s >= 0.0 ? config_.positive : config_.negative;
    const StribeckPoint point = stribeck(direction, level, rate_rad_s);
    const double inverse_deflection = config_.stiffness_nm_rad / point.level_nm;
    relaxation_1_s_ = inverse_deflection * std::abs(rate_rad_s);
    const double decay = relaxation_1_s_ * dt_s;
    const double theta = decay > 2.0 ? 1.0 - 1.0 / decay : 0.5;
    rate_share_ = std::copysign(inverse_deflection, rate_rad_s) * middle_rad_ * (1.0 - point.relative_slope_v);
    predicted_rate_rad_s_ = rate_rad_s;
    gain_s_ = dt_s / (1.0 + theta * decay);
    viscous_nm_s_rad_ = direction.viscous_nm_s_rad;
    torque_per_step_ = theta * config_.stiffness_nm_rad + config_.damping_nm_s_rad / dt_s;
    const double memory = torque_per_step_ * gain_s_;
    if (memory * (1.0 - rate_share_) + viscous_nm_s_rad_ < least_slope_nm_s_rad) {
      rate_share_ = 1.0;  // Picard instead of Newton: slower to converge, never badly posed
    }
    return {config_.stiffness_nm_rad * deflection_rad_ + memory * offset(), memory * (1.0 - rate_share_) + viscous_nm_s_rad_,
            theta};
  }

  // Moves the point of linearisation to a better estimate before another linearise() of the same step.
  void refine(double rate_rad_s, double theta) { middle_rad_ = deflection_rad_ + theta * step_rad(rate_rad_s); }

  // Completes the step with the solved rate at its theta point; returns the mean friction torque [Nm].
  double commit(double rate_rad_s) {
    const double step = step_rad(rate_rad_s);
    const double torque =
        config_.stiffness_nm_rad * deflection_rad_ + torque_per_step_ * step + viscous_nm_s_rad_ * rate_rad_s;
    deflection_rad_ += step;
    middle_rad_ = deflection_rad_ + 0.5 * step;  // prediction of the next step's middle
    return torque;
  }

  double deflection_rad() const { return deflection_rad_; }

 private:
  // Change of z over the step for a rate at its theta point, from the linearised eq. (2).
  double step_rad(double rate_rad_s) const { return gain_s_ * ((1.0 - rate_share_) * rate_rad_s + offset()); }
  double offset() const { return rate_share_ * predicted_rate_rad_s_ - relaxation_1_s_ * deflection_rad_; }

  FrictionConfig config_;
  double deflection_rad_ = 0;  // z
  double middle_rad_ = 0;      // estimate of z in the middle of the step

  // The current step's linearisation: dz = gain ((1 - share) v + share v* - relaxation z).
  double relaxation_1_s_ = 0;
  double rate_share_ = 0;  // dN/dv
  double predicted_rate_rad_s_ = 0;
  double gain_s_ = 0;
  double torque_per_step_ = 0;
  double viscous_nm_s_rad_ = 0;
};

}  // namespace trackservo::sim

#endif
