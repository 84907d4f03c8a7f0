// SPDX-License-Identifier: Apache-2.0
#include "gain_design/rate_error.hpp"

#include <algorithm>
#include <cmath>

#include "units.hpp"

namespace trackservo::gain_design {
namespace {

// Densities are those of one side: their integral over the frequency in Hz is the mean square.
double white(double rms) { return rms * rms * 2.0 * kTick_s; }

// Rates from densities, within a width in Hz.
RateError around(const LoopTransfers& at, double disturbance, const SensorNoise& noise, double width_hz) {
  const std::complex<double> closed = 1.0 / (1.0 + at.loop_gain());
  const std::complex<double> by_feedback = at.drive * at.feedback * closed;
  return {std::abs(at.mechanics * closed) * std::sqrt(disturbance * width_hz),
          std::abs(by_feedback * at.angle) * std::sqrt(white(noise.angle_rad) * width_hz),
          std::abs(by_feedback * at.gyro) * std::sqrt(white(noise.gyro_rad_s) * width_hz)};
}

}  // namespace

double RateError::rad_s() const { return std::hypot(disturbance_rad_s, encoder_rad_s, gyro_rad_s); }

std::vector<RateErrorLine> rate_error_spectrum(const LinearMachine& machine, const speed_loop_params& params,
                                               const Disturbance& disturbance, const SensorNoise& noise) {
  const std::vector<double> frequency_hz = log_space_with_modes(machine, 0.01, 0.499 / kTick_s, 400);
  const std::size_t last = frequency_hz.size() - 1;
  std::vector<RateErrorLine> lines;
  lines.reserve(frequency_hz.size());
  for (std::size_t i = 0; i <= last; ++i) {
    const double f_hz = frequency_hz[i];
    const double width_hz = 0.5 * (frequency_hz[std::min(i + 1, last)] - frequency_hz[i == 0 ? 0 : i - 1]);
    const LoopTransfers at = loop_transfers(machine, params, f_hz);
    lines.push_back({f_hz, at.loop_gain(), around(at, density_nm2_hz(disturbance, f_hz), noise, width_hz)});
  }
  return lines;
}

RateError rate_error(const LinearMachine& machine, const speed_loop_params& params, const Disturbance& disturbance,
                     const SensorNoise& noise) {
  RateError sum;
  for (const RateErrorLine& line : rate_error_spectrum(machine, params, disturbance, noise)) {
    sum.disturbance_rad_s = std::hypot(sum.disturbance_rad_s, line.error.disturbance_rad_s);
    sum.encoder_rad_s = std::hypot(sum.encoder_rad_s, line.error.encoder_rad_s);
    sum.gyro_rad_s = std::hypot(sum.gyro_rad_s, line.error.gyro_rad_s);
  }
  return sum;
}

double torque_noise_nm(const LinearMachine& machine, const speed_loop_params& params, const SensorNoise& noise) {
  constexpr int kLines = 500;
  double sum = 0.0;
  for (int line = 0; line < kLines; ++line) {
    const LoopTransfers at = loop_transfers(machine, params, 0.5 / kTick_s * (line + 0.5) / kLines);
    const double readings = std::norm(at.angle * noise.angle_rad) + std::norm(at.gyro * noise.gyro_rad_s);
    sum += readings * std::norm(at.feedback / (1.0 + at.loop_gain()));
  }
  return std::sqrt(sum / kLines);
}

}  // namespace trackservo::gain_design
