// SPDX-License-Identifier: Apache-2.0
#include "identification/motor_harmonics.hpp"

#include <cmath>

#include "identification/window.hpp"

namespace trackservo::identification {

Eigen::MatrixX2d harmonic_columns(const Recording& recording, const std::vector<std::size_t>& ticks,
                                  const MotorHarmonic& harmonic) {
  Eigen::MatrixX2d columns(static_cast<Eigen::Index>(ticks.size()), 2);
  for (std::size_t node = 0; node < ticks.size(); ++node) {
    const std::size_t i = ticks[node];
    // The angle hardly moves in a window: one sine and cosine are enough.
    const double size = harmonic.ripple ? triangle_mean(recording.torque_nm, i) : 1.0;
    const double angle = harmonic.per_turn * recording.joint_angle_rad[i];
    columns.row(static_cast<Eigen::Index>(node)) << size * std::cos(angle), size * std::sin(angle);
  }
  return columns;
}

}  // namespace trackservo::identification
