// SPDX-License-Identifier: Apache-2.0
// Hours of operation with all noise and wind and without fault injection: no fault may be detected.
#ifndef TRACKSERVO_SIM_FAULT_INJECTION_SOAK_HPP
#define TRACKSERVO_SIM_FAULT_INJECTION_SOAK_HPP

#include <string>
#include <vector>

#include "device/driven_node.hpp"

namespace trackservo::sim {

struct SoakResult {
  double hours = 0;
  std::vector<std::string> false_trips;  // detected faults, with place and time
  // The closest approach of a smoothed signal to its limit, as a share of it, of both axes.
  double max_disagreement = 0;
  int max_mismatch_ticks = 0;
  double max_heating = 0;
};

// Runs one segment: `tasks` of ten seconds each.
SoakResult run_shift(const NodeSetup& setup, std::uint64_t seed, int tasks);

// Runs hours of segments of ten minutes, each with another seed, `threads` at a time: random way points in profile
// position, random speeds in profile velocity with reversals, standstill, fly-bys in cyclic velocity, and switching off
// and on without a fault.
SoakResult run_soak(const PlantConfig& plant, double hours, std::uint64_t seed, int threads);

std::string print_soak(const SoakResult& result);

}  // namespace trackservo::sim

#endif
