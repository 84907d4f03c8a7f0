// SPDX-License-Identifier: Apache-2.0
// The result of an error-free identification of a simulated axis.
#ifndef TRACKSERVO_SIM_DESIGN_TRUE_PLANT_HPP
#define TRACKSERVO_SIM_DESIGN_TRUE_PLANT_HPP

#include "config/plant_config.hpp"
#include "gain_design/identified_plant.hpp"

namespace trackservo::sim {

// At pitch 0, friction levels without eccentricity, sensors' noise per tick.
gain_design::IdentifiedPlant true_plant(const PlantConfig& plant, int axis);

}  // namespace trackservo::sim

#endif
