// SPDX-License-Identifier: Apache-2.0
#include "identification/sensor_noise.hpp"

#include <algorithm>
#include <cmath>

namespace trackservo::identification {

// White noise passes fourth differences with a power of 70, real motion almost not at all. The median ignores the ticks
// in which the axis moves fast.
double white_noise_rms(const std::vector<double>& values, const std::vector<Stretch>& stretches) {
  constexpr double kPower = 70.0;
  constexpr double kMedianOfNormal = 0.6745;
  std::vector<double> differences;
  for (const Stretch& stretch : stretches) {
    for (std::size_t i = stretch.first + 4; i < stretch.last; ++i) {
      const double *v = values.data() + i;
      const double difference = v[0] - 4.0 * v[-1] + 6.0 * v[-2] - 4.0 * v[-3] + v[-4];
      if (!std::isnan(difference)) {
        differences.push_back(std::abs(difference));
      }
    }
  }
  if (differences.empty()) {
    return 0.0;
  }
  const auto middle = differences.begin() + static_cast<std::ptrdiff_t>(differences.size() / 2);
  std::nth_element(differences.begin(), middle, differences.end());
  return *middle / (kMedianOfNormal * std::sqrt(kPower));
}

}  // namespace trackservo::identification
