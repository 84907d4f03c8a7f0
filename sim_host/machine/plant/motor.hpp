// SPDX-License-Identifier: Apache-2.0
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

#include <array>
#include <cmath>
#include <cstddef>

#include "machine/config/plant_config.hpp"
#include "machine/plant/lanes.hpp"

namespace trackservo::sim {

// Ripple and cogging at a joint angle, with their slopes.
struct MotorShape {
  double ripple;
  double ripple_slope_1_rad;
  double cogging_nm;
  double cogging_slope_nm_rad;
};
MotorShape motor_shape(const MotorConfig& config, double joint_angle_rad);

// A lane is one motor.
template <class Real>
class MotorLanes {
 public:
  static constexpr std::size_t kCount = kLanes<Real>;

  // Prepares the motors. dt_s: the PWM period [s], the only step length that step() accepts.
  MotorLanes(const std::array<MotorConfig, kCount>& configs, double dt_s);
  MotorLanes(const MotorConfig& config, double dt_s) : MotorLanes(std::array<MotorConfig, 1>{config}, dt_s) {}

  // Evaluates ripple and cogging and their slopes at a joint angle [rad]; until the next call they are linear in the
  // angle.
  void renew_shape(double joint_angle_rad, std::size_t i = 0);

  // Advances by one PWM period: mean bridge voltage [V], joint rate [rad/s] and joint angle [rad] at its middle, supply
  // [V] for the dead time. Returns the mean torque [Nm].
  Real step(Real voltage_v, Real joint_rate_rad_s, Real joint_angle_rad, double supply_v);

  // Opens the terminals of the bridge: its diodes conduct the remaining current against the supply until it is
  // zero. A back-EMF above the supply, which would let current flow again, is not modelled.
  void open_terminals(bool open, std::size_t i = 0) { open_[i] = open; }
  bool is_open(std::size_t i = 0) const { return open_[i]; }

  // Sets the share of torque and back-EMF that the magnets still give.
  void weaken(double share, std::size_t i = 0) { set_lane(share_, i, share); }

  Real current_a() const { return current_a_; }  // at the end of the last period

 private:
  bool is_any_open() const;
  Real lost_to_dead_time_v(double supply_v) const;
  double step_open(std::size_t i, double back_emf_v, double supply_v);

  std::array<MotorConfig, kCount> config_;
  Real torque_constant_nm_a_{};
  Real back_emf_constant_v_s_rad_{};
  Real conductance_s_{};  // 1 / R
  Real decay_{};          // e^(-R dt/L)
  Real mean_share_{};     // mean of e^(-R t/L) over the period
  Real dead_share_{};     // 2 t_d / T
  Real dead_knee_a_per_v_{};
  Real current_a_{};
  std::array<bool, kCount> open_{};
  Real share_ = every<Real>(1.0);

  Real shape_angle_rad_{};
  Real ripple_ = every<Real>(1.0);
  Real ripple_slope_1_rad_{};
  Real cogging_nm_{};
  Real cogging_slope_nm_rad_{};
};

using DcMotor = MotorLanes<double>;
using MotorPair = MotorLanes<Pair>;

template <class Real>
MotorLanes<Real>::MotorLanes(const std::array<MotorConfig, kCount>& configs, double dt_s) : config_(configs) {
  for (std::size_t i = 0; i < kCount; ++i) {
    const MotorConfig& config = configs[i];
    const double exponent = config.resistance_ohm * dt_s / config.inductance_h;
    set_lane(torque_constant_nm_a_, i, config.torque_constant_nm_a);
    set_lane(back_emf_constant_v_s_rad_, i, config.back_emf_constant_v_s_rad);
    set_lane(conductance_s_, i, 1.0 / config.resistance_ohm);
    set_lane(decay_, i, std::exp(-exponent));
    set_lane(mean_share_, i, -std::expm1(-exponent) / exponent);
    set_lane(dead_share_, i, 2.0 * config.dead_time_s / dt_s);
    // Half the peak-to-peak current ripple of unipolar modulation at half duty: below it the dead time has a partial
    // effect.
    set_lane(dead_knee_a_per_v_, i, dt_s / (8.0 * config.inductance_h));
  }
}

template <class Real>
void MotorLanes<Real>::renew_shape(double joint_angle_rad, std::size_t i) {
  const MotorShape shape = motor_shape(config_[i], joint_angle_rad);
  set_lane(shape_angle_rad_, i, joint_angle_rad);
  set_lane(ripple_, i, shape.ripple);
  set_lane(ripple_slope_1_rad_, i, shape.ripple_slope_1_rad);
  set_lane(cogging_nm_, i, shape.cogging_nm);
  set_lane(cogging_slope_nm_rad_, i, shape.cogging_slope_nm_rad);
}

template <class Real>
bool MotorLanes<Real>::is_any_open() const {
  bool result = false;
  for (const bool open : open_) {
    result = result || open;
  }
  return result;
}

template <class Real>
Real MotorLanes<Real>::lost_to_dead_time_v(double supply_v) const {
  const Real full = current_a_ / (dead_knee_a_per_v_ * supply_v);
  const Real one = every<Real>(1.0);
  return dead_share_ * supply_v * select(full < -one, -one, select(full > one, one, full));
}

// Returns the mean current of the period.
template <class Real>
double MotorLanes<Real>::step_open(std::size_t i, double back_emf_v, double supply_v) {
  const double before_a = lane(current_a_, i);
  if (before_a == 0.0) {
    return 0.0;
  }
  const double final_a = (std::copysign(supply_v, -before_a) - back_emf_v) * lane(conductance_s_, i);
  const double after_a = final_a + (before_a - final_a) * lane(decay_, i);
  const bool gone = after_a * before_a <= 0.0;
  const double end_a = gone ? 0.0 : after_a;
  set_lane(current_a_, i, end_a);
  // Nearly a straight line; it ends within the period in which the current reaches zero.
  const double share = gone ? before_a / (before_a - after_a) : 1.0;
  return 0.5 * (before_a + end_a) * share;
}

template <class Real>
Real MotorLanes<Real>::step(Real voltage_v, Real joint_rate_rad_s, Real joint_angle_rad, double supply_v) {
  const Real travel = joint_angle_rad - shape_angle_rad_;
  const Real shape = share_ * (ripple_ + ripple_slope_1_rad_ * travel);
  Real voltage = voltage_v;
  const Mask<Real> pauses = dead_share_ > Real{};
  if (any(pauses)) {
    voltage = select(pauses, voltage - lost_to_dead_time_v(supply_v), voltage);
  }
  const Real back_emf_v = back_emf_constant_v_s_rad_ * shape * joint_rate_rad_s;
  const Real final_a = (voltage - back_emf_v) * conductance_s_;
  const Real distance_a = current_a_ - final_a;
  Real mean_a = final_a + distance_a * mean_share_;
  Real end_a = final_a + distance_a * decay_;
  if (is_any_open()) {
    for (std::size_t i = 0; i < kCount; ++i) {
      if (open_[i]) {
        set_lane(mean_a, i, step_open(i, lane(back_emf_v, i), supply_v));
        set_lane(end_a, i, lane(current_a_, i));
      }
    }
  }
  current_a_ = end_a;
  return torque_constant_nm_a_ * shape * mean_a + cogging_nm_ + cogging_slope_nm_rad_ * travel;
}

}  // namespace trackservo::sim

#endif
