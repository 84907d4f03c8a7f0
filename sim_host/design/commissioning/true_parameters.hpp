// SPDX-License-Identifier: Apache-2.0
// The true parameters of a simulated axis, as identification names them.
#ifndef TRACKSERVO_SIM_COMMISSIONING_TRUE_PARAMETERS_HPP
#define TRACKSERVO_SIM_COMMISSIONING_TRUE_PARAMETERS_HPP

#include <map>
#include <string>

#include "identification/position_terms.hpp"
#include "machine/config/plant_config.hpp"

namespace trackservo::sim {

// Returns the true parameters; friction levels are the mean over the recorded travel. With an eccentric seal nothing
// more can be known; over a whole turn it is the number of the plant file.
std::map<std::string, double> true_parameters(const PlantConfig& plant, int axis, double pitch_rad,
                                              const identification::PositionTerms& travel);

}  // namespace trackservo::sim

#endif
