// Hours of work with all noise and wind, in which nothing breaks: no fault may be found.
#ifndef TRACKSERVO_SIM_FAULT_INJECTION_SOAK_HPP
#define TRACKSERVO_SIM_FAULT_INJECTION_SOAK_HPP

#include <string>
#include <vector>

#include "fault_injection/driven_node.hpp"

namespace trackservo::sim {

struct SoakResult {
  double hours = 0;
  std::vector<std::string> false_trips;  // what was found, where and when
  // The nearest that a smoothed signal came to its limit, as a share of it, of both axes.
  double most_disagreement = 0;
  int most_mismatch_ticks = 0;
  double most_heating = 0;
};

// Hours of shifts of ten minutes, each with another seed, `threads` at a time: random way points in profile position,
// random speeds in profile velocity with reversals, standstill, fly-bys in cyclic velocity, and fault-free switching
// off and on.
SoakResult run_soak(const PlantConfig& plant, double hours, std::uint64_t seed, int threads);

std::string print_soak(const SoakResult& result);

}  // namespace trackservo::sim

#endif
