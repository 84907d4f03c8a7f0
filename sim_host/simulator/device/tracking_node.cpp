// SPDX-License-Identifier: Apache-2.0
#include "studies/shared/tracking_node.hpp"

#include <cmath>
#include <optional>

#include "design/control_design.hpp"
#include "plant/base_motion.hpp"
#include "plant/base_spectrum.hpp"

namespace trackservo::sim {
namespace {

constexpr std::int8_t kTracking = -1;
constexpr int kCameraRpdo = 4;
constexpr int kBaseRpdo = 3;
constexpr int kTicksToApply = 8;

// Joint angles that look at the beginning of the course, on a base that is not level at time 0.
std::array<double, kAxes> first_joint_angles_rad(const NodeSetup& setup, const ScenarioConfig& scenario) {
  const Eigen::Matrix3d base = BaseMotion(base_motion_lines(setup.plant)).at(0.0).attitude;
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

}  // namespace

void ErrorSpread::add(const std::array<double, kAxes>& error_rad) {
  ++count_;
  for (std::size_t i = 0; i < kAxes; ++i) {
    const double change = error_rad[i] - mean_rad_[i];
    mean_rad_[i] += change / count_;
    squares_rad2_[i] += change * (error_rad[i] - mean_rad_[i]);
  }
}

std::array<double, kAxes> ErrorSpread::sigma_rad() const {
  std::array<double, kAxes> sigma{};
  for (std::size_t i = 0; i < kAxes && count_ > 0; ++i) {
    sigma[i] = std::sqrt(squares_rad2_[i] / count_);
  }
  return sigma;
}

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

void start_tracking(DrivenNode& node, const target_tracker_params& loop) {
  for (const ObjectWrite& write : camera_mapping(kCameraRpdo, kCameraCobId)) {
    node.write(kAzimuth, write.index, write.sub, write.value);
  }
  write_loop(node, loop);
  node.unlock();
  node.write(kAzimuth, 0x2061, 5, 0);  // it stands in this turn: a start beyond 75 deg may be in two
  for (int i = 0; i < kTicksToApply; ++i) {
    node.tick();
  }
  node.receive(can_frame{0x000, 0, 2, {0x01, 0x00}, 0});  // NMT start
  node.enable(kTracking);
}

TrackingNode::TrackingNode(const NodeSetup& setup, const ScenarioConfig& scenario, std::uint64_t seed,
                           const target_tracker_params& loop, bool base_sensor)
    : camera_(scenario, seed), node_(setup, seed, first_joint_angles_rad(setup, scenario)), chance_(seed, "strobe") {
  if (base_sensor) {
    use_base_rates(node_);
    base_sensor_.emplace(kBaseSensorCobId, seed);
  }
  start_tracking(node_, loop);
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
  if (const std::optional<can_frame> frame = camera_.look(node_.machine().truth(), misstated_s_)) {
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
