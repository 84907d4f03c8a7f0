// SPDX-License-Identifier: Apache-2.0
#include "test_plan/test_plan_json.hpp"

namespace trackservo::commissioning {

namespace {

using Json = nlohmann::ordered_json;

// The shortest text that is the same float.
double shortest(float value) { return std::stod(Json(value).dump()); }

void add_motion(Json& json, const stimulus_setup& setup) {
  json["low_rad_s"] = shortest(setup.low_rad_s);
  json["acceleration_rad_s2"] = shortest(setup.acceleration_rad_s2);
}

Json json_of(const stimulus_setup& setup) {
  Json json{{"kind", static_cast<int>(setup.kind)}, {"count", setup.count}, {"dwell_s", shortest(setup.dwell_s)}};
  switch (setup.kind) {
    case STIMULUS_SWEEP:
      add_motion(json, setup);
      json["speed_ratio"] = shortest(setup.speed_ratio);
      break;
    case STIMULUS_CHIRP:
      add_motion(json, setup);
      json["amplitude_nm"] = shortest(setup.amplitude_nm);
      json["low_hz"] = shortest(setup.low_hz);
      json["high_hz"] = shortest(setup.high_hz);
      break;
    case STIMULUS_HYSTERESIS:
      json["amplitude_rad"] = shortest(setup.amplitude_rad);
      break;
    case STIMULUS_TORQUE_RAMPS:
      json["amplitude_nm"] = shortest(setup.amplitude_nm);
      break;
    case STIMULUS_BREAKAWAY:
      json["amplitude_nm"] = shortest(setup.amplitude_nm);
      json["amplitude_rad"] = shortest(setup.amplitude_rad);
      break;
    case STIMULUS_NONE:
    default:
      break;
  }
  json["duration_s"] = shortest(stimulus_duration_s(&setup));
  return json;
}

}  // namespace

Json to_json(const TestPlan& test_plan, double start_rad) {
  Json json{{"format", "trackservo-programme"},
            {"version", 1},
            {"stage", stage_name(test_plan.stage)},
            {"duration_s", duration_s(test_plan, start_rad)},
            {"moving_rad_s", test_plan.moving_rad_s},
            {"limits",
             {{"travel_rad", shortest(test_plan.limits.travel_rad)},
              {"rate_rad_s", shortest(test_plan.limits.rate_rad_s)},
              {"torque_nm", shortest(test_plan.limits.torque_nm)},
              {"duration_s", shortest(test_plan.limits.duration_s)}}},
            {"places", Json::array()}};
  for (const Place& place : test_plan.places) {
    Json experiments = Json::array();
    for (const stimulus_setup& setup : place.experiments) {
      experiments.push_back(json_of(setup));
    }
    json["places"].push_back({{"angle_rad", place.angle_rad}, {"experiments", experiments}});
  }
  return json;
}

}  // namespace trackservo::commissioning
