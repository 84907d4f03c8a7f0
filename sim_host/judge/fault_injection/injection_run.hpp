// SPDX-License-Identifier: Apache-2.0
// One fault injection, once: in one motion, at one instant, on one axis of a machine with all its noise and wind.
#ifndef TRACKSERVO_SIM_FAULT_INJECTION_TRIAL_HPP
#define TRACKSERVO_SIM_FAULT_INJECTION_TRIAL_HPP

#include <memory>
#include <vector>

#include "judge/fault_injection/fault_injection.hpp"
#include "judge/fault_injection/motion.hpp"

namespace trackservo::sim {

struct InjectionRunSetup {
  const FaultInjection *fault_injection;
  Motion motion;
  int axis;
  std::uint64_t seed;  // of the machine's noise, of the instant, of the size of the fault
  bool calm;           // without wind: only then a braking distance can be guaranteed
};

struct InjectionRunResult;

// What came after a fault reset and a new enable: another fault on the same axis.
struct LaterFault {
  const FaultInjection *fault_injection;
  std::shared_ptr<InjectionRunResult> result;  // none: the axis could not be enabled again
};

constexpr int kLaterFaults = 2;

struct InjectionRunResult {
  bool showed = false;          // the fault could be detected
  fault_id seen = FAULT_NONE;   // the detected fault
  int latency_ms = 0;           // from when it became visible to the tick that reacts; 0 also when detected before
  int visible_ms = 0;           // longest time in which it was visible and not detected
  bool reaction_right = false;  // torque, brake or nothing in that tick as the table says, and a fault, off, in the end
  bool other_axis_right = false;  // still in operation, or also in fault when the injection affects both axes
  double speed_before_rad_s = 0;  // of the joint at the injection, and of the set-point, whichever is faster
  double speed_most_rad_s =
      0;                  // of the joint from then on, until it came to rest or wind moved it: without torque, not calm
  double travel_rad = 0;  // from the tick that reacts to the first standstill
  bool came_to_rest = false;
  double deviation_rad = 0;  // of the joint from where its set-point led it, from the injection to the detection
  std::vector<LaterFault> later;
};

InjectionRunResult run_injection_run(const NodeSetup& setup, const InjectionRunSetup& injection_run);

// Returns the documented braking distance [rad]: from a speed to standstill in calm air. A gust of three standard
// deviations turns an axis of the tracker plant that is off: 11 Nm against 9 of friction.
double promised_travel_rad(fault_reaction reaction, double speed_rad_s);

// Returns the documented increase of the joint's speed above its actual and commanded speed before the reaction takes
// effect [rad/s].
double promised_overshoot_rad_s(const FaultInjection& fault_injection);

}  // namespace trackservo::sim

#endif
