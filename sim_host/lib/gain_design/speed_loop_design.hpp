// SPDX-License-Identifier: Apache-2.0
// PI, observer and filters of the speed loop: the filters that allow the fastest loop, and the pair found with them.
#ifndef TRACKSERVO_GAIN_DESIGN_SPEED_LOOP_DESIGN_HPP
#define TRACKSERVO_GAIN_DESIGN_SPEED_LOOP_DESIGN_HPP

#include <string>
#include <vector>

#include "gain_design/gain_design.hpp"
#include "gain_design/speed_loop_search.hpp"

namespace trackservo::gain_design {

// Writes PI, observer bandwidth and filters into `parameters`, whose other members must be complete, and reports in
// `notes` what was lowered or chosen. Throws GainDesignError.
void design_speed_loop(const IdentifiedPlant& plant, const GainRequirements& requirements,
                       const SpeedLoopDemand& demand, axis_parameters& parameters, std::vector<std::string>& notes);

// Returns the device's filters and loops for the parameters. Throws GainDesignError when the firmware refuses them.
servo_axis_params built(const axis_parameters& parameters);

}  // namespace trackservo::gain_design

#endif
