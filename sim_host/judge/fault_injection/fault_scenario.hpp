// SPDX-License-Identifier: Apache-2.0
// A file with a schedule of fault injections, and a run of it.
//
//   motion = "20 deg/s"        # standstill, 1 deg/s, 20 deg/s, reversal or tracking; both axes
//   duration_s = 3.0
//   seed = 1
//   [[breakage]]
//   part = "encoder lost"      # `sim_host faults --list` names them
//   axis = "pitch"
//   at_s = 1.2
#ifndef TRACKSERVO_SIM_FAULT_INJECTION_FAULT_SCENARIO_HPP
#define TRACKSERVO_SIM_FAULT_INJECTION_FAULT_SCENARIO_HPP

#include <filesystem>
#include <string>
#include <vector>

#include "judge/fault_injection/fault_injection.hpp"
#include "judge/fault_injection/motion.hpp"

namespace trackservo::sim {

struct PlannedFaultInjection {
  int part = 0;  // in breakages()
  int axis = 0;
  double at_s = 0;
};

struct FaultScenario {
  int motion = 0;  // in kMotions
  double duration_s = 0;
  int seed = 1;
  std::vector<PlannedFaultInjection> fault_injections;
};

// Throws ConfigError with file, line, key, reason and remedy.
FaultScenario load_fault_scenario(const std::filesystem::path& path);

// Returns the events of the run, one line each.
std::string run_fault_scenario(const PlantConfig& plant, const FaultScenario& scenario);

}  // namespace trackservo::sim

#endif
