// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>
#include <utility>

#include "machine/config/plant_keys.hpp"
#include "machine/config/toml_reader.hpp"

namespace trackservo::sim {

namespace {

template <class Owner>
void read_table(const TomlReader& reader, const TomlTable& table, const Keys<Owner>& keys, Owner& owner) {
  reader.refuse_unknown(table, keys);
  reader.read(table, keys, owner);
}

// A table that may be absent: then every key has its default.
template <class Owner>
void read_optional_table(const TomlReader& reader, const TomlTable& parent, const char *name, const Keys<Owner>& keys,
                         Owner& owner) {
  if (const auto table = reader.child_if_present(parent, name)) {
    read_table(reader, *table, keys, owner);
  }
}

StribeckConfig read_direction(const TomlReader& reader, const TomlTable& table) {
  StribeckConfig direction;
  read_table(reader, table, stribeck_keys(), direction);
  if (direction.breakaway_nm < direction.coulomb_nm) {
    reader.fail(table, "breakaway_nm",
                fmt::format("{:g} is below coulomb_nm = {:g}", direction.breakaway_nm, direction.coulomb_nm),
                fmt::format("give at least {:g}", direction.coulomb_nm));
  }
  return direction;
}

FrictionConfig read_friction(const TomlReader& reader, const TomlTable& table) {
  constexpr double kLargestDeflection_rad = 1.0;  // of the bristles; beyond this the numbers are surely mixed up
  FrictionConfig friction;
  reader.refuse_unknown(table, friction_keys(), {"positive", "negative"});
  reader.read(table, friction_keys(), friction);
  friction.positive = read_direction(reader, reader.child(table, "positive"));
  const auto negative = reader.child_if_present(table, "negative");
  friction.negative = negative ? read_direction(reader, *negative) : friction.positive;
  const double breakaway_nm = std::max(friction.positive.breakaway_nm, friction.negative.breakaway_nm);
  if (breakaway_nm > kLargestDeflection_rad * friction.stiffness_nm_rad) {
    reader.fail(table, "stiffness_nm_rad",
                fmt::format("{:g} lets the bristles deflect by more than 1 rad", friction.stiffness_nm_rad),
                fmt::format("give at least {:g}", breakaway_nm / kLargestDeflection_rad));
  }
  return friction;
}

MotorConfig read_motor(const TomlReader& reader, const TomlTable& table) {
  MotorConfig motor;
  reader.refuse_unknown(table, motor_keys(), {"ripple", "cogging"});
  reader.read(table, motor_keys(), motor);
  for (const TomlTable& harmonic : reader.children(table, "ripple")) {
    read_table(reader, harmonic, ripple_keys(), motor.ripple.emplace_back());
  }
  for (const TomlTable& harmonic : reader.children(table, "cogging")) {
    read_table(reader, harmonic, cogging_keys(), motor.cogging.emplace_back());
  }
  return motor;
}

std::optional<EndStopConfig> read_end_stops(const TomlReader& reader, const TomlTable& table) {
  EndStopKeys keys;
  reader.read(table, end_stop_keys(), keys);
  if (keys.range_rad.empty()) {
    return std::nullopt;
  }
  if (keys.range_rad.size() != 2 || keys.range_rad[0] >= keys.range_rad[1]) {
    reader.fail(table, "end_stops_deg", "must be two angles in ascending order", "give [lower, upper]");
  }
  return EndStopConfig{keys.range_rad[0], keys.range_rad[1], keys.stiffness_nm_rad, keys.restitution};
}

AxisConfig read_axis(const TomlReader& reader, const TomlTable& table, bool swings) {
  AxisConfig axis;
  std::vector<std::string> known{"motor", "friction", "load", "holding_brake", "structure", "base_sway"};
  for_each_sensor([&](const char *name, const auto&, auto) { known.emplace_back(name); });
  for (const auto& key : end_stop_keys()) {
    known.push_back(key.text.name);
  }
  reader.refuse_unknown(table, axis_keys(), known);
  reader.read(table, axis_keys(), axis);
  if (!swings && axis.inertia_swing_kg_m2 != 0.0) {
    reader.fail(table, "inertia_swing_kg_m2", "belongs to azimuth only", "remove it");
  }
  axis.end_stops = read_end_stops(reader, table);
  axis.motor = read_motor(reader, reader.child(table, "motor"));
  axis.friction = read_friction(reader, reader.child(table, "friction"));
  read_optional_table(reader, table, "load", load_keys(), axis.load);
  if (const auto brake = reader.child_if_present(table, "holding_brake")) {
    read_table(reader, *brake, holding_brake_keys(), axis.holding_brake.emplace());
  }
  if (const auto structure = reader.child_if_present(table, "structure")) {
    read_table(reader, *structure, structure_keys(), axis.structure.emplace());
  }
  read_optional_table(reader, table, "base_sway", base_sway_keys(), axis.base_sway);
  for_each_sensor([&](const char *name, const auto& keys, auto member) {
    if (all_optional(keys)) {
      read_optional_table(reader, table, name, keys, axis.*member);
    } else {
      read_table(reader, reader.child(table, name), keys, axis.*member);
    }
  });
  return axis;
}

DesignConfig read_design(const TomlReader& reader, const TomlTable& table) {
  DesignConfig design;
  read_table(reader, table, design_keys(), design);
  if (design.speed_loop_bandwidth_hz.has_value() == design.speed_loop_natural_frequency_rad_s.has_value()) {
    reader.fail(table, "speed_loop_bandwidth_hz",
                design.speed_loop_bandwidth_hz ? "excludes speed_loop_natural_frequency_rad_s"
                                               : "is missing, and so is speed_loop_natural_frequency_rad_s",
                "give exactly one of them");
  }
  return design;
}

}  // namespace

namespace {

// No loop can control what a converter cannot represent.
void check_converters(const TomlReader& reader, const PlantConfig& plant) {
  const TomlTable adc = reader.child(reader.root(), "adc");
  if (plant.adc.voltage_full_scale_v < plant.supply.voltage_v) {
    reader.fail(adc, "voltage_full_scale_v",
                fmt::format("{:g} is below the supply voltage", plant.adc.voltage_full_scale_v),
                fmt::format("give at least supply.voltage_v = {:g}", plant.supply.voltage_v));
  }
  for (const int axis : {kAzimuth, kPitch}) {
    const double limit_a = plant.axis[static_cast<std::size_t>(axis)].motor.current_limit_a;
    if (plant.adc.current_full_scale_a < limit_a) {
      reader.fail(adc, "current_full_scale_a",
                  fmt::format("{:g} is below the current limit of {}", plant.adc.current_full_scale_a, axis_name(axis)),
                  fmt::format("give at least {}.motor.current_limit_a = {:g}", axis_name(axis), limit_a));
    }
  }
}

PlantConfig plant_from(const TomlReader& reader, std::string name) {
  const TomlTable root = reader.root();
  PlantConfig plant;
  plant.lines = reader.lines();
  plant.name = std::move(name);
  reader.refuse_unknown(root, plant_keys(),
                        {"friction", "maxwell_slip", "supply", "adc", "base_tilt", "mechanics", "base_motion",
                         "base_spectrum", "azimuth", "pitch", "design", "assumption"});
  reader.read(root, plant_keys(), plant);
  read_table(reader, reader.child(root, "friction"), friction_model_keys(), plant);
  read_optional_table(reader, root, "maxwell_slip", maxwell_slip_keys(), plant.maxwell_slip);
  read_table(reader, reader.child(root, "supply"), supply_keys(), plant.supply);
  read_table(reader, reader.child(root, "adc"), adc_keys(), plant.adc);
  read_optional_table(reader, root, "base_tilt", base_tilt_keys(), plant.base_tilt);
  read_optional_table(reader, root, "mechanics", mechanics_keys(), plant.mechanics);
  if (kPwmPerTick % plant.mechanics.pwm_periods_per_step != 0) {
    reader.fail(reader.child(root, "mechanics"), "pwm_periods_per_step",
                fmt::format("{} does not divide the {} PWM periods of a tick", plant.mechanics.pwm_periods_per_step,
                            kPwmPerTick),
                "give 1, 2 or 4");
  }
  for (const TomlTable& line : reader.children(root, "base_motion")) {
    read_table(reader, line, base_motion_keys(), plant.base_motion.emplace_back());
  }
  for (const TomlTable& table : reader.children(root, "base_spectrum")) {
    BaseSpectrum& band = plant.base_spectrum.emplace_back();
    read_table(reader, table, base_spectrum_keys(), band);
    if (band.low_hz >= band.high_hz) {
      reader.fail(table, "low_hz", fmt::format("{:g} is not below high_hz = {:g}", band.low_hz, band.high_hz),
                  "give the lower end of the band as low_hz and the upper end as high_hz");
    }
  }
  const TomlTable designs = reader.child(root, "design");
  reader.refuse_unknown(designs, {axis_name(kAzimuth), axis_name(kPitch)});
  for (const int index : {kAzimuth, kPitch}) {
    const auto i = static_cast<std::size_t>(index);
    plant.axis[i] = read_axis(reader, reader.child(root, axis_name(index)), index == kAzimuth);
    plant.design[i] = read_design(reader, reader.child(designs, axis_name(index)));
  }
  check_converters(reader, plant);
  for (const TomlTable& table : reader.children(root, "assumption")) {
    read_table(reader, table, assumption_keys(), plant.assumptions.emplace_back());
  }
  return plant;
}

}  // namespace

PlantConfig load_plant(const std::filesystem::path& path) { return plant_from(TomlReader(path), path.stem().string()); }

PlantConfig parse_plant(const std::string& name, std::string_view text) {
  return plant_from(TomlReader(name, text), name);
}

double axis_inertia_kg_m2(const PlantConfig& plant, int axis, double pitch_rad) {
  const double cosine = std::cos(pitch_rad);
  const AxisConfig& config = plant.axis[static_cast<std::size_t>(axis)];
  return config.inertia_kg_m2 + config.inertia_swing_kg_m2 * cosine * cosine;
}

double steady_friction_nm(const FrictionConfig& friction, double joint_rate_rad_s) {
  if (joint_rate_rad_s == 0.0) {
    return 0.0;
  }
  const StribeckConfig& direction = joint_rate_rad_s > 0.0 ? friction.positive : friction.negative;
  const double ratio = joint_rate_rad_s / direction.stribeck_speed_rad_s;
  const double level =
      direction.coulomb_nm + (direction.breakaway_nm - direction.coulomb_nm) * std::exp(-ratio * ratio);
  return std::copysign(level, joint_rate_rad_s) + direction.viscous_nm_s_rad * joint_rate_rad_s;
}

}  // namespace trackservo::sim
