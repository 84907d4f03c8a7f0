// SPDX-License-Identifier: Apache-2.0
// Does a scenario make sense on a plant? Checks that need both files: travel, torque, speed, course of the target.
//
// A meaningless run is refused at the line of the key. An unusual one (the motor too weak, the end stop in the path) is
// a warning, because a user may want to study exactly that. Use once before the runs of a scenario.
#ifndef TRACKSERVO_SIM_RUN_SCENARIO_CHECK_HPP
#define TRACKSERVO_SIM_RUN_SCENARIO_CHECK_HPP

#include <optional>
#include <string>
#include <vector>

#include "machine/config/plant_config.hpp"
#include "machine/config/scenario_config.hpp"

namespace trackservo::sim {

// Throws ConfigError; returns the warnings, one line each in the form of errors.
std::vector<std::string> check_scenario(const PlantConfig& plant, const ScenarioConfig& scenario);

// Returns why an axis cannot start at this joint angle, without a full stop; nothing if it can.
std::optional<std::string> start_problem(const PlantConfig& plant, int axis, double angle_rad);

// Returns the torque that an axis can give at standstill, at the drive's limit or the supply's [Nm].
double available_torque_nm(const PlantConfig& plant, int axis);

}  // namespace trackservo::sim

#endif
