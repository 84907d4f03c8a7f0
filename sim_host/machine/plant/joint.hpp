// SPDX-License-Identifier: Apache-2.0
// The mechanics of an axis, or of both side by side (lanes.hpp): joint rate, friction memory and end stop advanced
// together over one PWM period.
//
//   J (v1 - v0)/dt + c v = drive - Tf(v, z) - stop(angle, v),   v at the theta point of the step
//
// v is the joint rate, at the seal and the stop; the caller has added base motion and coupling to `drive` and `c`.
// Friction enters as an affine function of v (lugre_friction.hpp, maxwell_slip.hpp). The end stop is an implicit
// spring-damper whose damping gives the required restitution. So the step is one division and is stable for every valid
// parameter set. Second order in dt.
#ifndef TRACKSERVO_SIM_PLANT_JOINT_HPP
#define TRACKSERVO_SIM_PLANT_JOINT_HPP

#include <array>
#include <cmath>
#include <limits>
#include <utility>

#include "machine/config/plant_config.hpp"
#include "machine/plant/lanes.hpp"
#include "machine/plant/lugre_friction.hpp"
#include "machine/plant/maxwell_slip.hpp"

namespace trackservo::sim {

// What an axis' joint has besides its friction.
class JointShape {
 public:
  explicit JointShape(const AxisConfig& axis);

  // Returns the seal's eccentricity at an angle: factor on the friction level, > 0. For the tick only: it takes two
  // cosines.
  double eccentricity_factor(double angle_rad) const;

  // Returns an end of the travel; without a stop: unlimited.
  double lower_rad() const { return lower_rad_; }
  double upper_rad() const { return upper_rad_; }

  // End-stop torque: constant + (stiffness * theta * dt + damping) * rate; only beyond the stops.
  struct Contact {
    double constant_nm;
    double stiffness_nm_rad;
    double damping_nm_s_rad;
  };
  Contact contact(double angle_rad, double inertia_kg_m2) const;

 private:
  FrictionConfig friction_;
  double lower_rad_ = -std::numeric_limits<double>::infinity();
  double upper_rad_ = std::numeric_limits<double>::infinity();
  double stiffness_nm_rad_ = 0;
  double damping_ratio_ = 0;
};

// Returns the error above which a prediction of an axis' rate is refined.
double refine_rate_rad_s(FrictionModel model, const FrictionConfig& friction);

template <class Real>
class JointLanes {
 public:
  static constexpr std::size_t kCount = kLanes<Real>;

  // Prepares the joints. dt_s: the step length [s], the only one that step() accepts.
  JointLanes(const std::array<AxisConfig, kCount>& axes, FrictionModel model, const MaxwellSlipConfig& maxwell_slip,
             double dt_s);
  JointLanes(const AxisConfig& axis, FrictionModel model, const MaxwellSlipConfig& maxwell_slip, double dt_s)
      : JointLanes(std::array<AxisConfig, 1>{axis}, model, maxwell_slip, dt_s) {}

  // Puts a joint at rest at an angle [rad], bristles relaxed.
  void place(double angle_rad, std::size_t i = 0);

  // Sets the friction factors of a joint for the coming tick; both > 0. `level` multiplies Tc and Ts, `viscosity`
  // sigma2 (Maxwell-slip only).
  void set_friction_factors(double level, double viscosity, std::size_t i = 0) {
    set_lane(level_, i, level);
    viscosity_[i] = viscosity;
  }

  // Returns the seal's eccentricity at the present angle: factor on the friction level, > 0. For the tick only: it
  // takes two cosines.
  double eccentricity_factor(std::size_t i = 0) const {
    return shape_[i].eccentricity_factor(lane(motion_.angle_rad, i));
  }

  // Blocks the joint by an immovable object, or frees it again.
  void hold(bool held, std::size_t i = 0) {
    held_[i] = held;
    note_rest();
  }

  // Sets the torque of a closed brake [Nm], 0 for an open one; it stays until set again.
  void brake(double torque_nm, std::size_t i = 0) {
    brake_nm_[i] = torque_nm;
    note_rest();
  }

  // Advances by one step with inertia J [kg m2] under `drive_nm`, with an extra linear drag [Nm s/rad] from coupling.
  void step(Real inertia_kg_m2, Real drive_nm, Real drag_nm_s_rad);

  Real angle_rad() const { return motion_.angle_rad; }
  Real rate_rad_s() const { return motion_.rate_rad_s; }
  Real predicted_rate_rad_s() const { return motion_.predicted_rate_rad_s; }
  Real mean_rate_rad_s() const { return motion_.mean_rate_rad_s; }
  Real friction_torque_nm() const { return motion_.friction_torque_nm; }
  Real stop_torque_nm() const { return motion_.stop_torque_nm; }

 private:
  static constexpr int kMaxRefinements = 4;

  struct Motion {
    Real angle_rad{};
    Real rate_rad_s{};
    Real predicted_rate_rad_s{};  // half a step ahead
    Real mean_rate_rad_s{};       // at the last step's theta point
    Real friction_torque_nm{};    // mean of the last step
    Real stop_torque_nm{};        // mean of the last step, against the motion
  };

  struct Contact {
    Real constant_nm{};
    Real stiffness_nm_rad{};
    Real damping_nm_s_rad{};
  };

  void note_rest() {
    may_rest_ = false;
    for (std::size_t i = 0; i < kCount; ++i) {
      may_rest_ = may_rest_ || held_[i] || brake_nm_[i] > 0.0;
    }
  }
  Contact contact(Real inertia_kg_m2) const;
  Mask<Real> brake_joints(Real inertia_per_step, Real& push_nm) const;
  AffineFriction<Real> linearise(Real rate_rad_s, Real min_slope_nm_s_rad, Mask<Real> moves);
  void commit(Real rate_rad_s, Mask<Real> moves);
  void keep_at_rest(Mask<Real> moves, Motion& next) const;

  FrictionModel model_;
  LugreFriction<Real> lugre_;
  std::array<JointShape, kCount> shape_;
  std::array<MaxwellSlip, kCount> maxwell_slip_;
  double dt_s_;
  double rate_1_s_;  // 1 / dt
  Real lower_rad_{};
  Real upper_rad_{};
  Real refine_rate_rad_s_{};
  Real level_ = every<Real>(1.0);
  std::array<double, kCount> viscosity_{};
  std::array<bool, kCount> held_{};
  std::array<double, kCount> brake_nm_{};
  bool may_rest_ = false;  // one of them at least

  Motion motion_;
};

using Joint = JointLanes<double>;
using JointPair = JointLanes<Pair>;

namespace detail {

template <class Make, std::size_t... kLane>
auto array_of(const Make& make, std::index_sequence<kLane...>) {
  return std::array{make(kLane)...};
}

}  // namespace detail

template <class Real>
JointLanes<Real>::JointLanes(const std::array<AxisConfig, kCount>& axes, FrictionModel model,
                             const MaxwellSlipConfig& maxwell_slip, double dt_s)
    : model_(model),
      shape_(detail::array_of([&](std::size_t i) { return JointShape(axes[i]); }, std::make_index_sequence<kCount>{})),
      maxwell_slip_(detail::array_of([&](std::size_t i) { return MaxwellSlip(axes[i].friction, maxwell_slip, dt_s); },
                                     std::make_index_sequence<kCount>{})),
      dt_s_(dt_s),
      rate_1_s_(1.0 / dt_s) {
  viscosity_.fill(1.0);
  for (std::size_t i = 0; i < kCount; ++i) {
    lugre_.set(i, axes[i].friction, dt_s);
    set_lane(lower_rad_, i, shape_[i].lower_rad());
    set_lane(upper_rad_, i, shape_[i].upper_rad());
    set_lane(refine_rate_rad_s_, i, sim::refine_rate_rad_s(model, axes[i].friction));
  }
}

template <class Real>
void JointLanes<Real>::place(double angle_rad, std::size_t i) {
  set_lane(motion_.angle_rad, i, angle_rad);
  set_lane(motion_.rate_rad_s, i, 0.0);
  set_lane(motion_.predicted_rate_rad_s, i, 0.0);
  lugre_.relax(i);
  maxwell_slip_[i].relax();
}

template <class Real>
typename JointLanes<Real>::Contact JointLanes<Real>::contact(Real inertia_kg_m2) const {
  Contact result;
  const Mask<Real> touching = opposite(both(motion_.angle_rad >= lower_rad_, motion_.angle_rad <= upper_rad_));
  if (any(touching)) {
    for (std::size_t i = 0; i < kCount; ++i) {
      if (is_set(touching, i)) {
        const JointShape::Contact one = shape_[i].contact(lane(motion_.angle_rad, i), lane(inertia_kg_m2, i));
        set_lane(result.constant_nm, i, one.constant_nm);
        set_lane(result.stiffness_nm_rad, i, one.stiffness_nm_rad);
        set_lane(result.damping_nm_s_rad, i, one.damping_nm_s_rad);
      }
    }
  }
  return result;
}

// Returns the joints that move in this step. What a brake takes from them is taken from `push_nm`.
template <class Real>
Mask<Real> JointLanes<Real>::brake_joints(Real inertia_per_step, Real& push_nm) const {
  Real moves = every<Real>(1.0);
  for (std::size_t i = 0; i < kCount; ++i) {
    const double stopping_nm = lane(inertia_per_step, i) * lane(motion_.rate_rad_s, i) + lane(push_nm, i);
    if (held_[i] || (brake_nm_[i] > 0.0 && std::abs(stopping_nm) <= brake_nm_[i])) {
      set_lane(moves, i, 0.0);
    } else if (brake_nm_[i] > 0.0) {
      set_lane(push_nm, i, lane(push_nm, i) - std::copysign(brake_nm_[i], stopping_nm));
    }
  }
  return moves > Real{};
}

template <class Real>
AffineFriction<Real> JointLanes<Real>::linearise(Real rate_rad_s, Real min_slope_nm_s_rad, Mask<Real> moves) {
  if (model_ == FrictionModel::kLugre) {
    return lugre_.linearise(rate_rad_s, level_, min_slope_nm_s_rad, moves);
  }
  AffineFriction<Real> result;
  for (std::size_t i = 0; i < kCount; ++i) {
    if (model_ == FrictionModel::kMaxwellSlip && is_set(moves, i)) {
      const AffineFriction<double> one =
          maxwell_slip_[i].linearise(lane(rate_rad_s, i), lane(level_, i), viscosity_[i]);
      set_lane(result.constant_nm, i, one.constant_nm);
      set_lane(result.slope_nm_s_rad, i, one.slope_nm_s_rad);
    }
  }
  return result;
}

template <class Real>
void JointLanes<Real>::commit(Real rate_rad_s, Mask<Real> moves) {
  if (model_ == FrictionModel::kLugre) {
    lugre_.commit(rate_rad_s, moves);
  } else if (model_ == FrictionModel::kMaxwellSlip) {
    for (std::size_t i = 0; i < kCount; ++i) {
      if (is_set(moves, i)) {
        maxwell_slip_[i].commit(lane(rate_rad_s, i));
      }
    }
  }
}

template <class Real>
void JointLanes<Real>::keep_at_rest(Mask<Real> moves, Motion& next) const {
  next.angle_rad = select(moves, next.angle_rad, motion_.angle_rad);
  for (Real Motion::*rate : {&Motion::rate_rad_s, &Motion::predicted_rate_rad_s, &Motion::mean_rate_rad_s}) {
    next.*rate = select(moves, next.*rate, Real{});
  }
  next.friction_torque_nm = select(moves, next.friction_torque_nm, motion_.friction_torque_nm);
  next.stop_torque_nm = select(moves, next.stop_torque_nm, motion_.stop_torque_nm);
}

template <class Real>
void JointLanes<Real>::step(Real inertia_kg_m2, Real drive_nm, Real drag_nm_s_rad) {
  const Contact stop = contact(inertia_kg_m2);
  const Real inertia_per_step = inertia_kg_m2 * rate_1_s_;
  const Real min_slope = -0.5 * inertia_per_step;  // leaves half of J / dt in the denominator below
  Real push_nm = drive_nm - stop.constant_nm;
  const Mask<Real> moves = may_rest_ ? brake_joints(inertia_per_step, push_nm) : all_lanes<Real>();
  Real point = motion_.predicted_rate_rad_s;  // of the linearisation
  Real rate = point;
  AffineFriction<Real> friction;
  Real stop_slope{};
  for (int refinement = 0;; ++refinement) {
    friction = linearise(point, min_slope, moves);
    const Real inertia = inertia_per_step * friction.inverse_theta;
    stop_slope = stop.damping_nm_s_rad + friction.theta * dt_s_ * stop.stiffness_nm_rad;
    const Real solved = (inertia * motion_.rate_rad_s + push_nm - friction.constant_nm) /
                        (inertia + friction.slope_nm_s_rad + drag_nm_s_rad + stop_slope);
    const Mask<Real> missed = both(moves, magnitude(solved - rate) > refine_rate_rad_s_);
    rate = solved;
    if (!any(missed) || refinement == kMaxRefinements) {
      break;
    }
    lugre_.refine(rate, friction.theta, missed);
    point = select(missed, rate, point);  // the other lanes are solved again as they were
  }

  commit(rate, moves);
  Motion next;
  const Real change = (rate - motion_.rate_rad_s) * friction.inverse_theta;
  next.angle_rad = motion_.angle_rad + dt_s_ * (motion_.rate_rad_s + 0.5 * change);
  next.rate_rad_s = motion_.rate_rad_s + change;
  next.predicted_rate_rad_s = next.rate_rad_s + 0.5 * change;  // the rate continues as in this step
  next.mean_rate_rad_s = rate;
  next.friction_torque_nm = friction.constant_nm + friction.slope_nm_s_rad * rate;
  next.stop_torque_nm = stop.constant_nm + stop_slope * rate;
  if (may_rest_) {
    keep_at_rest(moves, next);
  }
  motion_ = next;
}

}  // namespace trackservo::sim

#endif
