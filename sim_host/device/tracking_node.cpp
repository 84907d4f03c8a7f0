// SPDX-License-Identifier: Apache-2.0
#include "device/tracking_node.hpp"

#include <cmath>
#include <optional>

#include "design/control_design.hpp"
#include "machine/plant/base_motion.hpp"
#include "machine/plant/base_spectrum.hpp"

namespace trackservo::sim {
namespace {

constexpr std::int8_t kTracking = -1;
constexpr int kCameraRpdo = 4;
constexpr int kBaseRpdo = 3;
constexpr int kTicksToApply = 8;
// Of the machine's time: until then the axes are enabled, and the motion that the wind gave them without power is over.
constexpr double kBegins_s = 1.0;

// Joint angles that look at the beginning of the course when it begins, on a base that is not level then.
std::array<double, kAxes> first_joint_angles_rad(const NodeSetup& setup, const ScenarioConfig& scenario) {
  const Eigen::Matrix3d base = BaseMotion(base_motion_lines(setup.plant)).at(kBegins_s).attitude;
  const FlyBy course(scenario.fly_by);
  const Eigen::Vector3d seen_m = base.transpose() * course.position_m(0.0);
  const double level_rad = course.at(0.0).angle_rad[kAzimuth];
  const double turned_rad = std::remainder(std::atan2(seen_m.y(), seen_m.x()) - level_rad, 2.0 * kPi);
  return {level_rad + turned_rad, std::atan2(seen_m.z(), std::hypot(seen_m.x(), seen_m.y()))};
}

void write_loop(DrivenNode& node, const target_tracker_params& loop) {
  for (int axis = 0; axis < kAxes; ++axis) {
    node.write(axis, 0x2011, 1, loop.kind);
    node.write_real(axis, 0x2011, 2, static_cast<double>(loop.proportional_per_s));
    node.write_real(axis, 0x2011, 3, static_cast<double>(loop.integral_per_s2));
    node.write_real(axis, 0x2011, 4, static_cast<double>(loop.estimator_rad_s));
    node.write_real(axis, 0x2011, 5, static_cast<double>(loop.coast_s));
    node.write(axis, 0x2070, 1, 1);
  }
}

// All that a master does before it enables the axes.
void prepare(DrivenNode& node, const std::optional<target_tracker_params>& loop) {
  for (const ObjectWrite& write : camera_mapping(kCameraRpdo, kCameraCobId)) {
    node.write(kAzimuth, write.index, write.sub, write.value);
  }
  if (loop) {
    write_loop(node, *loop);
  }
  node.unlock();
  node.write(kAzimuth, 0x2061, 5, 0);  // it stands in this turn: a start beyond 75 deg may be in two
  for (int i = 0; i < kTicksToApply; ++i) {
    node.tick();
  }
  node.receive(can_frame{0x000, 0, 2, {0x01, 0x00}, 0});  // NMT start
}

// Enables both axes in pp, with the cue where they stand.
void enable_at_cue(DrivenNode& node) {
  constexpr std::int64_t kNewSetPointAtOnce = 0x3F;
  std::array<std::int32_t, kAxes> cue{};
  for (int axis = 0; axis < kAxes; ++axis) {
    cue[static_cast<std::size_t>(axis)] = node.axis(axis).objects.position.actual;
  }
  node.enable(DRIVE_PROFILE_POSITION);
  for (int axis = 0; axis < kAxes; ++axis) {
    node.write(axis, 0x607A, 0, cue[static_cast<std::size_t>(axis)]);
    node.write(axis, 0x6040, 0, kNewSetPointAtOnce);
  }
}

// An axis that does not take part holds the rate 0.
void hand_over(DrivenNode& node, const ScenarioConfig& scenario) {
  for (int axis = 0; axis < kAxes; ++axis) {
    const bool tracks = scenario.axes[static_cast<std::size_t>(axis)];
    node.write(axis, 0x6060, 0, tracks ? kTracking : static_cast<std::int8_t>(DRIVE_CYCLIC_VELOCITY));
    node.write(axis, 0x6040, 0, 0x0F);
  }
}

}  // namespace

target_tracker_params designed_tracking_loop(const PlantConfig& plant, tracker_kind kind) {
  DesignOptions design;
  design.tracker = kind;
  return design_controller(plant, controller_spec("pi_vob_ftc"), design).axis[0].tracker;
}

void use_base_rates(DrivenNode& node) {
  for (const ObjectWrite& write : base_sensor_mapping(kBaseRpdo, kBaseSensorCobId)) {
    node.write(kAzimuth, write.index, write.sub, write.value);
  }
  node.unlock();
  for (int axis = 0; axis < kAxes; ++axis) {
    node.write_real(axis, 0x2060, 27, 0.0);
  }
  node.write(kAzimuth, 0x3077, 3, std::lround(kBaseSensorStatedDelay_s / 1e-5));
  node.write(kAzimuth, 0x3077, 1, 1);
}

void start_tracking(DrivenNode& node, const std::optional<target_tracker_params>& loop) {
  prepare(node, loop);
  node.enable(kTracking);
}

TrackingNode::TrackingNode(const NodeSetup& setup, const ScenarioConfig& scenario, std::uint64_t seed,
                           const std::optional<target_tracker_params>& loop, bool base_sensor)
    : camera_(scenario, seed), node_(setup, seed, first_joint_angles_rad(setup, scenario)), chance_(seed, "strobe") {
  if (base_sensor) {
    use_base_rates(node_);
    base_sensor_.emplace(kBaseSensorCobId, seed);
  }
  prepare(node_, loop);
  enable_at_cue(node_);
  while (time_s() < -0.5 * kTick_s) {
    tick();
  }
  hand_over(node_, scenario);
}

TruthState TrackingNode::truth() const {
  TruthState truth = node_.machine().truth();
  truth.time_s -= kBegins_s;
  return truth;
}

void TrackingNode::strobe() {
  constexpr double kLongest_ms = 18.0;  // within the frame time
  if (camera_.exposed()) {
    if (chance_.uniform() >= disturbance_.missing) {
      node_.machine().strobe();
    }
    if (chance_.uniform() < disturbance_.additional) {
      ms_to_additional_ = 1 + static_cast<int>(kLongest_ms * chance_.uniform());
    }
  }
  if (ms_to_additional_ > 0 && --ms_to_additional_ == 0) {
    node_.machine().strobe();
  }
}

void TrackingNode::tick() {
  if (const std::optional<can_frame> frame = camera_.look(truth(), misstated_s_)) {
    if (chance_.uniform() >= disturbance_.lost) {
      node_.receive(*frame);
    }
  }
  if (base_sensor_) {
    if (const std::optional<can_frame> rates = base_sensor_->look(node_.machine().truth().base_turns_rad_s)) {
      node_.receive(*rates);
    }
  }
  strobe();
  node_.tick();
}

}  // namespace trackservo::sim
