// SPDX-License-Identifier: Apache-2.0
#include "machine/run/scenario_run.hpp"

#include <cmath>
#include <utility>

namespace trackservo::sim {
namespace {

AxisRow row_of(const TruthState& truth, const Machine& machine, int axis, double tracking_error_rad) {
  const std::size_t i = static_cast<std::size_t>(axis);
  const servo_axis_signals& signals = machine.firmware(axis).signals;
  AxisRow row{};
  row.reference_rad_s = static_cast<double>(signals.reference.rate_rad_s);
  row.rate_rad_s = truth.inertial_rate_rad_s[i];
  row.measured_rate_rad_s = static_cast<double>(signals.rates.feedback_rad_s);
  row.joint_rate_rad_s = truth.joint_rate_rad_s[i];
  row.joint_angle_rad = truth.joint_angle_rad[i];
  row.torque_nm = truth.motor_torque_nm[i];
  row.friction_nm = truth.friction_torque_nm[i];
  row.friction_feedforward_nm = static_cast<double>(signals.torque.friction_nm);
  row.disturbance_estimate_nm = static_cast<double>(signals.torque.disturbance_nm);
  row.load_nm = truth.load_torque_nm[i];
  row.tracking_error_rad = tracking_error_rad;
  row.command_nm = static_cast<double>(signals.torque.torque_nm);
  row.injected_nm = machine.injected_nm(axis);
  return row;
}

// Commands an axis for this tick; one that does not take part holds its inertial rate at zero.
void command_axis(const RunRequest& request, Machine& machine, int axis, double time_s) {
  const ScenarioConfig& scenario = *request.scenario;
  const bool moves = scenario.axes[static_cast<std::size_t>(axis)];
  servo_axis_command& command = machine.command().axis[axis];
  command.mode = SERVO_SPEED;
  command.speed = moves ? speed_set_point(scenario, request.speed_rad_s, time_s) : speed_reference{0.0F, 0.0F};
  machine.inject_torque(axis, moves ? disturbance_nm(*request.plant, scenario, axis, time_s) : 0.0);
}

Trace run_once(const RunRequest& request) {
  const ScenarioConfig& scenario = *request.scenario;
  Machine machine(*request.plant, request.params, request.seed, scenario.initial_joint_angle_rad);
  const int ticks = static_cast<int>(std::lround(scenario.duration_s / kTick_s));
  Trace trace;
  trace.reserve(static_cast<std::size_t>(ticks));
  for (int tick = 0; tick < ticks; ++tick) {
    const double time_s = tick * kTick_s;
    for (int axis = 0; axis < kAxes; ++axis) {
      command_axis(request, machine, axis, time_s);
    }
    const TruthState truth = machine.truth();
    machine.advance_tick();
    trace.push_back(trace_row(time_s, truth, machine));
  }
  return trace;
}

}  // namespace

speed_reference speed_set_point(const ScenarioConfig& scenario, double speed_rad_s, double time_s) {
  const double t = time_s - scenario.rest_s;
  if (t < 0.0) {
    return {0.0F, 0.0F};
  }
  if (scenario.kind == ScenarioKind::kSpeedSine) {
    const double w = 2.0 * kPi * scenario.frequency_hz;
    return {static_cast<float>(speed_rad_s * std::sin(w * t)), static_cast<float>(speed_rad_s * w * std::cos(w * t))};
  }
  return {static_cast<float>(speed_rad_s), 0.0F};
}

double disturbance_nm(const PlantConfig& plant, const ScenarioConfig& scenario, int axis, double time_s) {
  const double t = time_s - scenario.rest_s;
  if (scenario.disturbance_amplitude_rad_s == 0.0 || t < 0.0) {
    return 0.0;
  }
  const double w = 2.0 * kPi * scenario.disturbance_frequency_hz;
  const double pitch_rad = scenario.initial_joint_angle_rad[kPitch];
  return axis_inertia_kg_m2(plant, axis, pitch_rad) * scenario.disturbance_amplitude_rad_s * w * std::cos(w * t);
}

std::vector<ScenarioConfig> runs_of(const ScenarioConfig& scenario) {
  if (scenario.axes_move == AxesMove::kTogether) {
    return {scenario};
  }
  std::vector<ScenarioConfig> runs;
  for (std::size_t axis = 0; axis < kAxes; ++axis) {
    if (scenario.axes[axis]) {
      runs.push_back(scenario);
      runs.back().axes = {};
      runs.back().axes[axis] = true;
    }
  }
  return runs;
}

void add_run(Trace& trace, const ScenarioConfig& run, Trace of_run) {
  if (trace.empty()) {
    trace = std::move(of_run);
    return;
  }
  for (std::size_t axis = 0; axis < kAxes; ++axis) {
    for (std::size_t row = 0; run.axes[axis] && row < trace.size(); ++row) {
      trace[row].axis[axis] = of_run.at(row).axis[axis];
    }
  }
}

TraceRow trace_row(double time_s, const TruthState& truth, const Machine& machine,
                   const std::array<double, kAxes>& tracking_error_rad) {
  TraceRow row{};
  row.time_s = time_s;
  for (int axis = 0; axis < kAxes; ++axis) {
    const auto i = static_cast<std::size_t>(axis);
    row.axis[i] = row_of(truth, machine, axis, tracking_error_rad[i]);
  }
  return row;
}

Trace run_scenario(const RunRequest& request) {
  Trace trace;
  for (const ScenarioConfig& run : runs_of(*request.scenario)) {
    RunRequest part = request;
    part.scenario = &run;
    add_run(trace, run, run_once(part));
  }
  return trace;
}

}  // namespace trackservo::sim
