// SPDX-License-Identifier: Apache-2.0
#include "machine/run/scenario_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "machine/base/firmware.hpp"
#include "machine/target/fly_by.hpp"

namespace trackservo::sim {
namespace {

using Warnings = std::vector<std::string>;

bool moves(const ScenarioConfig& scenario, int axis) { return scenario.axes[static_cast<std::size_t>(axis)]; }

const AxisConfig& axis_of(const PlantConfig& plant, int axis) { return plant.axis[static_cast<std::size_t>(axis)]; }

bool is_beyond(const std::optional<EndStopConfig>& stops, double angle_rad) {
  return stops && (angle_rad < stops->lower_rad || angle_rad > stops->upper_rad);
}

std::string stops_text(const PlantConfig& plant, int axis) {
  const EndStopConfig& stops = axis_of(plant, axis).end_stops.value();
  return fmt::format("the end stops of {}'s {}, {:g} and {:g} deg", plant.name, axis_name(axis),
                     kDegPerRad * stops.lower_rad, kDegPerRad * stops.upper_rad);
}

// Where the file gives the course.
const char *course_key(const ScenarioConfig& scenario) { return scenario.pass ? "pass" : "fly_by.start_position_m"; }

void refuse_start_beyond_stops(const PlantConfig& plant, const ScenarioConfig& scenario,
                               const std::array<double, kAxes>& start_rad) {
  for (int axis = 0; axis < kAxes; ++axis) {
    if (const auto problem = start_problem(plant, axis, start_rad[static_cast<std::size_t>(axis)])) {
      const bool tracking = scenario.kind == ScenarioKind::kTracking;
      throw scenario.lines.error(tracking ? course_key(scenario) : fmt::format("initial_{}_deg", axis_name(axis)),
                                 *problem, "start between these angles");
    }
  }
}

// The target's angles are those of the joints only as long as the base does not turn.
void refuse_axes_alone_on_a_turning_base(const PlantConfig& plant, const ScenarioConfig& scenario) {
  const bool turns = !plant.base_motion.empty() || !plant.base_spectrum.empty();
  if (turns && scenario.camera.geometry != CameraGeometry::kLineOfSight) {
    throw scenario.lines.error(
        "camera.geometry",
        fmt::format("measures the error of each joint by itself, which has no meaning on {}: its base turns",
                    plant.name),
        "give camera.geometry = \"line_of_sight\"");
  }
}

// Follows the target over the run. A camera with line-of-sight geometry sees it everywhere.
void check_course(const PlantConfig& plant, const ScenarioConfig& scenario, Warnings& warnings) {
  constexpr double kClosest_m = 1.0;  // on the ground; azimuth is undefined there
  const bool image = scenario.camera.geometry == CameraGeometry::kLineOfSight;
  const FlyBy target(scenario.fly_by);
  const int ticks = static_cast<int>(std::lround(scenario.duration_s / kTick_s));
  std::array<bool, kAxes> warned{};
  double azimuth_rad = target.at(0.0).angle_rad[kAzimuth];
  for (int tick = 0; tick <= ticks; ++tick) {
    const double time_s = tick * kTick_s;
    const LineOfSight los = target.at(time_s);
    if (!(los.range_m >= kClosest_m)) {
      throw scenario.lines.error(course_key(scenario),
                                 fmt::format("the target is at the tracker itself at {:g} s", time_s),
                                 fmt::format("choose a course that stays {:g} m away from it", kClosest_m));
    }
    if (!image && !(los.range_m * std::cos(los.angle_rad[kPitch]) >= kClosest_m)) {
      throw scenario.lines.error(
          course_key(scenario), fmt::format("the target is directly above the tracker at {:g} s", time_s),
          fmt::format("choose a course that stays {:g} m away from the azimuth axis", kClosest_m));
    }
    if (!image && std::abs(los.angle_rad[kAzimuth] - azimuth_rad) > kPi) {
      throw scenario.lines.error(course_key(scenario),
                                 fmt::format("the target has moved half a turn around the tracker by {:g} s", time_s),
                                 "choose a shorter run or a course that stays on one side");
    }
    azimuth_rad = los.angle_rad[kAzimuth];
    for (int axis = 0; axis < kAxes; ++axis) {
      const auto i = static_cast<std::size_t>(axis);
      if (moves(scenario, axis) && !warned[i] && is_beyond(axis_of(plant, axis).end_stops, los.angle_rad[i])) {
        warned[i] = true;
        warnings.emplace_back(
            scenario.lines
                .error(scenario.pass ? "pass" : "fly_by",
                       fmt::format("the target moves beyond {} at {:g} s", stops_text(plant, axis), time_s),
                       "end the run earlier")
                .what());
      }
    }
  }
}

void check_camera(const ScenarioConfig& scenario, Warnings& warnings) {
  constexpr double kSlowest_hz = 1.0 / (TARGET_TRACKER_STALE_TICKS * kTick_s);
  if (scenario.camera.frame_rate_hz < kSlowest_hz) {
    warnings.emplace_back(scenario.lines
                              .error("camera.frame_rate_hz",
                                     fmt::format("the paper's tracking loop drops an error that is older than {} ms",
                                                 TARGET_TRACKER_STALE_TICKS),
                                     fmt::format("give at least {:.1f}, or use the improved loop", kSlowest_hz))
                              .what());
  }
}

// The angles that a speed reference passes, from the start [rad].
struct Travel {
  double min_rad;
  double max_rad;
};

Travel travel_of(const ScenarioConfig& scenario, double speed_rad_s) {
  const double moving_s = scenario.duration_s - scenario.rest_s;
  double end_rad = speed_rad_s * moving_s;
  if (scenario.kind == ScenarioKind::kSpeedSine) {
    const double w = 2.0 * kPi * scenario.frequency_hz;
    end_rad = speed_rad_s / w * (1.0 - std::cos(std::min(w * moving_s, kPi)));
  }
  return {std::min(0.0, end_rad), std::max(0.0, end_rad)};
}

void check_speed(const PlantConfig& plant, const ScenarioConfig& scenario, int axis, double speed_rad_s,
                 Warnings& warnings) {
  const AxisConfig& machine = axis_of(plant, axis);
  const std::string what = fmt::format("{:g} deg/s", kDegPerRad * speed_rad_s);
  const auto warn = [&](const std::string& reason, const char *remedy) {
    warnings.emplace_back(scenario.lines.error("speeds_deg_s", what + " " + reason, remedy).what());
  };
  const Travel travel = travel_of(scenario, speed_rad_s);
  const double start_rad = scenario.initial_joint_angle_rad[static_cast<std::size_t>(axis)];
  if (is_beyond(machine.end_stops, start_rad + travel.min_rad) ||
      is_beyond(machine.end_stops, start_rad + travel.max_rad)) {
    warn(fmt::format("leads beyond {}", stops_text(plant, axis)), "give a shorter duration_s or another start");
  }
  if (std::abs(speed_rad_s) * machine.motor.back_emf_constant_v_s_rad > plant.supply.voltage_v) {
    warn(fmt::format("needs more than {:g} V from {}'s motor supply", plant.supply.voltage_v, axis_name(axis)),
         "give a lower speed");
  }
  if (std::abs(speed_rad_s) > machine.gyro.range_rad_s) {
    warn(fmt::format("is outside the range of {}'s gyro, {:g} deg/s", axis_name(axis),
                     kDegPerRad * machine.gyro.range_rad_s),
         "give a lower speed");
  }
}

// Torques that the reference and the disturbance require for the bare inertia.
void check_torques(const PlantConfig& plant, const ScenarioConfig& scenario, int axis, Warnings& warnings) {
  const double inertia_kg_m2 = axis_inertia_kg_m2(plant, axis, scenario.initial_joint_angle_rad[kPitch]);
  const double available_nm = available_torque_nm(plant, axis);
  const auto warn = [&](const char *key, double amplitude_rad_s, double frequency_hz) {
    const double needed_nm = inertia_kg_m2 * amplitude_rad_s * 2.0 * kPi * frequency_hz;
    if (needed_nm > available_nm) {
      warnings.emplace_back(scenario.lines
                                .error(key,
                                       fmt::format("needs {:.3g} Nm from {}'s motor, which gives {:.3g} Nm", needed_nm,
                                                   axis_name(axis), available_nm),
                                       "give a lower amplitude or frequency")
                                .what());
    }
  };
  if (scenario.kind == ScenarioKind::kSpeedSine) {
    warn("frequency_hz", *std::max_element(scenario.speeds_rad_s.begin(), scenario.speeds_rad_s.end()),
         scenario.frequency_hz);
  } else {
    warn("disturbance_amplitude_deg_s", scenario.disturbance_amplitude_rad_s, scenario.disturbance_frequency_hz);
  }
}

void check_periods(const ScenarioConfig& scenario, Warnings& warnings) {
  const double analysed_s = scenario.duration_s - scenario.rest_s - scenario.settle_s;
  if (scenario.kind == ScenarioKind::kSpeedSine && analysed_s * scenario.frequency_hz < 1.0 - 1e-9) {
    warnings.emplace_back(scenario.lines
                              .error("duration_s",
                                     fmt::format("analyses only {:g} s of a sine with a period of {:g} s", analysed_s,
                                                 1.0 / scenario.frequency_hz),
                                     "give at least one period")
                              .what());
  }
}

void check_seal(const PlantConfig& plant, int axis, Warnings& warnings) {
  const FrictionConfig& friction = axis_of(plant, axis).friction;
  const bool forwards = friction.positive.breakaway_nm >= friction.negative.breakaway_nm;
  const double level = 1.0 + friction.eccentricity_once + friction.eccentricity_twice;
  const double needed_nm = level * (forwards ? friction.positive : friction.negative).breakaway_nm;
  const double available_nm = available_torque_nm(plant, axis);
  if (plant.friction_model != FrictionModel::kNone && needed_nm > available_nm) {
    warnings.emplace_back(
        plant.lines
            .error(fmt::format("{}.friction.{}.breakaway_nm", axis_name(axis), forwards ? "positive" : "negative"),
                   fmt::format("the seal's largest holding torque is {:.3g} Nm, but the motor gives {:.3g} Nm",
                               needed_nm, available_nm),
                   "give less, or raise motor.current_limit_a")
            .what());
  }
}

}  // namespace

double available_torque_nm(const PlantConfig& plant, int axis) {
  const MotorConfig& motor = axis_of(plant, axis).motor;
  const double stall_a = plant.supply.voltage_v / (motor.resistance_ohm + plant.supply.source_resistance_ohm);
  return motor.torque_constant_nm_a * std::min(motor.current_limit_a, stall_a);
}

std::optional<std::string> start_problem(const PlantConfig& plant, int axis, double angle_rad) {
  if (!is_beyond(axis_of(plant, axis).end_stops, angle_rad)) {
    return std::nullopt;
  }
  return fmt::format("a start at {:g} deg is beyond {}", kDegPerRad * angle_rad, stops_text(plant, axis));
}

std::vector<std::string> check_scenario(const PlantConfig& plant, const ScenarioConfig& scenario) {
  Warnings warnings;
  const bool tracking = scenario.kind == ScenarioKind::kTracking;
  if (tracking) {
    refuse_axes_alone_on_a_turning_base(plant, scenario);
    check_course(plant, scenario, warnings);
    check_camera(scenario, warnings);
  }
  refuse_start_beyond_stops(plant, scenario,
                            tracking ? FlyBy(scenario.fly_by).at(0.0).angle_rad : scenario.initial_joint_angle_rad);
  check_periods(scenario, warnings);
  for (int axis = 0; axis < kAxes; ++axis) {
    check_seal(plant, axis, warnings);
    if (tracking || !moves(scenario, axis)) {
      continue;
    }
    check_torques(plant, scenario, axis, warnings);
    for (const double speed_rad_s : scenario.speeds_rad_s) {
      check_speed(plant, scenario, axis, speed_rad_s, warnings);
    }
  }
  return warnings;
}

}  // namespace trackservo::sim
