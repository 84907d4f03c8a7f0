// SPDX-License-Identifier: Apache-2.0
#include "device/node_setup.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "design/control_design.hpp"
#include "machine/plant/base_spectrum.hpp"

extern "C" {
#include "products/brushed_tracker/default_parameters.h"
#include "protection/motion_proof.h"
}

namespace trackservo::sim {

axis_parameters node_parameters(const PlantConfig& plant, int axis) {
  DesignOptions options;
  options.tracker = TRACKER_PREDICTIVE;
  const ControllerSpec& spec = controller_spec("pi_vob_ftc");
  design_controller(plant, spec, options);  // refuses an unstable plant
  return design_axis(plant, axis, spec, options);
}

namespace {

// Of the mean of a tick's readings; an encoder and a gyro with less noise may well repeat a reading.
bool readings_differ(const AxisConfig& axis) {
  const double code_rad = 2.0 * kPi / std::pow(2.0, axis.encoder.resolution_bits);
  return axis.encoder.jitter_rms_rad > 0.5 * code_rad && axis.gyro.noise_density_rad_s_rthz > 0.0;
}

// What the converters and the bridge add to the back-EMF: a third of a code and of the noise of the current through a
// warm winding, as much of the bus voltage, and what the dead time takes.
double back_emf_error_v(const PlantConfig& plant, const MotorConfig& motor) {
  const double warm = 1.4;
  const double code_a = 2.0 * plant.adc.current_full_scale_a / std::pow(2.0, plant.adc.resolution_bits);
  const double current_v = warm * motor.resistance_ohm * (plant.adc.current_noise_rms_a + code_a) / 3.0;
  const double bus_v = plant.adc.voltage_noise_rms_v + 2.0 * plant.adc.voltage_full_scale_v / std::pow(2.0, 12);
  const double dead_v = 2.0 * motor.dead_time_s / kPwmPeriod_s * plant.supply.voltage_v;
  return current_v + bus_v / 3.0 + 1.5 * dead_v;
}

}  // namespace

protection_limits node_limits(const PlantConfig& plant, int axis_index) {
  const AxisConfig& axis = plant.axis[static_cast<std::size_t>(axis_index)];
  const double code_rad = 2.0 * kPi / std::pow(2.0, axis.encoder.resolution_bits);
  const double sway_rad_s = 2.0 * kPi * axis.base_sway.frequency_hz * axis.base_sway.rms_rad;
  const double travel_rad = axis.end_stops ? axis.end_stops->upper_rad - axis.end_stops->lower_rad : 1.0;
  const double margin_rad = std::min(0.0175, 0.1 * travel_rad);  // one degree
  const auto f = [](double value) { return static_cast<float>(value); };
  protection_limits limits{};
  limits.overspeed_rad_s = 1.5F;
  limits.base_rate_rad_s = f(0.02 + 6.0 * sway_rad_s + fastest_base_rate_rad_s(plant));
  limits.gyro_range_rad_s = f(axis.gyro.range_rad_s);
  limits.encoder_jump_rad = f(std::max(5e-4, 4.0 * code_rad + 10.0 * axis.encoder.jitter_rms_rad));
  limits.stuck_s = readings_differ(axis) ? 0.1F : 0.0F;
  limits.speed_error_rad_s = 0.5F;
  limits.speed_error_s = 0.3F;
  limits.stall_s = 0.5F;
  limits.minimum_rad = axis.end_stops ? f(axis.end_stops->lower_rad + margin_rad) : 0.0F;
  limits.maximum_rad = axis.end_stops ? f(axis.end_stops->upper_rad - margin_rad) : 0.0F;
  limits.continuous_current_a = f(0.5 * axis.motor.current_limit_a);
  limits.thermal_time_s = 60.0F;
  limits.current_offset_a = f(axis.motor.current_limit_a / 32.0);
  limits.voltage_mismatch_v = f(plant.supply.voltage_v / 12.0);
  limits.under_voltage_v = f(0.75 * plant.supply.voltage_v);
  limits.over_voltage_v = f(1.25 * plant.supply.voltage_v);
  limits.motor_tolerance = 0.32F;
  limits.back_emf_error_v = f(back_emf_error_v(plant, axis.motor));
  limits.fixed_base_rad =
      fastest_base_rate_rad_s(plant) == 0.0 && 6.0 * axis.base_sway.rms_rad < 0.0025 ? 0.005F : 0.0F;
  limits.encoder_outlier_rad = f(std::max(1.5e-5, 4.0 * code_rad + 10.0 * axis.encoder.jitter_rms_rad));
  limits.standstill_rad = 0.01F;
  limits.reduced_speed_rad_s = 0.0872665F;
  limits.direction_rad = 0.05F;
  // Four standard deviations of what noise swings in a window.
  limits.proof_rad_s =
      f(std::max(3e-5, 4.0 * axis.gyro.noise_density_rad_s_rthz / std::sqrt(1e-3 * MOTION_PROOF_TICKS)));
  limits.stopping_margin_rad = f(std::min(0.005, 0.1 * travel_rad));
  // Three standard deviations of the wind, its mean and the imbalance, less the Coulomb friction, take less than a
  // quarter of the torque.
  const double inertia_kg_m2 = axis.inertia_kg_m2 + axis.inertia_swing_kg_m2;
  const double torque_nm = axis.motor.current_limit_a * axis.motor.torque_constant_nm_a;
  const double deceleration_rad_s2 = std::clamp(0.75 * torque_nm / inertia_kg_m2, 0.01, 1e4);
  limits.deceleration_rad_s2 = f(deceleration_rad_s2);
  limits.stop_deceleration_rad_s2 = f(std::min(1.0, 0.2 * deceleration_rad_s2));
  limits.travel_kind = axis.end_stops ? 0.0F : 1.0F;
  return limits;
}

hal_scales node_scales(const PlantConfig& plant) {
  const auto current_a = static_cast<float>(plant.adc.current_full_scale_a);
  return {{current_a, current_a}, {current_a, current_a}, static_cast<float>(plant.adc.voltage_full_scale_v)};
}

NodeSetup::NodeSetup(const PlantConfig& of_plant)
    : plant(of_plant),
      parameters{node_parameters(plant, kAzimuth), node_parameters(plant, kPitch)},
      limits{node_limits(plant, kAzimuth), node_limits(plant, kPitch)},
      scales(node_scales(plant)) {}

NodeSetup::NodeSetup(const PlantConfig& of_plant, const std::array<axis_parameters, kAxes>& with_parameters)
    : NodeSetup(of_plant, with_parameters, {node_limits(of_plant, kAzimuth), node_limits(of_plant, kPitch)}) {}

NodeSetup::NodeSetup(const PlantConfig& of_plant, const std::array<axis_parameters, kAxes>& with_parameters,
                     const std::array<protection_limits, kAxes>& with_limits)
    : plant(of_plant), parameters(with_parameters), limits(with_limits), scales(node_scales(plant)) {}

NodeSetup product_setup(const PlantConfig& plant) {
  return {plant,
          {default_parameters[kAzimuth], default_parameters[kPitch]},
          {default_limits[kAzimuth], default_limits[kPitch]}};
}

}  // namespace trackservo::sim
