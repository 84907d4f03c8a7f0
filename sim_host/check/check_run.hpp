// SPDX-License-Identifier: Apache-2.0
// The runs of a check: every scenario, case and seed, and the margins of the speed loops.
//
// Speed scenarios are driven through the whole device (node, drive, protection, servo core). Tracking, which no CiA 402
// mode supports, runs on the servo core, as do the measured margins; both use the gains of the device.
#ifndef TRACKSERVO_SIM_CHECK_CHECK_RUN_HPP
#define TRACKSERVO_SIM_CHECK_CHECK_RUN_HPP

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "check/checked_device.hpp"
#include "check/figure.hpp"
#include "check/gains_file.hpp"
#include "machine/config/scenario_config.hpp"

namespace trackservo::sim {

constexpr const char *kLoopScenario = "loop";  // as margins are named

struct CheckPlan {
  PlantConfig plant;
  Gains gains;
  std::vector<ScenarioConfig> scenarios;
  std::vector<std::uint64_t> seeds;
  int threads = 2;
  bool only_device = false;  // an image: no tracking, no margins, no disturbing torque
  DeviceMaker make_device;
};

// Throws ConfigError for a scenario that cannot run like this, or gains that are refused.
void refuse_impossible(const CheckPlan& plan);

// Returns the figures of run_check, in its order, without values. Throws like apply_gains.
std::vector<CheckFigure> figures_of(const CheckPlan& plan);

// Throws like apply_gains.
std::vector<CheckFigure> run_check(const CheckPlan& plan,
                                   const std::function<void(int, int, const std::string&)>& progress);

}  // namespace trackservo::sim

#endif
