// SPDX-License-Identifier: Apache-2.0
// Fault injections: how each is made in the simulation, and how the firmware must react.
#ifndef TRACKSERVO_SIM_FAULT_INJECTION_FAULT_INJECTION_HPP
#define TRACKSERVO_SIM_FAULT_INJECTION_FAULT_INJECTION_HPP

#include <functional>
#include <string>
#include <vector>

#include "device/driven_node.hpp"
#include "machine/base/random.hpp"

namespace trackservo::sim {

// Whether the firmware meets every requirement of an injection in every run. A test fails when this changes.
enum class Detection {
  kAlways,
  kTolerated,  // it need not be detected, because the axis follows its set-point: max_deviation_rad
  kNotAlways   // in at least one run of the matrix it is not detected, or not as required
};

struct FaultInjection {
  std::string name;
  fault_id expected;
  // Faults that may be detected first, because they look the same; the reaction is then theirs.
  fault_set also;
  // Timers of 0x2060 or of the bus, added to the latency of the table [ms].
  int timer_ms;
  bool both_axes;
  std::function<void(DrivenNode&, int axis, SplitMix64& random)> begin;
  // Whether the fault can be detected yet: a gyro of the wrong sign reads the same at standstill. The latency counts
  // from then.
  std::function<bool(DrivenNode&, int axis)> shows;
  // When the fault is detected: remove the external torque.
  std::function<void(DrivenNode&, int axis)> end;
  // Mode of operation (6060): a position error is monitored only while the position is controlled.
  std::int8_t mode = DRIVE_CYCLIC_VELOCITY;
  // Before the axes move: limits and timers set so that the fault can be detected.
  std::function<void(DrivenNode&, int axis)> prepare = [](DrivenNode&, int) {};
  // Every tick until the injection: actions that stop then.
  std::function<void(DrivenNode&, int axis)> keep_up = [](DrivenNode&, int) {};
  // The firmware's timer restarts when the fault is not visible for a tick, and so does the latency.
  bool lasting = false;
  // The fault leaves the loops too little torque to hold against wind.
  bool weak = false;
  // Why the fault cannot be detected in some motion.
  std::string hidden_because{};
  Detection detection = Detection::kAlways;
  // Instead of the latencies of the table and `timer_ms` [ms]; 0: those.
  int allowed_ms = 0;
  // Any fault may be detected.
  bool any_fault = false;
  // The axis stays at rest when it stood still: the fault must be detected without motion.
  bool stays = false;
  // Only a restart ends the fault, or the fault has damaged the memory. The next fault of the run follows the restart.
  bool needs_restart = false;
  // Time until the run ends without a detection [ticks].
  int monitored_ticks = 1500;
  // Allowed distance of the joint from where its set-point led it, from the injection to the detection [rad].
  double max_deviation_rad = 10.0;
  // Allowed increase of the joint's speed [rad/s], also without a detection; 0: that of its expected fault.
  double max_overshoot_rad_s = 0;
  // From the injection on, the axis reverses at this speed once a second [rad/s]; 0: it goes on with its motion.
  double excitation_rad_s = 0;
  // The protective stop that this fault starts is what fails: `expected` comes during the reaction to it.
  fault_id during = FAULT_NONE;
  // Every tick from the injection to the detection.
  std::function<void(DrivenNode&, int axis)> go_on = [](DrivenNode&, int) {};
};

const std::vector<FaultInjection>& fault_injections();

// Returns the faults that are visible at once in every motion and end with their cause: a second or third one in a run.
const std::vector<const FaultInjection *>& later_fault_injections();

// Throws std::invalid_argument that lists the names.
const FaultInjection& fault_injection(const std::string& name);

// Returns the faults that may be detected: the expected one and `also`.
inline fault_set right_faults(const FaultInjection& fault_injection) {
  return fault_bit(fault_injection.expected) | fault_injection.also;
}

// Returns the latency that the table and the timers allow [ms].
int allowed_latency_ms(const FaultInjection& fault_injection);

}  // namespace trackservo::sim

#endif
