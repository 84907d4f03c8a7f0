// The node's parameters for a plant: the gains of the experiments, as the values of the object dictionary.
#ifndef TRACKSERVO_SIM_SERVE_NODE_PARAMETERS_HPP
#define TRACKSERVO_SIM_SERVE_NODE_PARAMETERS_HPP

#include "config/plant_config.hpp"

extern "C" {
#include "hal.h"
#include "parameters/axis_parameters.h"
#include "protection/axis_protection.h"
}

namespace trackservo::sim {

// The design of PI + VOB + FTC for this axis, with friction parameters 15 % wrong as in the experiments (seed 1).
axis_parameters node_parameters(const PlantConfig& plant, int axis);

// The limits that protect this axis (0x2060), from the plant file's sensors, motor, supply and end stops.
protection_limits node_limits(const PlantConfig& plant, int axis);

// The scales of the machine's converters (0x3060): [adc] of the plant file.
hal_scales node_scales(const PlantConfig& plant);

}  // namespace trackservo::sim

#endif
