// SPDX-License-Identifier: Apache-2.0
#include "run/scenario_run.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <stdexcept>
#include <utility>

#include "run/machine.hpp"
#include "sensors/camera.hpp"
#include "target/fly_by.hpp"

namespace trackservo::sim {
namespace {

// `truth` is the machine's state at the time of the set-point.
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

// The target and the camera; absent outside tracking.
class TrackingScene {
 public:
  TrackingScene(const ScenarioConfig& scenario, std::uint64_t seed)
      : target_(scenario.fly_by), config_(scenario.camera), camera_(scenario.camera, seed) {}

  std::array<double, kAxes> start_rad() const { return target_.at(0.0).angle_rad; }

  // Of the joints, or of the boresight along the axes of the picture: as the camera measures it.
  std::array<double, kAxes> error_rad(const TruthState& truth) const {
    if (is_picture()) {
      return pointing_error_of(target_.position_m(truth.time_s), pose_of(truth), config_.mounting);
    }
    const LineOfSight los = target_.at(truth.time_s);
    std::array<double, kAxes> error{};
    for (std::size_t i = 0; i < kAxes; ++i) {
      error[i] = los.angle_rad[i] - truth.inertial_angle_rad[i];
    }
    return error;
  }

  // The result that arrives now, if one does.
  std::optional<CameraFrame> look(const TruthState& truth, const std::array<double, kAxes>& error_rad) {
    camera_.expose(truth.time_s, is_picture()
                                     ? picture_of(target_.position_m(truth.time_s), pose_of(truth), config_.mounting)
                                     : error_rad);
    return camera_.poll(truth.time_s);
  }

 private:
  bool is_picture() const { return config_.geometry == CameraGeometry::kLineOfSight; }

  FlyBy target_;
  CameraConfig config_;
  Camera camera_;
};

camera_alignment alignment_of(const PictureMounting& mounting) {
  const camera_mounting same{
      static_cast<float>(mounting.roll_rad),
      {static_cast<float>(mounting.boresight_x_rad), static_cast<float>(mounting.boresight_y_rad)}};
  return camera_align(&same);
}

// Parameters of the pointing, as the node takes them from those of both axes.
pointing_params pointing_of(const RunRequest& request) {
  const servo_axis_params *axis = request.params.axis;
  pointing_params params{};
  params.tracker.proportional_per_s = axis[SERVO_AZIMUTH].tracker.proportional_per_s;
  params.tracker.estimator_rad_s = axis[SERVO_AZIMUTH].tracker.estimator_rad_s;
  params.tracker.coast_s = axis[SERVO_AZIMUTH].tracker.coast_s;
  params.tracker.rate_limit_rad_s = {axis[SERVO_AZIMUTH].tracker.rate_limit_rad_s,
                                     axis[SERVO_PITCH].tracker.rate_limit_rad_s};
  params.inertia = {axis[SERVO_AZIMUTH].min_inertia_kg_m2,
                    axis[SERVO_AZIMUTH].plant_inertia_kg_m2 - axis[SERVO_AZIMUTH].min_inertia_kg_m2,
                    axis[SERVO_PITCH].plant_inertia_kg_m2};
  params.fed_forward_kg_m2 = {axis[SERVO_AZIMUTH].speed.acceleration_inertia_kg_m2,
                              axis[SERVO_PITCH].speed.acceleration_inertia_kg_m2};
  return params;
}

// What follows the target in the tick of the servo, as in the node.
class Tracking {
 public:
  Tracking(const RunRequest& request, Machine& machine)
      : scenario_(*request.scenario), alignment_(alignment_of(request.scenario->camera.mounting)) {
    const pointing_params params = pointing_of(request);
    if (together() && pointing_configure(&pointing_, &params) != CONTROL_OK) {
      throw std::invalid_argument("the firmware refuses the parameters of the pointing.");
    }
    std::copy_n(scenario_.axes.begin(), kAxes, joints_.tracks);
    machine.on_tick([this](servo_board& board) { tick(board); });
  }

  Tracking(const Tracking&) = delete;
  Tracking& operator=(const Tracking&) = delete;

  // The result of a camera frame that has arrived in the coming tick, or nothing.
  void see(const std::optional<CameraFrame>& frame) { frame_ = frame; }

 private:
  bool together() const { return scenario_.pointing == Pointing::kLineOfSight; }

  void tick(servo_board& board) {
    servo_board_sample(&board);
    const CameraFrame frame = frame_.value_or(CameraFrame{});
    const int age_ticks = static_cast<int>(std::lround(frame.delay_s / kTick_s));
    const std::array<float, kAxes> error_rad = {static_cast<float>(frame.error_rad[0]),
                                                static_cast<float>(frame.error_rad[1])};
    if (together()) {
      follow(board,
             {frame_.has_value(), frame.valid, age_ticks, camera_error(&alignment_, {error_rad[0], error_rad[1]})});
    } else {
      follow(board, joint_frame{frame_.has_value(), frame.valid, age_ticks, {error_rad[kAzimuth], error_rad[kPitch]}});
    }
    servo_board_control(&board);
  }

  void follow(servo_board& board, const pointing_frame& frame) {
    const pointing_motion motion = pointing_motion_of(&board.app, &board.samples);
    const pointing_output out = pointing_step(&pointing_, &frame, &motion, SERVO_TICK_S);
    for (int axis = 0; axis < kAxes; ++axis) {
      board.command.axis[axis].speed = out.reference[axis];
      board.command.axis[axis].torque_nm = out.torque_nm[axis];
    }
    pointing_tracker_prepare(&pointing_.tracker, &pointing_.params.tracker, out.error_of_joints_rad, SERVO_TICK_S);
  }

  void follow(servo_board& board, const joint_frame& frame) {
    servo_target targets[SERVO_AXES];
    joint_tracking_step(&joints_, &board.app, &frame, targets);
    for (int axis = 0; axis < kAxes; ++axis) {
      if (scenario_.axes[static_cast<std::size_t>(axis)]) {
        board.command.axis[axis].speed = targets[axis].reference;
      }
    }
  }

  const ScenarioConfig& scenario_;
  camera_alignment alignment_;
  pointing pointing_{};
  joint_tracking joints_{};
  std::optional<CameraFrame> frame_;
};

// The command of an axis for this tick; an axis that does not take part holds its inertial rate at zero.
void command_axis(const RunRequest& request, Machine& machine, int axis, double time_s) {
  const ScenarioConfig& scenario = *request.scenario;
  const bool moves = scenario.axes[static_cast<std::size_t>(axis)];
  servo_axis_command& command = machine.command().axis[axis];
  command.mode = SERVO_SPEED;
  if (scenario.kind == ScenarioKind::kTracking) {
    return;  // its set-point comes from the camera
  }
  command.speed = moves ? speed_set_point(scenario, request.speed_rad_s, time_s) : speed_reference{0.0F, 0.0F};
  machine.inject_torque(axis, moves ? disturbance_nm(*request.plant, scenario, axis, time_s) : 0.0);
}

Trace run_once(const RunRequest& request) {
  const ScenarioConfig& scenario = *request.scenario;
  std::optional<TrackingScene> scene;
  std::array<double, kAxes> start_rad = scenario.initial_joint_angle_rad;
  if (scenario.kind == ScenarioKind::kTracking) {
    scene.emplace(scenario, request.seed);
    start_rad = scene->start_rad();
  }
  Machine machine(*request.plant, request.params, request.seed, start_rad);
  std::optional<Tracking> tracking;
  if (scene) {
    tracking.emplace(request, machine);
  }

  const int ticks = static_cast<int>(std::lround(scenario.duration_s / kTick_s));
  Trace trace;
  trace.reserve(static_cast<std::size_t>(ticks));
  for (int tick = 0; tick < ticks; ++tick) {
    TraceRow row{};
    row.time_s = tick * kTick_s;
    std::array<double, kAxes> error_rad{};
    if (scene) {
      error_rad = scene->error_rad(machine.truth());
      tracking->see(scene->look(machine.truth(), error_rad));
    }
    for (int axis = 0; axis < kAxes; ++axis) {
      command_axis(request, machine, axis, row.time_s);
    }
    const TruthState truth = machine.truth();
    machine.advance_tick();
    for (int axis = 0; axis < kAxes; ++axis) {
      row.axis[static_cast<std::size_t>(axis)] =
          row_of(truth, machine, axis, error_rad[static_cast<std::size_t>(axis)]);
    }
    trace.push_back(row);
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
