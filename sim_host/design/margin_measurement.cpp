// SPDX-License-Identifier: Apache-2.0
#include "design/margin_measurement.hpp"

#include <algorithm>
#include <cmath>

#include "design/frequency_measurement.hpp"

namespace trackservo::sim {
namespace {

constexpr double kBiasRate_rad_s = 2.0 * kRadPerDeg;

// Strong enough to exceed wind and noise, weak enough to stay in the regime (no reversal, no break-away).
double torque_rms_nm(const PlantConfig& plant, int axis, bool pre_sliding) {
  return (pre_sliding ? 0.2 : 1.0) * plant.axis[static_cast<std::size_t>(axis)].friction.positive.coulomb_nm;
}

// Around the crossover and beyond the frequency that decides the gain margin. Below this band, the wind is stronger
// than any test torque; far above it, the loop gain is below the noise.
void choose_band(MeasurementRequest& request, const Margins& computed) {
  constexpr double kNyquistReserve_hz = 450.0;
  request.first_hz = computed.crossover_hz / 4.0;
  request.last_hz = 10.0 * computed.crossover_hz;
  if (std::isfinite(computed.phase_crossover_hz)) {
    request.last_hz = std::max(request.last_hz, 1.3 * computed.phase_crossover_hz);
  }
  request.last_hz = std::min(request.last_hz, kNyquistReserve_hz);
}

}  // namespace

FrequencyResponse measured_near_crossover(const PlantConfig& plant, const servo_params& params, int axis,
                                          bool pre_sliding, const Margins& computed, std::uint64_t seed,
                                          double pitch_rad) {
  MeasurementRequest request;
  request.plant = &plant;
  request.params = params;
  request.axis = axis;
  request.pitch_rad = pitch_rad;
  request.bias_rate_rad_s = pre_sliding ? 0.0 : kBiasRate_rad_s;
  request.torque_rms_nm = torque_rms_nm(plant, axis, pre_sliding);
  request.seed = seed;
  choose_band(request, computed);
  return measured_loop_gain(request);
}

}  // namespace trackservo::sim
