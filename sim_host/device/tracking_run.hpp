// SPDX-License-Identifier: Apache-2.0
// Runs a scenario with a target on the whole node: frames of the camera arrive as PDOs, and the axes that take part are
// in mode -1.
#ifndef TRACKSERVO_SIM_DEVICE_TRACKING_RUN_HPP
#define TRACKSERVO_SIM_DEVICE_TRACKING_RUN_HPP

#include <cstdint>

#include "device/node_setup.hpp"
#include "machine/config/scenario_config.hpp"
#include "machine/run/trace.hpp"

namespace trackservo::sim {

// Returns a row for each ms of the target's course, from its beginning. Throws std::runtime_error when the axes cannot
// be enabled.
Trace run_tracking(const NodeSetup& setup, const ScenarioConfig& scenario, std::uint64_t seed);

}  // namespace trackservo::sim

#endif
