// SPDX-License-Identifier: Apache-2.0
#include "gain_design/identified_plant.hpp"

#include <algorithm>
#include <cmath>

namespace trackservo::gain_design {

LinearMachine linear_machine(const IdentifiedPlant& plant, double current_loop_rad_s, bool pre_sliding) {
  const lugre_params& friction = plant.friction;
  LinearMachine m;
  m.inertia_kg_m2 = plant.inertia_kg_m2;
  m.viscous_nm_s_rad =
      static_cast<double>(std::min(friction.positive.viscous_nm_s_rad, friction.negative.viscous_nm_s_rad));
  m.bristle_stiffness_nm_rad = pre_sliding ? static_cast<double>(friction.stiffness_nm_rad) : 0.0;
  m.bristle_damping_nm_s_rad = pre_sliding ? static_cast<double>(friction.damping_nm_s_rad) : 0.0;
  m.modes = plant.modes;
  m.actuation_delay_s = kActuationDelay_s;
  m.current_loop_rad_s = current_loop_rad_s;
  m.encoder_latency_s = plant.encoder.latency_s;
  m.gyro_latency_s = plant.gyro.latency_s;
  m.gyro_bandwidth_rad_s = 2.0 * M_PI * plant.gyro.bandwidth_hz;
  m.gyro_below_joint = plant.gyro.below_joint;
  m.gyro_on_payload = plant.gyro.on_payload && !plant.modes.empty();
  return m;
}

std::vector<LinearMachine> operating_points(const IdentifiedPlant& plant, double current_loop_rad_s) {
  std::vector<LinearMachine> machines;
  for (const double factor : {1.0, 1.0 - kResonanceSpread, 1.0 + kResonanceSpread}) {
    if (factor != 1.0 && plant.modes.empty()) {
      break;
    }
    for (const bool pre_sliding : {false, true}) {
      machines.push_back(linear_machine(plant, current_loop_rad_s, pre_sliding));
      for (StructuralMode& mode : machines.back().modes) {
        mode.frequency_rad_s *= factor;
      }
    }
  }
  return machines;
}

std::vector<LinearMachine> with_other_inertia(std::vector<LinearMachine> machines) {
  const std::size_t count = machines.size();
  for (const double factor : {1.0 - kInertiaSpread, 1.0 + kInertiaSpread}) {
    for (std::size_t i = 0; i < count; ++i) {
      machines.push_back(machines[i]);
      machines.back().inertia_kg_m2 *= factor;
    }
  }
  return machines;
}

void set_friction(axis_parameters& parameters, const lugre_params& friction) {
  parameters.friction.stiffness_nm_rad = friction.stiffness_nm_rad;
  parameters.friction.damping_nm_s_rad = friction.damping_nm_s_rad;
  parameters.friction.positive = friction.positive;
  parameters.friction.negative = friction.negative;
}

void set_plant(axis_parameters& parameters, const IdentifiedPlant& plant) {
  const auto f = [](double value) { return static_cast<float>(value); };
  const lugre_params& friction = plant.friction;
  parameters.plant.inertia_kg_m2 = f(plant.inertia_kg_m2);
  parameters.plant.min_inertia_kg_m2 = f(plant.inertia_kg_m2);
  parameters.plant.viscous_nm_s_rad = std::min(friction.positive.viscous_nm_s_rad, friction.negative.viscous_nm_s_rad);
  parameters.plant.stiffness_nm_rad = friction.stiffness_nm_rad;
  parameters.plant.damping_nm_s_rad = friction.damping_nm_s_rad;
  parameters.plant.encoder_delay_s = f(std::max(plant.encoder.latency_s, 0.0));
  parameters.plant.gyro_delay_s = f(std::max(plant.gyro.latency_s, 0.0));
  parameters.plant.gyro_bandwidth_rad_s = f(2.0 * M_PI * plant.gyro.bandwidth_hz);
}

}  // namespace trackservo::gain_design
