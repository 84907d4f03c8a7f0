// SPDX-License-Identifier: Apache-2.0
#include "device/tracking_run.hpp"

#include <cmath>

#include "device/tracking_node.hpp"
#include "machine/run/scenario_run.hpp"

namespace trackservo::sim {
namespace {

Trace fly(const NodeSetup& setup, const ScenarioConfig& scenario, std::uint64_t seed) {
  TrackingNode tracking(setup, scenario, seed);
  const int ticks = static_cast<int>(std::lround(scenario.duration_s / kTick_s));
  Trace trace;
  trace.reserve(static_cast<std::size_t>(ticks));
  for (int tick = 0; tick < ticks; ++tick) {
    const TruthState truth = tracking.truth();
    const std::array<double, kAxes> error_rad = tracking.error_rad();
    tracking.tick();
    trace.push_back(trace_row(tick * kTick_s, truth, tracking.node().machine(), error_rad));
  }
  return trace;
}

}  // namespace

Trace run_tracking(const NodeSetup& setup, const ScenarioConfig& scenario, std::uint64_t seed) {
  Trace trace;
  for (const ScenarioConfig& run : runs_of(scenario)) {
    add_run(trace, run, fly(setup, run, seed));
  }
  return trace;
}

}  // namespace trackservo::sim
