#include "plant/joint.hpp"

#include <algorithm>
#include <cmath>

namespace trackservo::sim {

namespace {

constexpr double kRefineShare = 0.02;  // of the Stribeck speed: keeps g(v) within about 1e-3 of its true value
constexpr int kMostRefinements = 4;
constexpr double kLeastLevel = 0.05;  // eccentricity never takes the friction away altogether

// Damping ratio of a linear spring-damper that returns the fraction e of the impact speed.
double damping_ratio_of(double restitution) {
  const double logarithm = std::log(restitution);
  return -logarithm / std::sqrt(kPi * kPi + logarithm * logarithm);
}

}  // namespace

Joint::Joint(const AxisConfig& axis, FrictionModel model, const MaxwellSlipConfig& maxwell_slip)
    : model_(model),
      lugre_(axis.friction),
      maxwell_slip_(axis.friction, maxwell_slip),
      friction_(axis.friction),
      refine_rate_rad_s_(kRefineShare *
                         std::min(axis.friction.positive.stribeck_speed_rad_s, axis.friction.negative.stribeck_speed_rad_s)) {
  if (axis.end_stops) {
    stop_ = Stop{*axis.end_stops, damping_ratio_of(axis.end_stops->restitution)};
  }
}

void Joint::place(double angle_rad) {
  angle_rad_ = angle_rad;
  rate_rad_s_ = 0;
  rate_change_rad_s_ = 0;
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
  return std::max(factor, kLeastLevel);
}

AffineFriction Joint::linearise(double rate_rad_s, double dt_s, double least_slope_nm_s_rad) {
  switch (model_) {
    case FrictionModel::kLugre:
      return lugre_.linearise(rate_rad_s, level_, dt_s, least_slope_nm_s_rad);
    case FrictionModel::kMaxwellSlip:
      return maxwell_slip_.linearise(rate_rad_s, level_, viscosity_, dt_s);
    case FrictionModel::kNone:
      break;
  }
  return {};
}

void Joint::step(double inertia_kg_m2, double drive_nm, double drag_nm_s_rad, double dt_s) {
  double stop_constant_nm = 0.0;
  double stop_stiffness_nm_rad = 0.0;
  double stop_slope_nm_s_rad = 0.0;
  if (stop_) {
    const EndStopConfig& stop = stop_->config;
    const double beyond = angle_rad_ > stop.upper_rad   ? angle_rad_ - stop.upper_rad
                          : angle_rad_ < stop.lower_rad ? angle_rad_ - stop.lower_rad
                                                        : 0.0;
    if (beyond != 0.0) {
      stop_stiffness_nm_rad = stop.stiffness_nm_rad;
      stop_constant_nm = stop_stiffness_nm_rad * beyond;
      stop_slope_nm_s_rad = 2.0 * stop_->damping_ratio * std::sqrt(stop_stiffness_nm_rad * inertia_kg_m2);
    }
  }

  const double inertia_per_step = inertia_kg_m2 / dt_s;
  const double least_slope = -0.5 * inertia_per_step;  // leaves half of J / dt in the denominator below
  double rate = predicted_rate_rad_s();
  AffineFriction friction;
  for (int refinement = 0;; ++refinement) {
    friction = linearise(rate, dt_s, least_slope);
    const double inertia = inertia_per_step / friction.theta;
    const double stop_slope = stop_slope_nm_s_rad + friction.theta * dt_s * stop_stiffness_nm_rad;
    const double solved = (inertia * rate_rad_s_ + drive_nm - friction.constant_nm - stop_constant_nm) /
                          (inertia + friction.slope_nm_s_rad + drag_nm_s_rad + stop_slope);
    const double miss = std::abs(solved - rate);
    rate = solved;
    if (model_ != FrictionModel::kLugre || refinement == kMostRefinements ||
        miss <= refine_rate_rad_s_) {
      break;
    }
    lugre_.refine(rate, friction.theta);
  }

  friction_torque_nm_ = model_ == FrictionModel::kLugre         ? lugre_.commit(rate)
                        : model_ == FrictionModel::kMaxwellSlip ? maxwell_slip_.commit(rate)
                                                                : 0.0;
  stop_torque_nm_ =
      stop_constant_nm + (stop_slope_nm_s_rad + friction.theta * dt_s * stop_stiffness_nm_rad) * rate;
  const double change = (rate - rate_rad_s_) / friction.theta;
  angle_rad_ += dt_s * (rate_rad_s_ + 0.5 * change);
  rate_rad_s_ += change;
  rate_change_rad_s_ = change;
  mean_rate_rad_s_ = rate;
}

}  // namespace trackservo::sim
