// Did the axes of a run do what they were told to? A run of a machine that its motor cannot turn, or whose sensors say
// nothing, has figures like any other; they mean nothing, and a script must learn so.
//
// An axis counts as not controlled when a number is not finite, when it turns faster than the over-speed limit that a
// served machine has, when its rms error is more than half of its set-point, when a start never arrives, or when the
// target leaves the camera's image. The sentence names the number of the plant file that asks most of motor or sensors,
// by how much, and what would be right.
#ifndef TRACKSERVO_SIM_ANALYSIS_VERDICT_HPP
#define TRACKSERVO_SIM_ANALYSIS_VERDICT_HPP

#include <string>
#include <vector>

#include "config/plant_config.hpp"
#include "config/scenario_config.hpp"
#include "run/trace.hpp"

namespace trackservo::sim {

// One sentence for each axis that was not controlled, as errors are written; none for a good run. An axis that only
// suffers from what the other one does is left out.
std::vector<std::string> uncontrolled_axes(const PlantConfig& plant, const ScenarioConfig& scenario, double speed_rad_s,
                                           const Trace& trace);

}  // namespace trackservo::sim

#endif
