// SPDX-License-Identifier: Apache-2.0
// Demands of a plant's numbers on its motor and its sensors, each by itself: the largest demand is the first suspect
// when an axis cannot be controlled.
#ifndef TRACKSERVO_SIM_RUN_DEMAND_HPP
#define TRACKSERVO_SIM_RUN_DEMAND_HPP

#include <string>
#include <vector>

#include "machine/config/plant_config.hpp"
#include "machine/config/scenario_config.hpp"

namespace trackservo::sim {

// A number of the plant file and its effect on the axis, as a share of what the axis can bear: above 1 it is too much.
struct Demand {
  std::string key;     // dotted
  std::string reason;  // with the number's value
  std::string remedy;
  double share;
};

// Returns all demands on an axis at a set-point of this size [rad/s], the largest first.
std::vector<Demand> demands_on(const PlantConfig& plant, const ScenarioConfig& scenario, int axis,
                               double reference_rad_s);

}  // namespace trackservo::sim

#endif
