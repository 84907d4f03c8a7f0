// One axis' mechanics: joint rate, friction memory and end stop advanced together over one PWM period.
//
//   J (v1 - v0)/dt + c v = drive - Tf(v, z) - stop(angle, v),   v at the theta point of the step
//
// v is the joint rate, at the seal and the stop; the caller has added base motion and coupling to `drive` and `c`.
// Friction enters as an affine function of v (lugre_friction.hpp, maxwell_slip.hpp). The end stop is an implicit
// spring-damper whose damping gives the required restitution. So the step is one division and is stable for every valid
// parameter set. Second order in dt.
#ifndef TRACKSERVO_SIM_PLANT_JOINT_HPP
#define TRACKSERVO_SIM_PLANT_JOINT_HPP

#include <optional>

#include "config/plant_config.hpp"
#include "plant/lugre_friction.hpp"
#include "plant/maxwell_slip.hpp"

namespace trackservo::sim {

class Joint {
 public:
  // dt_s: the step length [s], the only one that step() accepts.
  Joint(const AxisConfig& axis, FrictionModel model, const MaxwellSlipConfig& maxwell_slip, double dt_s);

  // Puts the joint at rest at an angle [rad], bristles relaxed.
  void place(double angle_rad);

  // Sets the friction factors for the coming tick; both > 0. `level` multiplies Tc and Ts, `viscosity` sigma2
  // (Maxwell-slip only).
  void set_friction_factors(double level, double viscosity);

  // Seal eccentricity at the present angle: factor on the friction level, > 0. Takes two cosines: for the tick only.
  double eccentricity_factor() const;

  // An immovable object blocks the joint, or is gone again.
  void hold(bool held) { held_ = held; }

  // Torque of a closed brake [Nm], 0 for an open one; it stays until set again.
  void brake(double torque_nm) { brake_nm_ = torque_nm; }

  // Advances by one step with inertia J [kg m2] under `drive_nm`, with an extra linear drag [Nm s/rad] from coupling.
  void step(double inertia_kg_m2, double drive_nm, double drag_nm_s_rad);

  double angle_rad() const { return angle_rad_; }
  double rate_rad_s() const { return rate_rad_s_; }
  double predicted_rate_rad_s() const { return predicted_rate_rad_s_; }  // half a step ahead
  double friction_torque_nm() const { return friction_torque_nm_; }      // mean of the last step
  double stop_torque_nm() const { return stop_torque_nm_; }              // mean of the last step, against the motion
  double mean_rate_rad_s() const { return mean_rate_rad_s_; }            // at the last step's theta point

 private:
  // End-stop torque: constant + (stiffness * theta * dt + damping) * rate; all zero away from the stops.
  struct Contact {
    double constant_nm = 0;
    double stiffness_nm_rad = 0;
    double damping_nm_s_rad = 0;
  };

  Contact contact(double inertia_kg_m2) const;  // only with stops
  void rest() { rate_rad_s_ = predicted_rate_rad_s_ = mean_rate_rad_s_ = 0.0; }
  AffineFriction linearise(double rate_rad_s, double min_slope_nm_s_rad);

  FrictionModel model_;
  LugreFriction lugre_;
  MaxwellSlip maxwell_slip_;
  FrictionConfig friction_;
  std::optional<EndStopConfig> stop_;
  double stop_damping_ratio_ = 0;
  double dt_s_;
  double rate_1_s_;           // 1 / dt
  double refine_rate_rad_s_;  // a prediction with a larger error than this is refined
  double level_ = 1;
  double viscosity_ = 1;

  bool held_ = false;
  double brake_nm_ = 0;
  double angle_rad_ = 0;
  double rate_rad_s_ = 0;
  double predicted_rate_rad_s_ = 0;
  double mean_rate_rad_s_ = 0;
  double friction_torque_nm_ = 0;
  double stop_torque_nm_ = 0;
};

}  // namespace trackservo::sim

#endif
