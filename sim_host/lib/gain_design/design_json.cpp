// SPDX-License-Identifier: Apache-2.0
#include "gain_design/design_json.hpp"

#include <cmath>

#include "gain_design/device_parameters.hpp"

namespace trackservo::gain_design {
namespace {

using Json = nlohmann::ordered_json;

// A margin that does not exist is null: JSON has no infinity.
Json finite(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json margins_json(const Margins& margins) {
  return {{"gain_margin_db", finite(margins.gain_margin_db)},
          {"phase_margin_deg", finite(margins.phase_margin_deg)},
          {"crossover_hz", margins.crossover_hz}};
}

void add_rate_error(Json& json, const RateError& error) {
  json["rate_error_rad_s"] = error.rad_s();
  json["rate_error_by_disturbance_rad_s"] = error.disturbance_rad_s;
  json["rate_error_by_encoder_rad_s"] = error.encoder_rad_s;
  json["rate_error_by_gyro_rad_s"] = error.gyro_rad_s;
}

Json predicted_json(const GainDesign& design) {
  Json json = margins_json(design.sliding);
  json["bandwidth_hz"] = design.bandwidth_hz;
  json["speed_loop_bandwidth_hz"] = design.speed_loop_bandwidth_hz;
  json["torque_noise_nm"] = design.torque_noise_nm;
  if (design.rate_error) {
    add_rate_error(json, *design.rate_error);
  }
  json["pre_sliding"] = margins_json(design.pre_sliding);
  if (design.bound) {
    Json& bound = json["best_linear_controller"];
    add_rate_error(bound, design.bound->error);
    bound["sensitivity"] = design.bound->sensitivity;
  }
  return json;
}

Json loop_gain_json(const FrequencyResponse& response) {
  Json real = Json::array();
  Json imag = Json::array();
  for (const std::complex<double>& gain : response.loop_gain) {
    real.push_back(gain.real());
    imag.push_back(gain.imag());
  }
  return {{"frequency_hz", response.frequency_hz}, {"real", real}, {"imag", imag}};
}

}  // namespace

Json to_json(const GainDesign& design, const axis_parameters& before) {
  Json json;
  json["format"] = "trackservo-design";
  json["version"] = 1;
  json["parameters"] = parameter_rows(before, design.parameters);
  json["predicted"] = predicted_json(design);
  json["loop_gain"] = loop_gain_json(design.loop_gain);
  json["notes"] = design.notes;
  return json;
}

}  // namespace trackservo::gain_design
