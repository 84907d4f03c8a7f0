// SPDX-License-Identifier: Apache-2.0
// Do the requirements of a plant file suit the machine? Refuses loops that would be unstable, and warns of those close
// to it.
//
// Instability is an error, because no result of such a loop is meaningful. Stability with less than 6 dB or 40 degrees
// is a warning: a user may want to study exactly that. Both name the file's line, the finding, and a value that meets
// the margins, found by lowering the requirement until it does.
#ifndef TRACKSERVO_SIM_DESIGN_DESIGN_CHECK_HPP
#define TRACKSERVO_SIM_DESIGN_DESIGN_CHECK_HPP

#include <functional>
#include <string>
#include <vector>

#include "design/loop_margins.hpp"

namespace trackservo::sim {

// Throws ConfigError when the speed loop of an axis is unstable, sliding or in pre-sliding. About 1 ms. `is_possible`:
// whether a controller can be designed for another plant's axis; with it the error names numbers of the machine too.
void refuse_unstable_loops(const PlantConfig& plant, const servo_params& params,
                           const std::function<bool(const PlantConfig& plant, int axis)>& is_possible = {});

// Returns one line for each axis whose margins are too small; none when all are sufficient.
std::vector<std::string> margin_warnings(const PlantConfig& plant, const servo_params& params);

}  // namespace trackservo::sim

#endif
