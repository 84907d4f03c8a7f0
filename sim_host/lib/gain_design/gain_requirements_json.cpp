// SPDX-License-Identifier: Apache-2.0
#include "gain_design/gain_requirements_json.hpp"

#include <fmt/format.h>

#include <functional>

namespace trackservo::gain_design {
namespace {

constexpr const char *kLeastRateError = "least_rate_error";

struct RequirementKey {
  const char *name;
  double low;
  double high;
  std::function<void(GainRequirements&, double)> set;
};

Disturbance& disturbance_of(GainRequirements& requirements) {
  return requirements.disturbance ? *requirements.disturbance : requirements.disturbance.emplace();
}

const std::vector<RequirementKey>& requirement_keys() {
  static const std::vector<RequirementKey> keys = {
      {"speed_loop_bandwidth_hz", 0.01, 300.0, [](GainRequirements& w, double x) { w.speed_loop_bandwidth_hz = x; }},
      {"speed_loop_damping", 0.1, 10.0, [](GainRequirements& w, double x) { w.speed_loop_damping = x; }},
      {"setpoint_weight", 0.0, 1.0, [](GainRequirements& w, double x) { w.setpoint_weight = x; }},
      {"setpoint_model_hz", 0.0, 159.0, [](GainRequirements& w, double x) { w.setpoint_model_hz = x; }},
      {"observer_bandwidth_hz", 0.01, 159.0, [](GainRequirements& w, double x) { w.observer_bandwidth_hz = x; }},
      {"disturbance_rms_nm", 1e-9, 1e5, [](GainRequirements& w, double x) { disturbance_of(w).rms_nm = x; }},
      {"disturbance_corner_hz", 0.001, 100.0, [](GainRequirements& w, double x) { disturbance_of(w).corner_hz = x; }},
      {"least_gain_margin_db", 1.0, 40.0, [](GainRequirements& w, double x) { w.least.gain_margin_db = x; }},
      {"least_phase_margin_deg", 1.0, 90.0, [](GainRequirements& w, double x) { w.least.phase_margin_deg = x; }},
      {"most_torque_noise_nm", 1e-9, 1e4, [](GainRequirements& w, double x) { w.max_torque_noise_nm = x; }},
      {"tracking_bandwidth_hz", 0.01, 15.0, [](GainRequirements& w, double x) { w.tracking_bandwidth_hz = x; }},
      {"position_bandwidth_hz", 0.01, 150.0, [](GainRequirements& w, double x) { w.position_bandwidth_hz = x; }},
  };
  return keys;
}

const RequirementKey *find_key(const std::string& name) {
  for (const RequirementKey& key : requirement_keys()) {
    if (name == key.name) {
      return &key;
    }
  }
  return nullptr;
}

std::string all_names() {
  std::string names;
  for (const RequirementKey& key : requirement_keys()) {
    names += (names.empty() ? "" : ", ") + std::string(key.name);
  }
  return names + ", " + kLeastRateError;
}

}  // namespace

GainRequirements read_gain_requirements(const InputFile& file) {
  GainRequirements requirements;
  for (const auto& [name, value] : file.json.items()) {
    if (name == kLeastRateError) {
      if (!value.is_boolean()) {
        throw file.error(fmt::format("\"{}\" is {}; give true or false", name, value.dump()));
      }
      requirements.least_rate_error = value.get<bool>();
      continue;
    }
    const RequirementKey *key = find_key(name);
    if (key == nullptr) {
      throw file.error(fmt::format("unknown requirement \"{}\"; choose one of {}", name, all_names()));
    }
    if (!value.is_number() || value.get<double>() < key->low || value.get<double>() > key->high) {
      throw file.error(
          fmt::format("\"{}\" is {}; give a number from {:g} to {:g}", name, value.dump(), key->low, key->high));
    }
    key->set(requirements, value.get<double>());
  }
  if (file.json.contains("disturbance_rms_nm") != file.json.contains("disturbance_corner_hz")) {
    throw file.error("a disturbance needs both \"disturbance_rms_nm\" and \"disturbance_corner_hz\"");
  }
  return requirements;
}

}  // namespace trackservo::gain_design
