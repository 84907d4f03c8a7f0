// SPDX-License-Identifier: Apache-2.0
// Did the axes of a run follow their commands? A run of a machine that its motor cannot turn, or whose sensors give no
// signal, has figures like any other. They are meaningless, and a script must be able to detect this.
//
// An axis counts as not controlled in these cases: a number is not finite, it turns faster than the over-speed limit of
// a served machine, its rms error is more than half of its set-point, a start never arrives, or the target leaves the
// camera's image. The sentence names the number of the plant file with the largest demand on motor or sensors, by how
// much it is too large, and a value that would work.
#ifndef TRACKSERVO_SIM_ANALYSIS_VERDICT_HPP
#define TRACKSERVO_SIM_ANALYSIS_VERDICT_HPP

#include <string>
#include <vector>

#include "machine/config/plant_config.hpp"
#include "machine/config/scenario_config.hpp"
#include "machine/run/trace.hpp"

namespace trackservo::sim {

// Returns one sentence for each axis that was not controlled, in the form of errors; none for a good run. An axis that
// only suffers from the other one is left out.
std::vector<std::string> uncontrolled_axes(const PlantConfig& plant, const ScenarioConfig& scenario, double speed_rad_s,
                                           const Trace& trace);

}  // namespace trackservo::sim

#endif
