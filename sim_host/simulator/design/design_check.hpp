// Are the wishes of a plant file good for the machine? Refuses loops that would shake, and warns of those near to it.
//
// Unstable is an error, because no result of such a loop means anything. Stable with less than 6 dB or 40 degrees is a
// warning: a user may want to see just that. Both name the file's line, what was found, and a value that keeps the
// margins, found by lowering the wish until it does.
#ifndef TRACKSERVO_SIM_DESIGN_DESIGN_CHECK_HPP
#define TRACKSERVO_SIM_DESIGN_DESIGN_CHECK_HPP

#include <functional>
#include <string>
#include <vector>

#include "design/loop_margins.hpp"

namespace trackservo::sim {

// Throws ConfigError when the speed loop of an axis is unstable, sliding or in pre-sliding. About 1 ms. `is_possible`:
// whether a controller can be designed for another plant's axis; with it the error names numbers of the machine, too.
void refuse_unstable_loops(const PlantConfig& plant, const servo_params& params,
                           const std::function<bool(const PlantConfig& plant, int axis)>& is_possible = {});

// One line for each axis whose margins are less than they should be; none when all is well.
std::vector<std::string> margin_warnings(const PlantConfig& plant, const servo_params& params);

}  // namespace trackservo::sim

#endif
