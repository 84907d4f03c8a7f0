// SPDX-License-Identifier: Apache-2.0
// What a node starts with: parameters, limits and scales, from a plant or as the product is delivered.
#ifndef TRACKSERVO_SIM_DEVICE_NODE_SETUP_HPP
#define TRACKSERVO_SIM_DEVICE_NODE_SETUP_HPP

#include <array>
#include <optional>

#include "machine/config/plant_config.hpp"

extern "C" {
#include "hal.h"
#include "parameters/axis_parameters.h"
#include "protection/axis_protection.h"
}

namespace trackservo::sim {

// Returns the design of PI + VOB + FTC for this axis, with friction parameters 15 % wrong as in the experiments
// (seed 1).
axis_parameters node_parameters(const PlantConfig& plant, int axis);

// Returns the limits that protect this axis (0x2060), from the plant file's sensors, motor, supply and end stops.
protection_limits node_limits(const PlantConfig& plant, int axis);

// Returns the scales of the machine's converters (0x3060): [adc] of the plant file.
hal_scales node_scales(const PlantConfig& plant);

// The design of the parameters is expensive: make one setup for many nodes.
struct NodeSetup {
  // Describes the node of this plant.
  explicit NodeSetup(const PlantConfig& plant);

  // Does the same with given gains; the limits and the sensors' scales are the plant's.
  NodeSetup(const PlantConfig& of_plant, const std::array<axis_parameters, kAxes>& with_parameters);

  // Does the same with given gains and limits, independent of the plant; the sensors' scales are the plant's.
  NodeSetup(const PlantConfig& of_plant, const std::array<axis_parameters, kAxes>& with_parameters,
            const std::array<protection_limits, kAxes>& with_limits);

  PlantConfig plant;
  std::array<axis_parameters, kAxes> parameters;
  std::array<protection_limits, kAxes> limits;
  std::optional<hal_scales> scales;  // none: those of the product's board
};

// Returns gains and limits of firmware/products/brushed_tracker/default_parameters.c, whatever the plant is: gains
// designed anew for a plant would hide that it no longer fits.
NodeSetup product_setup(const PlantConfig& plant);

}  // namespace trackservo::sim

#endif
