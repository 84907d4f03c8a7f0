// SPDX-License-Identifier: Apache-2.0
// The notch for a resonance of the structure.
#ifndef TRACKSERVO_GAIN_DESIGN_NOTCH_HPP
#define TRACKSERVO_GAIN_DESIGN_NOTCH_HPP

#include <vector>

#include "identification/structural_mode.hpp"

namespace trackservo::gain_design {

// Returns the mode that exceeds a loop gain falling with 1/f the most; nullptr when there is none.
const StructuralMode *dominant_mode(const std::vector<StructuralMode>& modes);

// Object 0x2040:1 to 3.
struct NotchFilter {
  double frequency_hz = 0.0;
  double width_hz = 0.0;
  double depth = 1.0;
};

// Returns a notch as deep as the mode is high, and wide enough that its zeros lie on the mode's poles, within the
// firmware's ranges. It is at least a tenth of the frequency wide: a resonance moves by a few percent with load and
// temperature.
NotchFilter notch_for(const StructuralMode& mode);

}  // namespace trackservo::gain_design

#endif
