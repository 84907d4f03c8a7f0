// What can break, how it is broken in the simulation, and what the firmware must make of it.
#ifndef TRACKSERVO_SIM_FAULT_INJECTION_BREAKAGE_HPP
#define TRACKSERVO_SIM_FAULT_INJECTION_BREAKAGE_HPP

#include <functional>
#include <string>
#include <vector>

#include "base/random.hpp"
#include "fault_injection/driven_node.hpp"

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
  // Mode of operation (6060): who watches a position error must control the position.
  std::int8_t mode = DRIVE_CYCLIC_VELOCITY;
  // Before the axes move: limits and timers as somebody would set them who wants this to be seen.
  std::function<void(DrivenNode&, int axis)> prepare = [](DrivenNode&, int) {};
  // Every tick until it breaks: what stops then.
  std::function<void(DrivenNode&, int axis)> keep_up = [](DrivenNode&, int) {};
  // The firmware's timer begins anew when there is nothing to be seen for a tick, and so does the latency.
  bool lasting = false;
  // What is broken leaves the loops too little torque to hold against wind.
  bool weak = false;
  // Why there is nothing to be seen in some motion.
  std::string hidden_because{};
};

const std::vector<Breakage>& breakages();

// Throws std::invalid_argument that lists the names.
const Breakage& breakage(const std::string& name);

// Latency that the table and the timers allow [ms].
int allowed_latency_ms(const Breakage& breakage);

}  // namespace trackservo::sim

#endif
