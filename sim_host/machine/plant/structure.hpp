// SPDX-License-Identifier: Apache-2.0
// A part of the axis' inertia behind a spring: the single resonance of a two-mass machine.
//
//   Jl dwl/dt = -k phi - d (wl - w) - Jl a_base,   dphi/dt = wl - w,   torque on the joint = k phi + d (wl - w)
//   k = f^2 s (1 - s) J,  d = 2 damping f s (1 - s) J,  Jl = s J,  f in rad/s
//
// w, wl: joint rate before and rate behind the spring, both against the base; s: share of the inertia J behind it. The
// motor, the seal, loads, encoder and gyro are all on the joint's side. Solved by the implicit midpoint rule together
// with the joint's own step (joint.hpp): the result is affine in the joint rate, so no iteration is needed; second
// order and stable for every frequency.
//
// Use in every step: reaction(), then the joint's step with it, then commit().
#ifndef TRACKSERVO_SIM_PLANT_STRUCTURE_HPP
#define TRACKSERVO_SIM_PLANT_STRUCTURE_HPP

#include "machine/config/plant_config.hpp"

namespace trackservo::sim {

class Structure {
 public:
  // Takes J, the inertia of the whole axis for which the frequency is valid [kg m2]; dt_s: the step length, the only
  // one.
  Structure(const StructureConfig& config, double inertia_kg_m2, double dt_s);

  double share() const { return share_; }

  // Torque on the joint over the coming step: push_nm - drag_nm_s_rad * joint rate in its middle.
  struct Reaction {
    double push_nm = 0;
    double drag_nm_s_rad = 0;
  };

  // Returns the reaction for the inertia of the whole axis now [kg m2] and the acceleration of the base [rad/s2].
  Reaction reaction(double inertia_kg_m2, double base_acceleration_rad_s2);

  // Completes the step with the joint rate in its middle [rad/s].
  void commit(double joint_rate_rad_s);

 private:
  double share_;
  double stiffness_nm_rad_;
  double step_drag_nm_s_rad_;  // k dt / 2 + d
  double dt_s_;

  double twist_rad_ = 0;   // phi
  double rate_rad_s_ = 0;  // wl

  // Mean rate behind the spring over this step: constant + slope * joint rate.
  double mean_constant_rad_s_ = 0;
  double mean_slope_ = 0;
};

}  // namespace trackservo::sim

#endif
