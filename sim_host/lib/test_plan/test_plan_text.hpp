// SPDX-License-Identifier: Apache-2.0
// A test plan as text, shown before an axis moves: what, where, how fast, how strong, how long.
#ifndef TRACKSERVO_TEST_PLAN_TEST_PLAN_TEXT_HPP
#define TRACKSERVO_TEST_PLAN_TEST_PLAN_TEXT_HPP

#include "test_plan/test_plan.hpp"

namespace trackservo::commissioning {

// Prints the test plan to the standard output. `start_rad`: present angle of the axis.
void print(const TestPlan& test_plan, double start_rad);

}  // namespace trackservo::commissioning

#endif
