// What can break, how it is broken in the simulation, and what the firmware must make of it.
#ifndef TRACKSERVO_SIM_FAULTS_BREAKAGE_HPP
#define TRACKSERVO_SIM_FAULTS_BREAKAGE_HPP

#include <functional>
#include <string>
#include <vector>

#include "faults/driven_node.hpp"
#include "random.hpp"

namespace trackservo::sim {

struct Breakage {
  std::string name;
  fault_id expected;
  // Others that may be seen first, because the same breakage looks like them, too; the reaction is then theirs.
  fault_set also;
  // Timers of 0x2060 or of the bus, on top of the table's latency [ms].
  int timer_ms;
  bool both_axes;
  std::function<void(DrivenNode&, int axis, SplitMix64& random)> begin;
  // Whether there is anything to be seen yet: a gyro of the wrong sign says the same at standstill. The latency counts
  // from then.
  std::function<bool(DrivenNode&, int axis)> shows;
  // When the fault is seen: what pushed from outside lets go.
  std::function<void(DrivenNode&, int axis)> end;
};

const std::vector<Breakage>& breakages();

// Throws std::invalid_argument that lists the names.
const Breakage& breakage(const std::string& name);

// Latency that the table and the timers allow [ms].
int allowed_latency_ms(const Breakage& breakage);

}  // namespace trackservo::sim

#endif
