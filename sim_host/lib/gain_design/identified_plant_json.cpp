// SPDX-License-Identifier: Apache-2.0
#include "gain_design/identified_plant_json.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace trackservo::gain_design {
namespace {

constexpr const char *kFormat = "trackservo-identification";
constexpr int kVersion = 1;
constexpr double kMax = 1e30;  // of any number, so that it is one for a float too

void check_format(const InputFile& file) {
  // Compared as JSON, to reject versions that do not fit an int.
  if (file.json.value("format", "") != kFormat ||
      file.json.value("version", nlohmann::json()) != nlohmann::json(kVersion)) {
    throw file.error(
        fmt::format("is not a {} of version {}; give the file that identify fit wrote with --json", kFormat, kVersion));
  }
}

// A number at a path such as "checks/gyro/delay_s".
double number_at(const InputFile& file, const std::string& path) {
  const nlohmann::json::json_pointer pointer("/" + path);
  if (!file.json.contains(pointer) || !file.json.at(pointer).is_number()) {
    throw file.error(fmt::format("\"{}\" is missing or not a number; run identify fit again", path));
  }
  const double value = file.json.at(pointer).get<double>();
  if (std::abs(value) > kMax) {
    throw file.error(
        fmt::format("\"{}\" is {:g}, outside the range of all machines; run identify fit again", path, value));
  }
  return value;
}

// The reason that the identification gave for a refused parameter.
std::string refusal_of(const InputFile& file, const std::string& parameter) {
  for (const nlohmann::json& refused : file.json.value("refused", nlohmann::json::array())) {
    if (refused.value("parameter", "") == parameter) {
      return refused.value("message", parameter);
    }
  }
  return parameter;
}

// One message for all parameters that the identification refused.
void refuse_what_was_refused(const InputFile& file, const std::vector<std::string>& names) {
  std::string messages;
  for (const std::string& name : names) {
    const nlohmann::json::json_pointer pointer("/parameters/" + name + "/value");
    if (file.json.contains(pointer) && file.json.at(pointer).is_null()) {
      messages += " " + refusal_of(file, name);
    }
  }
  if (!messages.empty()) {
    throw file.error("the gain design needs parameters that the identification refused; add the named runs:" +
                     messages);
  }
}

double parameter(const InputFile& file, const std::string& name) {
  return number_at(file, "parameters/" + name + "/value");
}

lugre_direction direction(const InputFile& file, const std::string& name) {
  lugre_direction d{};
  d.coulomb_nm = static_cast<float>(parameter(file, "coulomb_" + name));
  d.breakaway_nm = std::max(static_cast<float>(parameter(file, "breakaway_" + name)), d.coulomb_nm);
  d.stribeck_speed_rad_s = static_cast<float>(parameter(file, "stribeck_speed_" + name));
  d.viscous_nm_s_rad = static_cast<float>(parameter(file, "viscous_" + name));
  return d;
}

// The whole delay is measured; the assumed low-pass explains its part first.
GyroFacts gyro_facts(double delay_s, double noise_rad_s) {
  constexpr double kShortest_s = 1e-5;
  const double lag_s = 1.0 / (2.0 * M_PI * kAssumedGyroBandwidth_hz);
  if (delay_s >= lag_s) {
    return {delay_s - lag_s, kAssumedGyroBandwidth_hz, noise_rad_s};
  }
  return {0.0, 1.0 / (2.0 * M_PI * std::max(delay_s, kShortest_s)), noise_rad_s};
}

StructuralMode mode(const InputFile& file, std::size_t index) {
  const std::string path = fmt::format("resonances/{}/", index);
  return {2.0 * M_PI * number_at(file, path + "frequency_hz"), number_at(file, path + "damping"),
          number_at(file, path + "share")};
}

// Absent in results of before 2026-12 that were written by hand, and where the residuals are no slow torque.
std::optional<Disturbance> disturbance(const InputFile& file) {
  const nlohmann::json noise = file.json.value("noise", nlohmann::json::object());
  if (!noise.contains("autoregression")) {
    return std::nullopt;
  }
  ResidualNoise residuals{number_at(file, "noise/step_s"), number_at(file, "noise/innovation_nm"), {}};
  for (std::size_t lag = 0; lag < noise["autoregression"].size(); ++lag) {
    residuals.autoregression.push_back(number_at(file, fmt::format("noise/autoregression/{}", lag)));
  }
  if (residuals.step_s <= 0.0 || residuals.innovation_nm <= 0.0) {
    throw file.error("\"noise\" has a step or an innovation that is not above 0; run identify fit again");
  }
  return slow_disturbance(residuals);
}

IdentifiedPlant plant_from(const InputFile& file) {
  check_format(file);
  std::vector<std::string> names{"inertia", "stiffness", "damping"};
  for (const char *quantity : {"coulomb_", "breakaway_", "stribeck_speed_", "viscous_"}) {
    names.push_back(std::string(quantity) + "positive");
    names.push_back(std::string(quantity) + "negative");
  }
  refuse_what_was_refused(file, names);
  IdentifiedPlant plant;
  plant.inertia_kg_m2 = parameter(file, "inertia");
  plant.friction.stiffness_nm_rad = static_cast<float>(parameter(file, "stiffness"));
  plant.friction.damping_nm_s_rad = static_cast<float>(parameter(file, "damping"));
  plant.friction.positive = direction(file, "positive");
  plant.friction.negative = direction(file, "negative");
  plant.encoder = {std::max(0.0, number_at(file, "checks/delay_s") + kCurrentAge_s),
                   number_at(file, "checks/encoder_noise_rad")};
  if (file.json.value(nlohmann::json::json_pointer("/checks/gyro/used"), false)) {
    plant.gyro = gyro_facts(plant.encoder.latency_s + number_at(file, "checks/gyro/delay_s"),
                            number_at(file, "checks/gyro/noise_rad_s"));
  }
  const std::size_t modes = file.json.value("resonances", nlohmann::json::array()).size();
  for (std::size_t i = 0; i < modes; ++i) {
    plant.modes.push_back(mode(file, i));
  }
  plant.disturbance = disturbance(file);
  return plant;
}

}  // namespace

IdentifiedPlant read_identified_plant(const InputFile& file) {
  try {
    return plant_from(file);
  } catch (const nlohmann::json::exception& error) {  // a text where a number or a table should be, and similar errors
    throw file.error(fmt::format("{}; run identify fit again", error.what()));
  }
}

}  // namespace trackservo::gain_design
