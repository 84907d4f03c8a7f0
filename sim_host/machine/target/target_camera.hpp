// SPDX-License-Identifier: Apache-2.0
// An image processor that looks at a target through a pinhole camera on both joints. What it finds it gives as the
// frames of one PDO.
#ifndef TRACKSERVO_SIM_TARGET_TARGET_CAMERA_HPP
#define TRACKSERVO_SIM_TARGET_TARGET_CAMERA_HPP

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <utility>

#include "machine/config/scenario_config.hpp"
#include "machine/plant/truth.hpp"
#include "machine/sensors/camera.hpp"
#include "machine/sensors/camera_sender.hpp"
#include "machine/target/fly_by.hpp"

namespace trackservo::sim {

// Identifier of the camera's frames. No PDO of a node has it as delivered: RPDO4 (0x500 + node id) would take the
// frames for target positions until its mapping is changed.
constexpr std::uint32_t kCameraCobId = 0x541;

// Exposes when a frame is due; the frame of an earlier exposure when it is ready. Once per ms.
class ImageProcessor {
 public:
  // Makes a pinhole camera on both joints, whatever the geometry of `config`.
  ImageProcessor(CameraConfig config, std::uint64_t seed, std::uint32_t cob_id)
      : mounting_(config.mounting), camera_(pinhole(std::move(config)), seed), sender_(cob_id) {}

  // Returns the frame that is ready, if one is. `target_m`: where the target stands; none: not visible. `misstated_s`
  // is added to the frame's age.
  std::optional<can_frame> look(double time_s, const std::optional<Eigen::Vector3d>& target_m, const PicturePose& pose,
                                double misstated_s = 0.0) {
    constexpr double kNowhere = std::numeric_limits<double>::quiet_NaN();
    exposed_ = camera_.expose(
        time_s, target_m ? picture_of(*target_m, pose, mounting_) : std::array<double, kAxes>{kNowhere, kNowhere});
    std::optional<CameraFrame> result = camera_.poll(time_s);
    if (result) {
      result->delay_s += misstated_s;
    }
    return result ? std::optional(sender_.frame_of(*result)) : std::nullopt;
  }

  // Returns whether the last look was an exposure: the camera's strobe rises.
  bool exposed() const { return exposed_; }

 private:
  static CameraConfig pinhole(CameraConfig config) {
    config.geometry = CameraGeometry::kLineOfSight;
    return config;
  }

  PictureMounting mounting_;
  Camera camera_;
  CameraSender sender_;
  bool exposed_ = false;
};

class TargetCamera {
 public:
  // Lets the target begin its course when the machine's time is `begin_s`; until then it stands where it begins.
  TargetCamera(const ScenarioConfig& scenario, std::uint64_t seed, double begin_s = 0.0)
      : config_(scenario),
        target_(scenario.fly_by),
        processor_(scenario.camera, seed, kCameraCobId),
        begin_s_(begin_s) {}

  // Returns azimuth and pitch of the target where it begins.
  std::array<double, kAxes> first_angle_rad() const { return target_.at(0.0).angle_rad; }

  // Returns the frame that is ready, if one is. Call once per ms.
  std::optional<can_frame> look(const TruthState& truth, double misstated_s = 0.0) {
    return processor_.look(truth.time_s, target_.position_m(course_s(truth.time_s)), pose_of(truth), misstated_s);
  }

  // Returns whether the last look was an exposure: the camera's strobe rises.
  bool exposed() const { return processor_.exposed(); }

  // Returns target minus line of sight: of the joints, or along cross-elevation and elevation, as the scenario says.
  std::array<double, kAxes> error_rad(const TruthState& truth) const {
    const double at_s = course_s(truth.time_s);
    if (config_.camera.geometry == CameraGeometry::kLineOfSight) {
      return pointing_error_of(target_.position_m(at_s), pose_of(truth), config_.camera.mounting);
    }
    const LineOfSight los = target_.at(at_s);
    return {los.angle_rad[0] - truth.inertial_angle_rad[0], los.angle_rad[1] - truth.inertial_angle_rad[1]};
  }

 private:
  double course_s(double time_s) const { return std::max(0.0, time_s - begin_s_); }

  ScenarioConfig config_;
  FlyBy target_;
  ImageProcessor processor_;
  double begin_s_;
};

}  // namespace trackservo::sim

#endif
