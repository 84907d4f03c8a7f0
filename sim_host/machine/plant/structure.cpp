// SPDX-License-Identifier: Apache-2.0
#include "machine/plant/structure.hpp"

#include <algorithm>

namespace trackservo::sim {

Structure::Structure(const StructureConfig& config, double inertia_kg_m2, double dt_s) : config_(config), dt_s_(dt_s) {
  const double frequency_rad_s = 2.0 * kPi * config.frequency_hz;
  const double reduced_kg_m2 = share() * (1.0 - share()) * inertia_kg_m2;
  stiffness_nm_rad_ = frequency_rad_s * frequency_rad_s * reduced_kg_m2;
  step_drag_nm_s_rad_ = 0.5 * stiffness_nm_rad_ * dt_s + 2.0 * config.damping * frequency_rad_s * reduced_kg_m2;
}

// Of the spring: what the twist has beyond the play; 0 within it.
double Structure::stretch_rad() const {
  const double half_rad = 0.5 * config_.backlash_rad;
  return twist_rad_ - std::clamp(twist_rad_, -half_rad, half_rad);
}

// Whether the flanks touch counts for the whole step: at 50 us a payload of 0.1 rad/s moves by 5 urad in it.
Structure::Reaction Structure::reaction(double inertia_kg_m2, double base_acceleration_rad_s2, double load_nm) {
  const double behind_kg_m2 = share() * inertia_kg_m2;
  const double inertia_per_step = 2.0 * behind_kg_m2 / dt_s_;
  const bool touches = config_.backlash_rad == 0.0 || stretch_rad() != 0.0;
  const double drag_nm_s_rad = touches ? step_drag_nm_s_rad_ : 0.0;
  const double spring_nm = stiffness_nm_rad_ * stretch_rad();
  const double inverse = 1.0 / (inertia_per_step + drag_nm_s_rad);
  mean_constant_rad_s_ =
      (inertia_per_step * rate_rad_s_ - spring_nm - behind_kg_m2 * base_acceleration_rad_s2 - load_nm) * inverse;
  mean_slope_ = drag_nm_s_rad * inverse;
  return {spring_nm + drag_nm_s_rad * mean_constant_rad_s_, drag_nm_s_rad * (1.0 - mean_slope_)};
}

void Structure::commit(double joint_rate_rad_s) {
  const double mean_rad_s = mean_constant_rad_s_ + mean_slope_ * joint_rate_rad_s;
  rate_rad_s_ = 2.0 * mean_rad_s - rate_rad_s_;
  twist_rad_ += dt_s_ * (mean_rad_s - joint_rate_rad_s);
}

}  // namespace trackservo::sim
