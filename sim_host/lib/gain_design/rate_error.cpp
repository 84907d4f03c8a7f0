// SPDX-License-Identifier: Apache-2.0
#include "gain_design/rate_error.hpp"

#include <cmath>

#include "units.hpp"

namespace trackservo::gain_design {
namespace {

// Densities are those of one side: their integral over the frequency in Hz is the mean square.
double white(double rms) { return rms * rms * 2.0 * kTick_s; }

// Mean squares of the rate error per Hz.
struct Densities {
  double disturbance = 0.0;
  double encoder = 0.0;
  double gyro = 0.0;
};

Densities densities(const LoopTransfers& at, double disturbance, const SensorNoise& noise) {
  const std::complex<double> closed = 1.0 / (1.0 + at.loop_gain());
  const std::complex<double> by_feedback = at.drive * at.feedback * closed;
  return {std::norm(at.mechanics * closed) * disturbance, std::norm(by_feedback * at.angle) * white(noise.angle_rad),
          std::norm(by_feedback * at.gyro) * white(noise.gyro_rad_s)};
}

}  // namespace

double RateError::rad_s() const {
  return std::sqrt(disturbance_rad_s * disturbance_rad_s + encoder_rad_s * encoder_rad_s + gyro_rad_s * gyro_rad_s);
}

RateError rate_error(const LinearMachine& machine, const speed_loop_params& params, const Disturbance& disturbance,
                     const SensorNoise& noise) {
  const std::vector<double> frequency_hz = log_space_with_modes(machine, 0.01, 0.499 / kTick_s, 400);
  Densities sum;
  Densities before;
  for (std::size_t i = 0; i < frequency_hz.size(); ++i) {
    const double f_hz = frequency_hz[i];
    const Densities now = densities(loop_transfers(machine, params, f_hz), density_nm2_hz(disturbance, f_hz), noise);
    const double half_width_hz = i == 0 ? 0.0 : 0.5 * (f_hz - frequency_hz[i - 1]);
    sum.disturbance += half_width_hz * (before.disturbance + now.disturbance);
    sum.encoder += half_width_hz * (before.encoder + now.encoder);
    sum.gyro += half_width_hz * (before.gyro + now.gyro);
    before = now;
  }
  return {std::sqrt(sum.disturbance), std::sqrt(sum.encoder), std::sqrt(sum.gyro)};
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
