// SPDX-License-Identifier: Apache-2.0
#include "machine/plant/structure.hpp"

namespace trackservo::sim {

Structure::Structure(const StructureConfig& config, double inertia_kg_m2, double dt_s)
    : share_(config.inertia_share), dt_s_(dt_s) {
  const double frequency_rad_s = 2.0 * kPi * config.frequency_hz;
  const double reduced_kg_m2 = share_ * (1.0 - share_) * inertia_kg_m2;
  stiffness_nm_rad_ = frequency_rad_s * frequency_rad_s * reduced_kg_m2;
  step_drag_nm_s_rad_ = 0.5 * stiffness_nm_rad_ * dt_s + 2.0 * config.damping * frequency_rad_s * reduced_kg_m2;
}

Structure::Reaction Structure::reaction(double inertia_kg_m2, double base_acceleration_rad_s2) {
  const double behind_kg_m2 = share_ * inertia_kg_m2;
  const double inertia_per_step = 2.0 * behind_kg_m2 / dt_s_;
  const double spring_nm = stiffness_nm_rad_ * twist_rad_;
  const double inverse = 1.0 / (inertia_per_step + step_drag_nm_s_rad_);
  mean_constant_rad_s_ =
      (inertia_per_step * rate_rad_s_ - spring_nm - behind_kg_m2 * base_acceleration_rad_s2) * inverse;
  mean_slope_ = step_drag_nm_s_rad_ * inverse;
  return {spring_nm + step_drag_nm_s_rad_ * mean_constant_rad_s_, step_drag_nm_s_rad_ * (1.0 - mean_slope_)};
}

void Structure::commit(double joint_rate_rad_s) {
  const double mean_rad_s = mean_constant_rad_s_ + mean_slope_ * joint_rate_rad_s;
  rate_rad_s_ = 2.0 * mean_rad_s - rate_rad_s_;
  twist_rad_ += dt_s_ * (mean_rad_s - joint_rate_rad_s);
}

}  // namespace trackservo::sim
