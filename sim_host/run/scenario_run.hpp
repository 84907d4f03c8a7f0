// Runs one case of a scenario on a machine with given firmware parameters.
#ifndef TRACKSERVO_SIM_RUN_SCENARIO_RUN_HPP
#define TRACKSERVO_SIM_RUN_SCENARIO_RUN_HPP

#include <cstdint>
#include <string>

#include "config/plant_config.hpp"
#include "config/scenario_config.hpp"
#include "run/trace.hpp"

namespace trackservo::sim {

struct RunRequest {
  const PlantConfig *plant = nullptr;
  const ScenarioConfig *scenario = nullptr;
  double speed_rad_s = 0;  // the case: sine amplitude or step; not used for tracking
  servo_params params{};
  std::uint64_t seed = 1;
};

// The whole run, 1 row per ms. Throws std::invalid_argument when the firmware refuses the parameters.
Trace run_scenario(const RunRequest& request);

}  // namespace trackservo::sim

#endif
