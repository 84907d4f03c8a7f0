// SPDX-License-Identifier: Apache-2.0
// A machine as manufactured: every number of the plant deviates by up to a share of itself.
//
// Numbers are identified by their keys of the plant file. A key without a tolerance keeps its value: counts (bits,
// harmonics, readings), chosen ranges (converters, end stops, the gyro's), and properties of the controller (its
// requirements, the drive's current limit). Torque constant and back-EMF constant share a factor: they have the same
// flux. Start angles of periodic patterns are drawn from the whole turn. A number that is 0 stays 0.
#ifndef TRACKSERVO_SIM_STUDIES_RANDOM_PLANTS_RANDOM_PLANT_HPP
#define TRACKSERVO_SIM_STUDIES_RANDOM_PLANTS_RANDOM_PLANT_HPP

#include <cstdint>
#include <string>
#include <vector>

#include "machine/config/plant_config.hpp"

namespace trackservo::sim {

// "azimuth.motor.resistance_ohm", and its factor.
struct Deviation {
  std::string key;
  double factor = 1;
};

struct RandomPlant {
  PlantConfig config;
  std::vector<Deviation> deviations;  // the same keys in the same order for every plant of one nominal
};

// Returns a plant with factors that are uniform in 1 - `share` .. 1 + `share`; `share` is in 0 .. 0.9. Break-away
// torque is raised to Coulomb torque where it would fall below.
RandomPlant random_plant(const PlantConfig& nominal, double share, std::uint64_t seed);

// Returns the numeric keys that keep their values, without the axis: "motor.current_limit_a". They are ranges of
// sensors, ends of the travel, and parts of the supply that the machine may lack.
const std::vector<std::string>& retained_keys();

}  // namespace trackservo::sim

#endif
