// SPDX-License-Identifier: Apache-2.0
// Does any monitor of the device trip on a machine that is in order? Random plants with the gains, motor data and
// limits of the nominal one do everything that a user does with a machine: operation, the motions of the paper's
// experiments, identification and tuning. A fault in the log of the device is a false trip.
#ifndef TRACKSERVO_SIM_STUDIES_RANDOM_PLANTS_MONITORED_PLANTS_HPP
#define TRACKSERVO_SIM_STUDIES_RANDOM_PLANTS_MONITORED_PLANTS_HPP

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "machine/base/job_pool.hpp"
#include "studies/shared/campaign_options.hpp"
#include "studies/shared/study.hpp"

namespace trackservo::sim {

struct MonitoredPlantsSetup {
  PlantConfig nominal;
  std::vector<ScenarioConfig> scenarios;  // of the paper's experiments
  double share = 0.3;                     // largest deviation of each number
  int count = 1000;
  std::uint64_t seed = 1;  // of the first plant
  int threads = usable_threads();
};

struct MonitoredPlants {
  int plants = 0;
  double hours = 0;                      // simulated
  int experiments = 0;                   // of identification and tuning, completed
  std::vector<std::string> false_trips;  // plant, what it did, fault
  std::vector<std::string> broken_off;   // experiments that ended early without a fault, and gains that were refused
};

// Returns the scenarios of the paper's experiments, each once. Throws like load_experiments.
std::vector<ScenarioConfig> scenarios_of_experiments(const std::filesystem::path& data_dir);

// Monitors one plant. Equal seeds give equal runs.
MonitoredPlants monitor_plant(const MonitoredPlantsSetup& setup, std::uint64_t seed);

MonitoredPlants monitor_plants(const MonitoredPlantsSetup& setup, const Progress& progress);

std::string print(const MonitoredPlants& all);

}  // namespace trackservo::sim

#endif
