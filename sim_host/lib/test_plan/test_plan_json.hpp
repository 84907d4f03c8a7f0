// SPDX-License-Identifier: Apache-2.0
// A test plan as the file that servoctl executes. Keys are the fields of object 2100, in its units; fields that a kind
// of experiment does not use are left out.
#ifndef TRACKSERVO_TEST_PLAN_TEST_PLAN_JSON_HPP
#define TRACKSERVO_TEST_PLAN_TEST_PLAN_JSON_HPP

#include <nlohmann/json.hpp>

#include "test_plan/test_plan.hpp"

namespace trackservo::commissioning {

// Returns the contents of the file. `start_rad`: present angle of the axis, for the predicted duration.
nlohmann::ordered_json to_json(const TestPlan& test_plan, double start_rad);

}  // namespace trackservo::commissioning

#endif
