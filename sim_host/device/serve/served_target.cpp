// SPDX-License-Identifier: Apache-2.0
#include "device/serve/served_target.hpp"

#include <fmt/format.h>
#include <fmt/ostream.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <stdexcept>
#include <utility>

#include "device/serve/video_stream.hpp"

extern "C" {
#include "drive/drive_axis.h"
}

namespace trackservo::sim {
namespace {

constexpr double kUrad = 1e-6;

// The camera model and the image processor's end of the bus.
class CameraOnBus : public SceneObserver {
 public:
  CameraOnBus(const CameraConfig& config, std::uint64_t seed, VirtualBus& bus, std::uint32_t cob_id,
              std::function<void()> strobe)
      : processor_(config, seed, cob_id),
        bus_(bus),
        port_(bus.attach([](const can_frame&) {})),
        strobe_(std::move(strobe)) {}
  ~CameraOnBus() override { bus_.detach(port_); }

  void observe(const Scene& scene) override {
    const std::optional<Eigen::Vector3d> seen = scene.visible ? std::optional(scene.target_m) : std::nullopt;
    const std::optional<can_frame> frame = processor_.look(scene.time_s, seen, scene.pose);
    if (processor_.exposed()) {
      strobe_();
    }
    if (frame) {
      bus_.send(port_, *frame);  // a full queue: the frame is lost, as on a wire
    }
  }

 private:
  ImageProcessor processor_;
  VirtualBus& bus_;
  VirtualBus::Port port_;
  std::function<void()> strobe_;
};

// What the line of sight truly misses, for tests and studies.
class TruthLog : public SceneObserver {
 public:
  TruthLog(const std::filesystem::path& file, const PictureMounting& mounting) : mounting_(mounting), stream_(file) {
    fmt::print(stream_,
               "time_s,flight_s,visible,azimuth_rad,pitch_rad,target_azimuth_rad,target_pitch_rad,range_m,"
               "cross_elevation_error_urad,elevation_error_urad\n");
    if (!stream_.flush()) {
      throw std::runtime_error(fmt::format("{}: cannot be written; give an existing, writable folder", file.string()));
    }
  }

  void observe(const Scene& scene) override {
    if (!scene.flight_s) {
      return;
    }
    const Eigen::Vector3d& target_m = scene.target_m;
    const std::array<double, kAxes> error_rad = pointing_error_of(target_m, scene.pose, mounting_);
    fmt::print(stream_, "{:.3f},{:.3f},{},{:.7f},{:.7f},{:.7f},{:.7f},{:.2f},{:.3f},{:.3f}\n", scene.time_s,
               *scene.flight_s, scene.visible ? 1 : 0, scene.pose.joint_angle_rad[kAzimuth],
               scene.pose.joint_angle_rad[kPitch], std::atan2(target_m.y(), target_m.x()),
               std::atan2(target_m.z(), std::hypot(target_m.x(), target_m.y())), target_m.norm(),
               error_rad[kAzimuth] / kUrad, error_rad[kPitch] / kUrad);
  }

 private:
  PictureMounting mounting_;
  std::ofstream stream_;
};

const ScenarioConfig& tracking_scenario(const TargetOptions& options) {
  if (!options.scenario || options.scenario->kind != ScenarioKind::kTracking) {
    throw std::invalid_argument("--target: the scenario has no target; give one with kind = \"tracking\"");
  }
  return *options.scenario;
}

// The middle of the scenario's sensor: small enough to be rendered and read in real time.
PictureSceneConfig seen_by(const CameraConfig& camera) {
  constexpr double kHorizon_rad = 0.048;  // below the start of the shipped fly-by, within the picture
  PictureSceneConfig config;
  config.width_px = std::min(config.width_px, camera.width_px);
  config.height_px = std::min(config.height_px, camera.height_px);
  config.pixel_rad = camera.pixel_rad;
  config.mounting = camera.mounting;
  config.horizon_rad = kHorizon_rad;
  return config;
}

}  // namespace

std::unique_ptr<SceneObserver> make_observer(const CameraConfig& camera, std::uint64_t seed, VirtualBus& bus,
                                             std::uint32_t cob_id, std::function<void()> strobe) {
  CameraConfig config = camera;
  config.dropouts_at_s.clear();  // the scene has them, by the time of the flight
  return std::make_unique<CameraOnBus>(config, seed, bus, cob_id, std::move(strobe));
}

ServedTarget::ServedTarget(const TargetOptions& options, std::uint64_t seed, VirtualBus& bus,
                           std::function<void()> strobe)
    : scenario_(tracking_scenario(options)), target_(scenario_.fly_by) {
  if (options.video.empty()) {
    observers_.push_back(make_observer(scenario_.camera, seed, bus, options.camera_cob_id, std::move(strobe)));
  } else {
    auto video =
        std::make_unique<VideoStream>(options.video, seen_by(scenario_.camera), scenario_.camera.frame_rate_hz, seed);
    video_address_ = video->address();
    observers_.push_back(std::move(video));
  }
  if (!options.truth_csv.empty()) {
    observers_.push_back(std::make_unique<TruthLog>(options.truth_csv, scenario_.camera.mounting));
  }
}

Scene ServedTarget::scene_of(const TruthState& truth) const {
  Scene scene;
  scene.time_s = truth.time_s;
  scene.pose = pose_of(truth);
  double at_s = 0.0;
  if (started_s_) {
    at_s = truth.time_s - *started_s_;
    const CameraConfig& camera = scenario_.camera;
    const auto drops_out = [&](double from_s) {
      return at_s + kSceneTolerance_s >= from_s && at_s + kSceneTolerance_s < from_s + camera.dropout_s;
    };
    scene.flight_s = at_s;
    scene.visible = at_s < scenario_.duration_s &&
                    std::none_of(camera.dropouts_at_s.begin(), camera.dropouts_at_s.end(), drops_out);
  }
  scene.target_m = target_.position_m(at_s);
  return scene;
}

void ServedTarget::tick(const TruthState& truth, const std::array<std::uint8_t, kAxes>& tracking) {
  const std::uint8_t furthest = *std::max_element(tracking.begin(), tracking.end());
  if (furthest == DRIVE_NOT_TRACKING) {
    started_s_.reset();
  } else if (furthest >= DRIVE_ACQUIRING && !started_s_) {
    started_s_ = truth.time_s;
  }
  const Scene scene = scene_of(truth);
  for (const auto& observer : observers_) {
    observer->observe(scene);
  }
}

}  // namespace trackservo::sim
