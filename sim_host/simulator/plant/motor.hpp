// Brushed (or sinusoidally commutated) DC torque motor with its bridge.
//
//   L di/dt = u - R i - Ke w,   torque = Kt i (1 + sum f_h cos(h angle + phase)) + sum c_h sin(h angle + phase)
//
// Voltage and speed are held over a PWM period, so the current has the exact solution i = i_inf + (i0 - i_inf) e^(-R
// t/L) and the torque uses its exact mean. Ripple also shapes the back-EMF, so power is conserved; cogging does not
// depend on the current. Dead time subtracts 2 t_d/T of the supply against the current, fading out where ripple covers
// it.
//
// Use: renew_shape() once per tick, step() once per PWM period.
#ifndef TRACKSERVO_SIM_PLANT_MOTOR_HPP
#define TRACKSERVO_SIM_PLANT_MOTOR_HPP

#include "config/plant_config.hpp"

namespace trackservo::sim {

class DcMotor {
 public:
  // dt_s: the PWM period [s], the only step length that step() accepts.
  DcMotor(const MotorConfig& config, double dt_s);

  // Evaluates ripple and cogging and their slopes at a joint angle [rad]; until the next call they are linear in the
  // angle.
  void renew_shape(double joint_angle_rad);

  // One PWM period: mean bridge voltage [V], joint rate [rad/s] and joint angle [rad] at its middle, supply [V] for the
  // dead time. Returns the mean torque [Nm].
  double step(double voltage_v, double joint_rate_rad_s, double joint_angle_rad, double supply_v);

  // The bridge opens the terminals: its diodes conduct the remaining current against the supply until it is zero. A
  // back-EMF above the supply, which would let current flow again, is not modelled.
  void open_terminals(bool open) { open_ = open; }
  bool is_open() const { return open_; }

  // Share of torque and back-EMF that the magnets still give.
  void weaken(double share) { share_ = share; }

  double current_a() const { return current_a_; }  // at the end of the last period

 private:
  double step_open(double back_emf_v, double supply_v);

  MotorConfig config_;
  double conductance_s_;  // 1 / R
  double decay_;          // e^(-R dt/L)
  double mean_share_;     // mean of e^(-R t/L) over the period
  double dead_share_;     // 2 t_d / T
  double dead_knee_a_per_v_;
  double current_a_ = 0;
  bool open_ = false;
  double share_ = 1;

  double shape_angle_rad_ = 0;
  double ripple_ = 1;
  double ripple_slope_1_rad_ = 0;
  double cogging_nm_ = 0;
  double cogging_slope_nm_rad_ = 0;
};

}  // namespace trackservo::sim

#endif
