#include "plant/joint.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace trackservo::sim {

namespace {

constexpr double kRefineShare = 0.02;  // of the Stribeck speed: keeps g(v) within about 1e-3 of its true value
constexpr int kMaxRefinements = 4;
constexpr double kMinLevel = 0.05;  // eccentricity never removes the friction completely

// Damping ratio of a linear spring-damper that returns the fraction e of the impact speed.
double damping_ratio_of(double restitution) {
  const double logarithm = std::log(restitution);
  return -logarithm / std::sqrt(kPi * kPi + logarithm * logarithm);
}

// Only LuGre's linearisation depends on the predicted rate so strongly that it is ever refined.
double refine_rate_rad_s(FrictionModel model, const FrictionConfig& friction) {
  if (model != FrictionModel::kLugre) {
    return std::numeric_limits<double>::infinity();
  }
  return kRefineShare * std::min(friction.positive.stribeck_speed_rad_s, friction.negative.stribeck_speed_rad_s);
}

}  // namespace

Joint::Joint(const AxisConfig& axis, FrictionModel model, const MaxwellSlipConfig& maxwell_slip, double dt_s)
    : model_(model),
      lugre_(axis.friction, dt_s),
      maxwell_slip_(axis.friction, maxwell_slip, dt_s),
      friction_(axis.friction),
      stop_(axis.end_stops),
      stop_damping_ratio_(axis.end_stops ? damping_ratio_of(axis.end_stops->restitution) : 0.0),
      dt_s_(dt_s),
      rate_1_s_(1.0 / dt_s),
      refine_rate_rad_s_(refine_rate_rad_s(model, axis.friction)) {}

void Joint::place(double angle_rad) {
  angle_rad_ = angle_rad;
  rate_rad_s_ = 0.0;
  predicted_rate_rad_s_ = 0.0;
  lugre_.relax();
  maxwell_slip_.relax();
}

void Joint::set_friction_factors(double level, double viscosity) {
  level_ = level;
  viscosity_ = viscosity;
}

double Joint::eccentricity_factor() const {
  double factor = 1.0;
  if (friction_.eccentricity_once != 0.0) {
    factor += friction_.eccentricity_once * std::cos(angle_rad_ - friction_.eccentricity_once_phase_rad);
  }
  if (friction_.eccentricity_twice != 0.0) {
    factor += friction_.eccentricity_twice * std::cos(2.0 * (angle_rad_ - friction_.eccentricity_twice_phase_rad));
  }
  return std::max(factor, kMinLevel);
}

inline Joint::Contact Joint::contact(double inertia_kg_m2) const {
  if (angle_rad_ >= stop_->lower_rad && angle_rad_ <= stop_->upper_rad) {
    return {};
  }
  const double limit_rad = angle_rad_ > stop_->upper_rad ? stop_->upper_rad : stop_->lower_rad;
  return {stop_->stiffness_nm_rad * (angle_rad_ - limit_rad), stop_->stiffness_nm_rad,
          2.0 * stop_damping_ratio_ * std::sqrt(stop_->stiffness_nm_rad * inertia_kg_m2)};
}

inline AffineFriction Joint::linearise(double rate_rad_s, double min_slope_nm_s_rad) {
  switch (model_) {
    case FrictionModel::kLugre:
      return lugre_.linearise(rate_rad_s, level_, min_slope_nm_s_rad);
    case FrictionModel::kMaxwellSlip:
      return maxwell_slip_.linearise(rate_rad_s, level_, viscosity_);
    case FrictionModel::kNone:
      break;
  }
  return {};
}

void Joint::step(double inertia_kg_m2, double drive_nm, double drag_nm_s_rad) {
  if (held_) {
    rest();
    return;
  }
  const Contact stop = stop_ ? contact(inertia_kg_m2) : Contact{};
  const double inertia_per_step = inertia_kg_m2 * rate_1_s_;
  const double min_slope = -0.5 * inertia_per_step;  // leaves half of J / dt in the denominator below
  double push_nm = drive_nm - stop.constant_nm;
  if (brake_nm_ > 0.0) {
    const double stopping_nm = inertia_per_step * rate_rad_s_ + push_nm;  // after which the joint is at rest
    if (std::abs(stopping_nm) <= brake_nm_) {
      rest();
      return;
    }
    push_nm -= std::copysign(brake_nm_, stopping_nm);
  }
  double rate = predicted_rate_rad_s_;
  AffineFriction friction;
  double stop_slope = 0.0;
  for (int refinement = 0;; ++refinement) {
    friction = linearise(rate, min_slope);
    const double inertia = inertia_per_step * friction.inverse_theta;
    stop_slope = stop.damping_nm_s_rad + friction.theta * dt_s_ * stop.stiffness_nm_rad;
    const double solved = (inertia * rate_rad_s_ + push_nm - friction.constant_nm) /
                          (inertia + friction.slope_nm_s_rad + drag_nm_s_rad + stop_slope);
    const double miss = std::abs(solved - rate);
    rate = solved;
    if (!(miss > refine_rate_rad_s_) || refinement == kMaxRefinements) {
      break;
    }
    lugre_.refine(rate, friction.theta);
  }

  if (model_ == FrictionModel::kLugre) {
    lugre_.commit(rate);
  } else if (model_ == FrictionModel::kMaxwellSlip) {
    maxwell_slip_.commit(rate);
  }
  friction_torque_nm_ = friction.constant_nm + friction.slope_nm_s_rad * rate;
  stop_torque_nm_ = stop.constant_nm + stop_slope * rate;
  const double change = (rate - rate_rad_s_) * friction.inverse_theta;
  angle_rad_ += dt_s_ * (rate_rad_s_ + 0.5 * change);
  rate_rad_s_ += change;
  predicted_rate_rad_s_ = rate_rad_s_ + 0.5 * change;  // the rate continues as in this step
  mean_rate_rad_s_ = rate;
}

}  // namespace trackservo::sim
