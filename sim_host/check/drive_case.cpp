// SPDX-License-Identifier: Apache-2.0
#include "check/drive_case.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "machine/run/scenario_run.hpp"

namespace trackservo::sim {
namespace {

double set_point_rad_s(const ScenarioConfig& scenario, int axis, double speed_rad_s, double time_s) {
  return scenario.axes[static_cast<std::size_t>(axis)] && time_s >= 0.0
             ? static_cast<double>(speed_set_point(scenario, speed_rad_s, time_s).rate_rad_s)
             : 0.0;
}

TraceRow row_of(const CheckedDevice& device, const TruthState& truth, const ScenarioConfig& scenario,
                double speed_rad_s, double time_s) {
  TraceRow row{};
  row.time_s = time_s;
  for (int axis = 0; axis < kAxes; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    AxisRow& of_axis = row.axis[i];
    of_axis.reference_rad_s =
        set_point_rad_s(scenario, axis, speed_rad_s, time_s - kTick_s * device.device().set_point_delay_ms());
    of_axis.rate_rad_s = truth.inertial_rate_rad_s[i];
    of_axis.joint_rate_rad_s = truth.joint_rate_rad_s[i];
    of_axis.joint_angle_rad = truth.joint_angle_rad[i];
    of_axis.torque_nm = truth.motor_torque_nm[i];
    of_axis.friction_nm = truth.friction_torque_nm[i];
    of_axis.load_nm = truth.load_torque_nm[i];
    of_axis.command_nm = device.device().torque_command_nm(axis).value_or(std::numeric_limits<double>::quiet_NaN());
  }
  return row;
}

}  // namespace

DrivenCase drive_case(CheckedDevice& device, const PlantConfig& plant, const ScenarioConfig& scenario,
                      double speed_rad_s, const Gains& gains) {
  apply_gains(device, gains);
  DrivenCase driven;
  if (!device.enable()) {
    driven.failure = "the axes are not enabled: " + device.failure().value_or("no fault");
    return driven;
  }
  const int ticks = static_cast<int>(std::lround(scenario.duration_s / kTick_s));
  driven.trace.reserve(static_cast<std::size_t>(ticks));
  for (int tick = 0; tick < ticks && !driven.failure; ++tick) {
    const double time_s = tick * kTick_s;
    std::array<double, kAxes> rate_rad_s{};
    for (int axis = 0; axis < kAxes; ++axis) {
      const auto i = static_cast<std::size_t>(axis);
      rate_rad_s[i] = set_point_rad_s(scenario, axis, speed_rad_s, time_s);
      device.device().disturb(axis, scenario.axes[i] ? disturbance_nm(plant, scenario, axis, time_s) : 0.0);
    }
    device.command(rate_rad_s);
    const TruthState truth = device.device().truth();
    device.pass_ms();
    driven.trace.push_back(row_of(device, truth, scenario, speed_rad_s, time_s));
    if (const std::optional<std::string> failure = device.failure()) {
      driven.failure = fmt::format("{} after {:.2f} s", *failure, time_s);
      driven.trace.clear();
    }
  }
  return driven;
}

}  // namespace trackservo::sim
