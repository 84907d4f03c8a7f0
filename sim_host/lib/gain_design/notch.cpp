// SPDX-License-Identifier: Apache-2.0
#include "gain_design/notch.hpp"

#include <algorithm>
#include <cmath>

namespace trackservo::gain_design {

const StructuralMode *dominant_mode(const std::vector<StructuralMode>& modes) {
  const auto prominence = [](const StructuralMode& mode) { return relative_height(mode) / mode.frequency_rad_s; };
  const auto found =
      std::max_element(modes.begin(), modes.end(),
                       [&](const StructuralMode& a, const StructuralMode& b) { return prominence(a) < prominence(b); });
  return found == modes.end() ? nullptr : &*found;
}

NotchFilter notch_for(const StructuralMode& mode) {
  constexpr double kMinDepth = 0.03;
  constexpr double kMinRelativeWidth = 0.1;
  constexpr double kMaxRelativeWidth = 1.5;  // the firmware accepts up to 2
  const double frequency_hz = mode.frequency_rad_s / (2.0 * M_PI);
  const double depth = std::max(1.0 / relative_height(mode), kMinDepth);
  const double relative_width = 2.0 * mode.damping / depth;
  return {frequency_hz, frequency_hz * std::clamp(relative_width, kMinRelativeWidth, kMaxRelativeWidth), depth};
}

}  // namespace trackservo::gain_design
