// SPDX-License-Identifier: Apache-2.0
// The result of an error-free identification of a simulated axis.
#ifndef TRACKSERVO_SIM_DESIGN_TRUE_PLANT_HPP
#define TRACKSERVO_SIM_DESIGN_TRUE_PLANT_HPP

#include "gain_design/identified_plant.hpp"
#include "machine/config/plant_config.hpp"

namespace trackservo::sim {

// Returns the axis at pitch 0, with friction levels without eccentricity, the sensors' noise per tick, and the gusts of
// the wind as the disturbance.
gain_design::IdentifiedPlant true_plant(const PlantConfig& plant, int axis);

}  // namespace trackservo::sim

#endif
