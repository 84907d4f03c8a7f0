// The true parameters of a simulated axis, as identification names them.
#ifndef TRACKSERVO_SIM_COMMISSION_TRUE_PARAMETERS_HPP
#define TRACKSERVO_SIM_COMMISSION_TRUE_PARAMETERS_HPP

#include <map>
#include <string>

#include "config/plant_config.hpp"
#include "identification/position_terms.hpp"

namespace trackservo::sim {

// Friction levels are the mean over the travel that was recorded, which is all that can be known of a seal that does
// not run true; over a whole turn that is the plant file's number.
std::map<std::string, double> true_parameters(const PlantConfig& plant, int axis, double pitch_rad,
                                              const identification::PositionTerms& travel);

}  // namespace trackservo::sim

#endif
