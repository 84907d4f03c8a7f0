// SPDX-License-Identifier: Apache-2.0
// Random gains that are in range and unstable: the device refuses them, and takes them back when they were applied in
// spite of that.
#ifndef TRACKSERVO_SIM_FAULT_INJECTION_SHAKING_GAINS_HPP
#define TRACKSERVO_SIM_FAULT_INJECTION_SHAKING_GAINS_HPP

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "device/driven_node.hpp"
#include "machine/base/random.hpp"

namespace trackservo::sim {

// Limits of a run; the travel is that of an axis in motion.
constexpr double kVisibleShaking_deg_s = 1.0;
constexpr double kLongestShaking_s = 0.5;
constexpr double kShakingAtRest_deg_s = 3.0;
constexpr double kShakingMoving_deg_s = 25.0;
constexpr double kShakingTravel_deg = 2.0;

// Returns `good` with some values replaced by any of their range.
axis_parameters random_gains(const axis_parameters& good, SplitMix64& random);

struct ShakingRun {
  loop_verdict verdict = LOOP_RUNNING;  // of the device, before the gains were applied in spite of it
  bool taken_back = false;
  fault_id fault = FAULT_NONE;
  double visible_s = -1.0;   // from the gains until the rate error exceeds kVisibleShaking_deg_s; -1: never
  double caught_s = -1.0;    // from the gains until they were taken back, or the fault
  double peak_deg_s = 0.0;   // of the rate error
  double travel_deg = 0.0;   // that the rate error makes
  double after_deg_s = 0.0;  // largest rate error in the last half second
  double swing_deg_s = 0.0;  // the same, from peak to peak

  bool shakes() const { return taken_back || fault != FAULT_NONE || visible_s >= 0.0; }
  // Returns the time from the first visible motion until the gains were taken back.
  double seen_for_s() const;
};

// Runs two seconds with the good gains at this rate, then up to eight with the others, as if a client had overridden
// the check. A fast axis has less time, because its path must fit into the travel.
ShakingRun shake(const NodeSetup& setup, int axis, const axis_parameters& gains, double rate_deg_s, std::uint64_t seed);

// Returns what a run that shakes violates; empty: nothing.
std::string shaking_problem(const ShakingRun& run, double rate_deg_s);

struct ShakingOptions {
  int sets = 500;  // that shake, alternately of azimuth and pitch
  std::uint64_t seed = 1;
  int threads = 1;
};

// The runs of one axis, at rest or moving.
struct ShakingRow {
  int axis = 0;
  bool moving = false;
  int runs = 0;
  int refused = 0;
  int shook = 0;
  int caught = 0;  // in time, within the limits
  double longest_s = 0.0;
  double longest_from_gains_s = 0.0;
  double peak_deg_s = 0.0;
  double travel_deg = 0.0;
  double calm_deg_s = 0.0;  // largest swing of a run that does not shake, in its last half second
};

struct ShakingGains {
  int sets = 0;        // that shake, at rest or moving
  int quiet_sets = 0;  // unstable, but in neither motion beyond kVisibleShaking_deg_s
  std::vector<ShakingRow> rows;
  std::vector<std::string> errors;  // a run that is not refused, or not caught as required
};

ShakingGains run_shaking_gains(const PlantConfig& plant, const ShakingOptions& options,
                               std::function<void(int, int, const std::string&)> progress);

std::string print(const ShakingGains& result);

}  // namespace trackservo::sim

#endif
