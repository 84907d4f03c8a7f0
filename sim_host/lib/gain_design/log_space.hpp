// SPDX-License-Identifier: Apache-2.0
// Frequencies at which a response or a spectrum is computed.
#ifndef TRACKSERVO_GAIN_DESIGN_LOG_SPACE_HPP
#define TRACKSERVO_GAIN_DESIGN_LOG_SPACE_HPP

#include <cmath>
#include <vector>

namespace trackservo::gain_design {

constexpr double kHzPerRad_s = 0.5 / M_PI;

// Returns `count` frequencies, logarithmically spaced.
inline std::vector<double> log_space(double first_hz, double last_hz, int count) {
  std::vector<double> points;
  points.reserve(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    points.push_back(first_hz * std::pow(last_hz / first_hz, static_cast<double>(i) / (count - 1)));
  }
  return points;
}

}  // namespace trackservo::gain_design

#endif
