// SPDX-License-Identifier: Apache-2.0
#include "studies/random_plants/random_plant.hpp"

#include <algorithm>

#include "machine/base/random.hpp"

namespace trackservo::sim {
namespace {

// Draws in a fixed order from one stream per axis, so that a plant is defined by its nominal plant and its seed.
class Draw {
 public:
  Draw(RandomPlant& plant, double share, std::uint64_t seed, std::string place, int axis)
      : plant_(plant), share_(share), place_(std::move(place)), stream_(seed, "plant.deviation", axis) {}

  void vary(const std::string& key, double& value) { value *= factor(key); }

  void vary(const std::string& key, double& value, double& same) {
    const double both = factor(key);
    value *= both;
    same *= both;
  }

  void turn(double& angle_rad) { angle_rad = (2.0 * stream_.uniform() - 1.0) * kPi; }

 private:
  double factor(const std::string& key) {
    const double value = 1.0 + share_ * (2.0 * stream_.uniform() - 1.0);
    plant_.deviations.push_back({place_ + key, value});
    return value;
  }

  RandomPlant& plant_;
  double share_;
  std::string place_;
  RandomStream stream_;
};

void vary(Draw& draw, MotorConfig& motor) {
  draw.vary("motor.torque_constant_nm_a", motor.torque_constant_nm_a, motor.back_emf_constant_v_s_rad);
  draw.vary("motor.resistance_ohm", motor.resistance_ohm);
  draw.vary("motor.inductance_mh", motor.inductance_h);
  draw.vary("motor.dead_time_us", motor.dead_time_s);
  for (RippleConfig& ripple : motor.ripple) {
    draw.vary("motor.ripple.amplitude_percent." + std::to_string(ripple.harmonic), ripple.fraction);
    draw.turn(ripple.phase_rad);
  }
  for (CoggingConfig& cogging : motor.cogging) {
    draw.vary("motor.cogging.amplitude_nm." + std::to_string(cogging.harmonic), cogging.amplitude_nm);
    draw.turn(cogging.phase_rad);
  }
}

void vary(Draw& draw, const std::string& direction, StribeckConfig& stribeck) {
  draw.vary("friction." + direction + ".coulomb_nm", stribeck.coulomb_nm);
  draw.vary("friction." + direction + ".breakaway_nm", stribeck.breakaway_nm);
  draw.vary("friction." + direction + ".stribeck_speed_deg_s", stribeck.stribeck_speed_rad_s);
  draw.vary("friction." + direction + ".viscous_nm_s_rad", stribeck.viscous_nm_s_rad);
  stribeck.breakaway_nm = std::max(stribeck.breakaway_nm, stribeck.coulomb_nm);
}

void vary(Draw& draw, FrictionConfig& friction) {
  draw.vary("friction.stiffness_nm_rad", friction.stiffness_nm_rad);
  draw.vary("friction.damping_nm_s_rad", friction.damping_nm_s_rad);
  draw.vary("friction.eccentricity_once_percent", friction.eccentricity_once);
  draw.vary("friction.eccentricity_twice_percent", friction.eccentricity_twice);
  draw.turn(friction.eccentricity_once_phase_rad);
  draw.turn(friction.eccentricity_twice_phase_rad);
  vary(draw, "positive", friction.positive);
  vary(draw, "negative", friction.negative);
}

void vary(Draw& draw, LoadConfig& load) {
  draw.vary("load.imbalance_nm", load.imbalance_nm);
  draw.turn(load.imbalance_phase_rad);
  draw.vary("load.cable_stiffness_nm_rad", load.cable_stiffness_nm_rad);
  draw.turn(load.cable_neutral_rad);
  draw.vary("load.wind_mean_nm", load.wind_mean_nm);
  draw.vary("load.wind_gust_rms_nm", load.wind_gust_rms_nm);
  draw.vary("load.wind_turbulence_corner_hz", load.wind_turbulence_corner_hz);
  draw.vary("load.wind_admittance_corner_hz", load.wind_admittance_corner_hz);
  draw.vary("load.broadband_rms_nm", load.broadband_rms_nm);
}

void vary(Draw& draw, EncoderConfig& encoder) {
  draw.vary("encoder.jitter_rms_urad", encoder.jitter_rms_rad);
  draw.vary("encoder.eccentricity_urad", encoder.eccentricity_rad);
  draw.turn(encoder.eccentricity_phase_rad);
  draw.vary("encoder.latency_us", encoder.latency_s);
}

void vary(Draw& draw, GyroConfig& gyro) {
  draw.vary("gyro.noise_density_deg_s_rthz", gyro.noise_density_rad_s_rthz);
  draw.vary("gyro.bandwidth_hz", gyro.bandwidth_hz);
  draw.vary("gyro.bias_deg_s", gyro.bias_rad_s);
  draw.vary("gyro.scale_error_ppm", gyro.scale_error);
  draw.vary("gyro.latency_us", gyro.latency_s);
}

void vary(Draw& draw, AxisConfig& axis) {
  draw.vary("inertia_kg_m2", axis.inertia_kg_m2);
  draw.vary("inertia_swing_kg_m2", axis.inertia_swing_kg_m2);
  vary(draw, axis.motor);
  vary(draw, axis.friction);
  vary(draw, axis.load);
  if (axis.structure) {
    draw.vary("structure.frequency_hz", axis.structure->frequency_hz);
    draw.vary("structure.damping", axis.structure->damping);
    draw.vary("structure.inertia_share", axis.structure->inertia_share);
  }
  draw.vary("base_sway.rms_urad", axis.base_sway.rms_rad);
  draw.vary("base_sway.frequency_hz", axis.base_sway.frequency_hz);
  draw.vary("base_sway.damping", axis.base_sway.damping);
  vary(draw, axis.encoder);
  vary(draw, axis.gyro);
  // Of later versions: drawn last, so that a seed still gives the numbers above.
  draw.vary("encoder.subdivision_error_urad", axis.encoder.subdivision_error_rad);
  if (axis.structure) {
    draw.vary("structure.backlash_urad", axis.structure->backlash_rad);
  }
}

void vary_shared(Draw& draw, PlantConfig& plant) {
  draw.vary("supply.voltage_v", plant.supply.voltage_v);
  draw.vary("supply.source_resistance_ohm", plant.supply.source_resistance_ohm);
  draw.vary("adc.current_noise_rms_a", plant.adc.current_noise_rms_a);
  draw.vary("adc.current_offset_a", plant.adc.current_offset_a);
  draw.vary("adc.voltage_noise_rms_v", plant.adc.voltage_noise_rms_v);
  draw.vary("base_tilt.tilt_deg", plant.base_tilt.tilt_rad);
  draw.turn(plant.base_tilt.direction_rad);
}

}  // namespace

RandomPlant random_plant(const PlantConfig& nominal, double share, std::uint64_t seed) {
  RandomPlant plant{nominal, {}};
  Draw shared(plant, share, seed, "", kAxes);
  vary_shared(shared, plant.config);
  for (int axis = 0; axis < kAxes; ++axis) {
    Draw draw(plant, share, seed, std::string(axis_name(axis)) + ".", axis);
    vary(draw, plant.config.axis[static_cast<std::size_t>(axis)]);
  }
  return plant;
}

const std::vector<std::string>& retained_keys() {
  static const std::vector<std::string> all = {
      "adc.current_full_scale_a", "adc.voltage_full_scale_v",  "end_stop_stiffness_nm_rad",
      "end_stop_restitution",     "motor.current_limit_a",     "gyro.range_deg_s",
      "supply.capacitance_mf",    "supply.brake_resistor_ohm", "supply.brake_resistor_v"};
  return all;
}

}  // namespace trackservo::sim
