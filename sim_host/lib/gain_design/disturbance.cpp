// SPDX-License-Identifier: Apache-2.0
#include "gain_design/disturbance.hpp"

#include <algorithm>
#include <cmath>
#include <complex>

#include "gain_design/log_space.hpp"

namespace trackservo::gain_design {
namespace {

// The rms for which the mean logarithm of the spectra is the same, and the mean square of what is left between them.
struct Comparison {
  double rms_nm = 0.0;
  double mean_square = 0.0;
};

Comparison compared(const std::vector<double>& frequency_hz, const std::vector<double>& log_density, double corner_hz) {
  double sum = 0.0;
  double squares = 0.0;
  for (std::size_t i = 0; i < frequency_hz.size(); ++i) {
    const double difference = log_density[i] - std::log(density_nm2_hz(Disturbance{1.0, corner_hz}, frequency_hz[i]));
    sum += difference;
    squares += difference * difference;
  }
  const double count = static_cast<double>(frequency_hz.size());
  const double mean = sum / count;
  return {std::exp(0.5 * mean), squares / count - mean * mean};
}

}  // namespace

double density_nm2_hz(const Disturbance& disturbance, double frequency_hz) {
  const double lag = 1.0 + std::pow(frequency_hz / disturbance.corner_hz, 2);
  return std::pow(disturbance.rms_nm, 2) * 4.0 / (M_PI * disturbance.corner_hz * lag * lag);
}

double density_nm2_hz(const ResidualNoise& noise, double frequency_hz) {
  std::complex<double> sum = 1.0;
  for (std::size_t lag = 1; lag <= noise.autoregression.size(); ++lag) {
    const double turned = -2.0 * M_PI * frequency_hz * noise.step_s * static_cast<double>(lag);
    sum += noise.autoregression[lag - 1] * std::polar(1.0, turned);
  }
  return 2.0 * noise.step_s * std::pow(noise.innovation_nm, 2) / std::norm(sum);
}

std::optional<Disturbance> slow_disturbance(const ResidualNoise& noise) {
  constexpr double kLowest_hz = 0.1;
  constexpr double kHighest_hz = 20.0;
  constexpr double kLeastFall = 10.0;
  std::vector<double> frequency_hz = log_space(kLowest_hz, std::min(kHighest_hz, 0.5 / noise.step_s), 200);
  std::vector<double> log_density;
  log_density.reserve(frequency_hz.size());
  for (const double f_hz : frequency_hz) {
    log_density.push_back(std::log(density_nm2_hz(noise, f_hz)));
  }
  const auto lowest = std::min_element(log_density.begin(), log_density.end());
  if (*std::max_element(log_density.begin(), lowest + 1) - *lowest < std::log(kLeastFall)) {
    return std::nullopt;
  }
  frequency_hz.resize(static_cast<std::size_t>(lowest - log_density.begin()) + 1);
  log_density.resize(frequency_hz.size());
  std::optional<Disturbance> nearest;
  double least = 0.0;
  for (const double corner_hz : log_space(kLowest_hz, frequency_hz.back(), 200)) {
    const Comparison comparison = compared(frequency_hz, log_density, corner_hz);
    if (!nearest || comparison.mean_square < least) {
      nearest = Disturbance{comparison.rms_nm, corner_hz};
      least = comparison.mean_square;
    }
  }
  return nearest;
}

}  // namespace trackservo::gain_design
