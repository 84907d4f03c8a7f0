// SPDX-License-Identifier: Apache-2.0
// Steady friction of one direction from torques at constant speeds, eqs (4)-(7): least squares for eq. (5).
#ifndef TRACKSERVO_IDENTIFICATION_STRIBECK_FIT_HPP
#define TRACKSERVO_IDENTIFICATION_STRIBECK_FIT_HPP

#include <optional>
#include <vector>

#include "identification/lugre.hpp"

namespace trackservo::identification {

// Friction torque of a steady speed, both positive, and the number of averaged measurements.
struct SteadyPoint {
  double speed_rad_s = 0;
  double friction_nm = 0;
  double weight = 1;
};

// Returns the fitted friction; nothing with fewer than four speeds or with torques that are no friction (the mean is
// not positive).
std::optional<DirectionFriction> fit_stribeck(const std::vector<SteadyPoint>& points);

}  // namespace trackservo::identification

#endif
