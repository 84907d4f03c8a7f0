// SPDX-License-Identifier: Apache-2.0
#include "design/true_plant.hpp"

#include <cmath>

#include "machine/run/machine.hpp"

namespace trackservo::sim {
namespace {

static_assert(SERVO_TICK_LATENCY_PERIODS * kPwmPeriod_s == gain_design::kActuationDelay_s,
              "the simulated board has the timing that gains are designed for");

lugre_direction direction_of(const StribeckConfig& truth) {
  return {static_cast<float>(truth.coulomb_nm), static_cast<float>(truth.breakaway_nm),
          static_cast<float>(truth.stribeck_speed_rad_s), static_cast<float>(truth.viscous_nm_s_rad)};
}

// Quantisation and jitter of the averaged readings.
double encoder_noise_rad(const EncoderConfig& encoder) {
  const double step_rad = 2.0 * kPi / std::pow(2.0, encoder.resolution_bits);
  return std::sqrt((encoder.jitter_rms_rad * encoder.jitter_rms_rad + step_rad * step_rad / 12.0) /
                   encoder.reads_per_tick);
}

// Both corners as one, in their middle.
std::optional<gain_design::Disturbance> wind_of(const LoadConfig& load) {
  if (load.wind_gust_rms_nm <= 0.0) {
    return std::nullopt;
  }
  return gain_design::Disturbance{load.wind_gust_rms_nm,
                                  std::sqrt(load.wind_turbulence_corner_hz * load.wind_admittance_corner_hz)};
}

}  // namespace

gain_design::IdentifiedPlant true_plant(const PlantConfig& plant, int axis) {
  const AxisConfig& a = plant.axis[static_cast<std::size_t>(axis)];
  gain_design::IdentifiedPlant known;
  known.inertia_kg_m2 = axis_inertia_kg_m2(plant, axis, 0.0);
  known.friction.stiffness_nm_rad = static_cast<float>(a.friction.stiffness_nm_rad);
  known.friction.damping_nm_s_rad = static_cast<float>(a.friction.damping_nm_s_rad);
  known.friction.positive = direction_of(a.friction.positive);
  known.friction.negative = direction_of(a.friction.negative);
  if (a.structure) {
    const double share = a.structure->inertia_share;
    known.modes.push_back({2.0 * kPi * a.structure->frequency_hz, a.structure->damping, share / (1.0 - share)});
  }
  known.encoder = {a.encoder.latency_s + 0.5 * (a.encoder.reads_per_tick - 1) * kPwmPeriod_s,
                   encoder_noise_rad(a.encoder)};
  known.gyro = {a.gyro.latency_s, a.gyro.bandwidth_hz, a.gyro.noise_density_rad_s_rthz * std::sqrt(0.5 / kTick_s),
                is_below_joint(a.gyro.mounting, axis), a.structure && a.structure->optics == StructureSide::kPayload};
  known.disturbance = wind_of(a.load);
  return known;
}

}  // namespace trackservo::sim
