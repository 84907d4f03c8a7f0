// SPDX-License-Identifier: Apache-2.0
#include "machine/plant/joint.hpp"

#include <algorithm>
#include <cmath>

namespace trackservo::sim {

namespace {

constexpr double kRefineShare = 0.02;  // of the Stribeck speed: keeps g(v) within about 1e-3 of its true value
constexpr double kMinLevel = 0.05;     // eccentricity never removes the friction completely

// Damping ratio of a linear spring-damper that returns the fraction e of the impact speed.
double damping_ratio_of(double restitution) {
  const double logarithm = std::log(restitution);
  return -logarithm / std::sqrt(kPi * kPi + logarithm * logarithm);
}

}  // namespace

// Only LuGre's linearisation depends on the predicted rate so strongly that it is ever refined.
double refine_rate_rad_s(FrictionModel model, const FrictionConfig& friction) {
  if (model != FrictionModel::kLugre) {
    return std::numeric_limits<double>::infinity();
  }
  return kRefineShare * std::min(friction.positive.stribeck_speed_rad_s, friction.negative.stribeck_speed_rad_s);
}

JointShape::JointShape(const AxisConfig& axis) : friction_(axis.friction) {
  if (axis.end_stops) {
    lower_rad_ = axis.end_stops->lower_rad;
    upper_rad_ = axis.end_stops->upper_rad;
    stiffness_nm_rad_ = axis.end_stops->stiffness_nm_rad;
    damping_ratio_ = damping_ratio_of(axis.end_stops->restitution);
  }
}

double JointShape::eccentricity_factor(double angle_rad) const {
  double factor = 1.0;
  if (friction_.eccentricity_once != 0.0) {
    factor += friction_.eccentricity_once * std::cos(angle_rad - friction_.eccentricity_once_phase_rad);
  }
  if (friction_.eccentricity_twice != 0.0) {
    factor += friction_.eccentricity_twice * std::cos(2.0 * (angle_rad - friction_.eccentricity_twice_phase_rad));
  }
  return std::max(factor, kMinLevel);
}

JointShape::Contact JointShape::contact(double angle_rad, double inertia_kg_m2) const {
  const double limit_rad = angle_rad > upper_rad_ ? upper_rad_ : lower_rad_;
  return {stiffness_nm_rad_ * (angle_rad - limit_rad), stiffness_nm_rad_,
          2.0 * damping_ratio_ * std::sqrt(stiffness_nm_rad_ * inertia_kg_m2)};
}

}  // namespace trackservo::sim
