// An image processor on the bus: it looks at a scenario's target through a pinhole camera on both joints, and sends
// what it finds as the camera's PDO.
#ifndef TRACKSERVO_SUPPORT_CAMERA_ON_BUS_HPP
#define TRACKSERVO_SUPPORT_CAMERA_ON_BUS_HPP

#include <array>
#include <cmath>
#include <cstdint>
#include <optional>

#include "config/scenario_config.hpp"
#include "plant/truth.hpp"
#include "sensors/camera.hpp"
#include "sensors/camera_sender.hpp"
#include "target/fly_by.hpp"

namespace bench {

class CameraOnBus {
 public:
  static constexpr std::uint32_t kId = 0x501;

  // The target begins its course when the machine's time is `begin_s`; until then it stands where it begins.
  CameraOnBus(const trackservo::sim::ScenarioConfig& scenario, std::uint64_t seed, double begin_s = 0.0)
      : config_(scenario),
        target_(scenario.fly_by),
        camera_(pinhole(scenario.camera), seed),
        sender_(kId),
        begin_s_(begin_s) {}

  double course_s(double time_s) const { return std::max(0.0, time_s - begin_s_); }

  std::array<double, trackservo::sim::kAxes> first_angle_rad() const { return target_.at(0.0).angle_rad; }

  // Exposes when a frame is due; the frame of an earlier exposure when it is ready. Call it once per ms.
  std::optional<can_frame> look(const trackservo::sim::TruthState& truth) {
    camera_.expose(truth.time_s, trackservo::sim::picture_of(target_.position_m(course_s(truth.time_s)),
                                                             trackservo::sim::pose_of(truth), {}));
    const std::optional<trackservo::sim::CameraFrame> result = camera_.poll(truth.time_s);
    return result ? std::optional(sender_.frame_of(*result)) : std::nullopt;
  }

  // Target minus line of sight: of the joints, or along cross-elevation and elevation, as the scenario says.
  std::array<double, trackservo::sim::kAxes> error_rad(const trackservo::sim::TruthState& truth) const {
    const double course = course_s(truth.time_s);
    if (config_.camera.geometry == trackservo::sim::CameraGeometry::kLineOfSight) {
      return trackservo::sim::pointing_error_of(target_.position_m(course), trackservo::sim::pose_of(truth), {});
    }
    const trackservo::sim::LineOfSight los = target_.at(course);
    return {los.angle_rad[0] - truth.inertial_angle_rad[0], los.angle_rad[1] - truth.inertial_angle_rad[1]};
  }

 private:
  static trackservo::sim::CameraConfig pinhole(trackservo::sim::CameraConfig config) {
    config.geometry = trackservo::sim::CameraGeometry::kLineOfSight;
    return config;
  }

  trackservo::sim::ScenarioConfig config_;
  trackservo::sim::FlyBy target_;
  trackservo::sim::Camera camera_;
  trackservo::sim::CameraSender sender_;
  double begin_s_;
};

}  // namespace bench

#endif
