// SPDX-License-Identifier: Apache-2.0
// Drives a device through one case of a speed scenario, and records the true motion of the machine.
#ifndef TRACKSERVO_SIM_CHECK_DRIVE_CASE_HPP
#define TRACKSERVO_SIM_CHECK_DRIVE_CASE_HPP

#include <optional>
#include <string>

#include "check/checked_device.hpp"
#include "check/gains_file.hpp"
#include "machine/config/scenario_config.hpp"
#include "machine/run/trace.hpp"

namespace trackservo::sim {

// One row per millisecond. Errors are relative to the set-point as sent, delayed by the protocol's delay.
struct DrivenCase {
  Trace trace;                         // empty after a failure: no figure of a failed run is meaningful
  std::optional<std::string> failure;  // "pitch: fault 7300h after 3.2 s"
};

// Throws like apply_gains.
DrivenCase drive_case(CheckedDevice& device, const PlantConfig& plant, const ScenarioConfig& scenario,
                      double speed_rad_s, const Gains& gains);

}  // namespace trackservo::sim

#endif
