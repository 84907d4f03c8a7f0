// SPDX-License-Identifier: Apache-2.0
// A part of the axis' inertia behind a spring: the single resonance of a two-mass machine.
//
//   Jl dwl/dt = -k (phi -+ b/2) - d (wl - w) - Jl a_base - load,   dphi/dt = wl - w,
//   torque on the joint = k (phi -+ b/2) + d (wl - w);   both without spring and damper while |phi| < b/2
//   k = f^2 s (1 - s) J,  d = 2 damping f s (1 - s) J,  Jl = s J,  f in rad/s
//
// w, wl: joint rate before and rate behind the spring, both against the base; s: share of the inertia J behind it; b:
// backlash. Motor, seal, cable, imbalance and encoder are on the joint's side; the plant file says where optics and
// wind are. Solved by the implicit midpoint rule together with the joint's own step (joint.hpp): the result is affine
// in the joint rate, so no iteration is needed; second order and stable for every frequency.
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

  double share() const { return config_.inertia_share; }
  bool carries_optics() const { return config_.optics == StructureSide::kPayload; }
  bool is_in_the_wind() const { return config_.wind == StructureSide::kPayload; }

  // Return the motion behind the spring: its rate against the base, and its angle against the joint.
  double rate_rad_s() const { return rate_rad_s_; }
  double twist_rad() const { return twist_rad_; }

  // Torque on the joint over the coming step: push_nm - drag_nm_s_rad * joint rate in its middle.
  struct Reaction {
    double push_nm = 0;
    double drag_nm_s_rad = 0;
  };

  // Returns the reaction for the inertia of the whole axis now [kg m2], the acceleration of the base [rad/s2], and a
  // load behind the spring [Nm, positive against forward motion].
  Reaction reaction(double inertia_kg_m2, double base_acceleration_rad_s2, double load_nm = 0.0);

  // Completes the step with the joint rate in its middle [rad/s].
  void commit(double joint_rate_rad_s);

 private:
  double stretch_rad() const;

  StructureConfig config_;
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
