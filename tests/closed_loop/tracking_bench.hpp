// SPDX-License-Identifier: Apache-2.0
// The tracker and the paper's fly-by, for tests of tracking in the running node (device/tracking_node.hpp).
#ifndef TRACKSERVO_TESTS_CLOSED_LOOP_TRACKING_BENCH_HPP
#define TRACKSERVO_TESTS_CLOSED_LOOP_TRACKING_BENCH_HPP

#include "device/tracking_node.hpp"
#include "judge/analysis/error_spread.hpp"

namespace bench {

namespace sim = trackservo::sim;

using sim::TrackingNode;
using Spread = sim::ErrorSpread;

inline const sim::NodeSetup& tracker_setup() {
  static const sim::NodeSetup tracker(sim::load_plant("sim_host/plants/tracker.toml"));
  return tracker;
}

inline sim::ScenarioConfig tracking_scenario() { return sim::load_scenario("sim_host/scenarios/tracking.toml"); }

// Of the default design, with this loop.
inline target_tracker_params designed_tracker(tracker_kind kind) {
  return sim::designed_tracking_loop(tracker_setup().plant, kind);
}

}  // namespace bench

#endif
