// Does a scenario make sense on a plant? What each file alone cannot tell: travel, torque, speed, course of the target.
//
// What makes a run meaningless is refused at the line of the key; what makes it unusual (the motor too weak, the end
// stop reached on the way) is a warning, because somebody may want to see just that. Use once before the runs of a
// scenario.
#ifndef TRACKSERVO_SIM_RUN_SCENARIO_CHECK_HPP
#define TRACKSERVO_SIM_RUN_SCENARIO_CHECK_HPP

#include <string>
#include <vector>

#include "config/plant_config.hpp"
#include "config/scenario_config.hpp"

namespace trackservo::sim {

// Throws ConfigError; returns the warnings, a line each as errors are written.
std::vector<std::string> check_scenario(const PlantConfig& plant, const ScenarioConfig& scenario);

// The torque that an axis can give at standstill, at the drive's limit or the supply's [Nm].
double available_torque_nm(const PlantConfig& plant, int axis);

}  // namespace trackservo::sim

#endif
