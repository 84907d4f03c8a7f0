// One breakage, once: in one motion, at one moment, on one axis of a machine with all its noise and wind.
#ifndef TRACKSERVO_SIM_FAULT_INJECTION_TRIAL_HPP
#define TRACKSERVO_SIM_FAULT_INJECTION_TRIAL_HPP

#include "fault_injection/breakage.hpp"
#include "fault_injection/motion.hpp"

namespace trackservo::sim {

struct TrialSetup {
  const Breakage *breakage;
  Motion motion;
  int axis;
  std::uint64_t seed;  // of the machine's noise, of the moment, of the breakage's size
  bool calm;           // without wind: only then a braking distance can be promised
};

struct TrialResult {
  bool showed = false;          // there was something to be seen
  fault_id seen = FAULT_NONE;   // what it was taken for
  int latency_ms = 0;           // from when it showed to the tick that reacts; 0 also when seen before
  bool reaction_right = false;  // torque, brake or nothing in that tick as the table says, and a fault, off, in the end
  bool other_axis_right = false;  // in operation still, or in fault, too, where the breakage is both axes'
  double speed_before_rad_s = 0;  // of the joint when it broke, and of the set-point, whichever is faster
  double speed_most_rad_s =
      0;                  // of the joint from then on, until it came to rest or wind had it: without torque, not calm
  double travel_rad = 0;  // from the tick that reacts to the first standstill
  bool came_to_rest = false;
};

TrialResult run_trial(const NodeSetup& setup, const TrialSetup& trial);

// What the documentation promises [rad]: from a speed to standstill in calm air. A gust of three standard deviations
// turns an axis of the tracker plant that is off: 11 Nm against 9 of friction.
double promised_travel_rad(fault_reaction reaction, double speed_rad_s);

// And how much faster the joint becomes than it was or should have been, before the reaction takes hold [rad/s].
double promised_overshoot_rad_s(const Breakage& breakage);

}  // namespace trackservo::sim

#endif
