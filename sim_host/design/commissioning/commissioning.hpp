// SPDX-License-Identifier: Apache-2.0
// The whole commissioning of one axis of a simulated machine: first look, test plan, chirps for the structure, fit.
// The same as `servoctl identify` on a real one, at the computer's full speed.
#ifndef TRACKSERVO_SIM_COMMISSIONING_COMMISSIONING_HPP
#define TRACKSERVO_SIM_COMMISSIONING_COMMISSIONING_HPP

#include <map>
#include <string>

#include "design/commissioning/acquisition.hpp"
#include "identification/identification.hpp"

namespace trackservo::sim {

// Returns the limits of an axis of this plant: its end stops (or a turn), its motor's torque, and 0.6 rad/s.
commissioning::MotionLimits motion_limits(const PlantConfig& plant, int axis);

struct Commissioned {
  int axis;
  commissioning::RoughMachine rough;    // of the first look
  double first_look_s;                  // simulated
  Acquisition acquisition;              // of the test plan
  identification::Recording structure;  // of the chirps for resonances
  identification::Identification identification;
  std::map<std::string, double> truth;  // with the same names
};

// Break-away torques of one direction, over all break-away experiments.
struct BreakawayTorque {
  std::uint32_t count = 0;
  double mean_nm = 0;
  double deviation_nm = 0;  // 0 for fewer than two
};

// Returns the break-away torque of a direction: STIMULUS_BACKWARD or STIMULUS_FORWARD.
BreakawayTorque breakaway_torque(const std::vector<experiment>& ended, int direction);

// Commissions the axis with the gains that the plant file requires (PI alone), for both axes; the other axis stays at
// angle 0. Throws ConfigError, TestPlanError, ExperimentError, IdentificationError.
Commissioned commission(const PlantConfig& plant, int axis, std::uint64_t seed);

}  // namespace trackservo::sim

#endif
