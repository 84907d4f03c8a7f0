// A machine as the next one off the line would be: every number of the plant off by up to a share of itself.
//
// Numbers are known by their keys of the plant file. What a key has no tolerance for keeps its value: counts (bits,
// harmonics, readings), ranges that are chosen (converters, end stops, the gyro's), and what belongs to the controller
// (its wishes, the drive's current limit). Torque and back-EMF constant share a factor: they are one flux. Angles at
// which a pattern begins are drawn from the whole turn. A number that is 0 stays 0.
#ifndef TRACKSERVO_SIM_STUDIES_RANDOM_PLANT_HPP
#define TRACKSERVO_SIM_STUDIES_RANDOM_PLANT_HPP

#include <cstdint>
#include <string>
#include <vector>

#include "config/plant_config.hpp"

namespace trackservo::sim {

// "azimuth.motor.resistance_ohm", and what it was multiplied by.
struct Deviation {
  std::string key;
  double factor = 1;
};

struct RandomPlant {
  PlantConfig config;
  std::vector<Deviation> deviations;  // the same keys in the same order for every plant of one nominal
};

// Factors are uniform in 1 - `share` .. 1 + `share`; `share` is in 0 .. 0.9. Break-away torque is raised to Coulomb's
// where it would fall below.
RandomPlant random_plant(const PlantConfig& nominal, double share, std::uint64_t seed);

// Keys that keep their values although they are numbers, without the axis: "motor.current_limit_a".
const std::vector<std::string>& kept_keys();

}  // namespace trackservo::sim

#endif
