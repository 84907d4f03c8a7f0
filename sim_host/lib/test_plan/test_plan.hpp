// SPDX-License-Identifier: Apache-2.0
// The motions of an axis that is to be identified: which experiments of firmware/commissioning at which places of the
// travel.
//
// An unknown machine is identified in three stages. The first look assumes only the limits of the axis: loops of all
// sizes, speeds of all sizes. The result of its fit, good to a factor of two, sizes the main test plan, and a short one
// for resonances of the structure (decision 0013). The executor of a test plan moves the axis from place to place,
// performs the experiments there, and records every tick, moves included.
#ifndef TRACKSERVO_TEST_PLAN_TEST_PLAN_HPP
#define TRACKSERVO_TEST_PLAN_TEST_PLAN_HPP

#include <stdexcept>
#include <vector>

#include "identification/rough_machine.hpp"

extern "C" {
#include "commissioning/experiment.h"
}

namespace trackservo::commissioning {

// Limits of the axis, whatever is identified.
struct MotionLimits {
  double lowest_rad = 0;   // of the joint angle
  double highest_rad = 0;  // at least 0.02 rad above; of more than a turn only the middle one is used
  double rate_rad_s = 0;   // never passed; set-points keep to half of it. 1e-3 .. 100
  double torque_nm = 0;    // never passed, 1e-3 .. 1e4
};

// Rough knowledge of the axis: a factor of two does not matter.
using identification::RoughMachine;

struct Place {
  double angle_rad = 0;
  std::vector<stimulus_setup> experiments;
};

enum class Stage { kFirstLook, kIdentification, kStructure };

// Returns the name as in files: "first_look", "identification", "structure".
const char *stage_name(Stage stage);

struct TestPlan {
  Stage stage = Stage::kIdentification;
  std::vector<Place> places;
  double moving_rad_s = 0;     // between the places
  experiment_limits limits{};  // the same for all experiments; travel to each side of a place
};

// These limits leave no room for a test plan; the message names the limit, and a value that would be enough.
class TestPlanError : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

// Returns a test plan of about a minute. Throws TestPlanError.
TestPlan first_look(const MotionLimits& limits);

// Returns a test plan of some minutes. Throws TestPlanError.
TestPlan test_plan_for(const MotionLimits& limits, const RoughMachine& machine);

// Returns chirps far beyond the loop's bandwidth, about a minute. They are recorded separately: friction is fitted to 5
// ms steps, and aliases from above 100 Hz would change sigma2 by up to 5 %. Throws TestPlanError.
TestPlan structure_look(const MotionLimits& limits, const RoughMachine& machine);

// Returns the approximate duration from `start_rad` on, moves included [s].
double duration_s(const TestPlan& test_plan, double start_rad);

}  // namespace trackservo::commissioning

#endif
