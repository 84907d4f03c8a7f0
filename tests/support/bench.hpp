// SPDX-License-Identifier: Apache-2.0
// Plants for the tests of the simulated machine: the shipped tracker with everything switched off that a test does not
// need.
#ifndef TRACKSERVO_TESTS_SUPPORT_BENCH_HPP
#define TRACKSERVO_TESTS_SUPPORT_BENCH_HPP

#include <string>

#include "machine/config/plant_config.hpp"
#include "machine/config/scenario_config.hpp"

#ifndef TRACKSERVO_SOURCE_DIR
#define TRACKSERVO_SOURCE_DIR "."
#endif

namespace bench {

using namespace trackservo::sim;

inline PlantConfig shipped_plant(const std::string& name) {
  return load_plant(std::string(TRACKSERVO_SOURCE_DIR) + "/sim_host/plants/" + name + ".toml");
}

inline ScenarioConfig shipped_scenario(const std::string& name) {
  return load_scenario(std::string(TRACKSERVO_SOURCE_DIR) + "/sim_host/scenarios/" + name + ".toml");
}

// The tracker's masses and motors alone: no friction, loads, ripple, sway, noise or stops; perfect sensors.
inline PlantConfig bare_plant() {
  PlantConfig plant = shipped_plant("tracker");
  plant.friction_model = FrictionModel::kNone;
  plant.supply.source_resistance_ohm = 0.0;
  plant.adc = AdcConfig{24, 25.0, 0.0, 0.0, 66.0, 0.0};
  plant.base_tilt = BaseTiltConfig{};
  for (AxisConfig& axis : plant.axis) {
    axis.motor.ripple.clear();
    axis.motor.cogging.clear();
    axis.load = LoadConfig{};
    axis.end_stops.reset();
    axis.base_sway = BaseSwayConfig{};
    axis.encoder = EncoderConfig{};
    axis.gyro = GyroConfig{};
    axis.friction.eccentricity_once = 0.0;
    axis.friction.eccentricity_twice = 0.0;
  }
  return plant;
}

}  // namespace bench

#endif
