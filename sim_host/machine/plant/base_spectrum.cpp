// SPDX-License-Identifier: Apache-2.0
#include "machine/plant/base_spectrum.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "machine/base/random.hpp"

namespace trackservo::sim {
namespace {

constexpr double kFastestSigmas = 4.0;

// Integral of f^-slope.
double power_between(double low_hz, double high_hz, double slope) {
  const double exponent = 1.0 - slope;
  if (std::abs(exponent) < 1e-9) {
    return std::log(high_hz / low_hz);
  }
  return (std::pow(high_hz, exponent) - std::pow(low_hz, exponent)) / exponent;
}

}  // namespace

std::vector<BaseMotionLine> lines_of(const BaseSpectrum& band, int index) {
  RandomStream random(static_cast<std::uint64_t>(band.seed), "base.spectrum", index);
  const double whole = power_between(band.low_hz, band.high_hz, band.slope);
  const double ratio = std::pow(band.high_hz / band.low_hz, 1.0 / band.sines);
  std::vector<BaseMotionLine> lines;
  double from_hz = band.low_hz;
  for (int i = 0; i < band.sines; ++i) {
    const double to_hz = from_hz * ratio;
    const double share = power_between(from_hz, to_hz, band.slope) / whole;
    const double frequency_hz = from_hz * std::pow(ratio, random.uniform());
    const double phase_rad = 2.0 * kPi * random.uniform();
    lines.push_back({band.axis, frequency_hz, band.rms_rad * std::sqrt(2.0 * share), phase_rad});
    from_hz = to_hz;
  }
  return lines;
}

std::vector<BaseMotionLine> base_motion_lines(const PlantConfig& plant) {
  std::vector<BaseMotionLine> lines = plant.base_motion;
  for (std::size_t i = 0; i < plant.base_spectrum.size(); ++i) {
    const std::vector<BaseMotionLine> more = lines_of(plant.base_spectrum[i], static_cast<int>(i));
    lines.insert(lines.end(), more.begin(), more.end());
  }
  return lines;
}

double fastest_base_rate_rad_s(const PlantConfig& plant) {
  std::array<double, 3> sum_rad_s{};
  std::array<double, 3> variance_rad2_s2{};
  for (const BaseMotionLine& line : base_motion_lines(plant)) {
    const double rate_rad_s = 2.0 * kPi * line.frequency_hz * line.amplitude_rad;
    sum_rad_s.at(static_cast<std::size_t>(line.axis)) += rate_rad_s;
    variance_rad2_s2.at(static_cast<std::size_t>(line.axis)) += 0.5 * rate_rad_s * rate_rad_s;
  }
  double square_rad2_s2 = 0.0;
  for (std::size_t axis = 0; axis < sum_rad_s.size(); ++axis) {
    const double fastest_rad_s = std::min(sum_rad_s[axis], kFastestSigmas * std::sqrt(variance_rad2_s2[axis]));
    square_rad2_s2 += fastest_rad_s * fastest_rad_s;
  }
  return std::sqrt(square_rad2_s2);
}

}  // namespace trackservo::sim
