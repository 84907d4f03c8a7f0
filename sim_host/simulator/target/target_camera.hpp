// An image processor that looks at a scenario's target through a pinhole camera on both joints. What it finds it gives
// as the frames of one PDO.
#ifndef TRACKSERVO_SIM_TARGET_TARGET_CAMERA_HPP
#define TRACKSERVO_SIM_TARGET_TARGET_CAMERA_HPP

#include <algorithm>
#include <array>
#include <cstdint>
#include <optional>

#include "config/scenario_config.hpp"
#include "plant/truth.hpp"
#include "sensors/camera.hpp"
#include "sensors/camera_sender.hpp"
#include "target/fly_by.hpp"

namespace trackservo::sim {

class TargetCamera {
 public:
  static constexpr std::uint32_t kCobId = 0x501;

  // The target begins its course when the machine's time is `begin_s`; until then it stands where it begins.
  TargetCamera(const ScenarioConfig& scenario, std::uint64_t seed, double begin_s = 0.0)
      : config_(scenario),
        target_(scenario.fly_by),
        camera_(pinhole(scenario.camera), seed),
        sender_(kCobId),
        begin_s_(begin_s) {}

  // Azimuth and pitch of the target where it begins.
  std::array<double, kAxes> first_angle_rad() const { return target_.at(0.0).angle_rad; }

  // Exposes when a frame is due; the frame of an earlier exposure when it is ready. Call it once per ms. `misstated_s`
  // is added to its age.
  std::optional<can_frame> look(const TruthState& truth, double misstated_s = 0.0) {
    camera_.expose(truth.time_s,
                   picture_of(target_.position_m(course_s(truth.time_s)), pose_of(truth), config_.camera.mounting));
    std::optional<CameraFrame> result = camera_.poll(truth.time_s);
    if (result) {
      result->delay_s += misstated_s;
    }
    return result ? std::optional(sender_.frame_of(*result)) : std::nullopt;
  }

  // Target minus line of sight: of the joints, or along cross-elevation and elevation, as the scenario says.
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

  static CameraConfig pinhole(CameraConfig config) {
    config.geometry = CameraGeometry::kLineOfSight;
    return config;
  }

  ScenarioConfig config_;
  FlyBy target_;
  Camera camera_;
  CameraSender sender_;
  double begin_s_;
};

}  // namespace trackservo::sim

#endif
