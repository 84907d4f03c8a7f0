// A programme as the file that servoctl carries out. Keys are the fields of object 2100, in its units; what a kind of
// experiment does not use is left out.
#ifndef TRACKSERVO_TEST_PLAN_TEST_PLAN_JSON_HPP
#define TRACKSERVO_TEST_PLAN_TEST_PLAN_JSON_HPP

#include <nlohmann/json.hpp>

#include "test_plan/test_plan.hpp"

namespace trackservo::commissioning {

// `start_rad`: where the axis is, for the predicted duration.
nlohmann::ordered_json to_json(const Programme& programme, double start_rad);

}  // namespace trackservo::commissioning

#endif
