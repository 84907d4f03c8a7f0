// SPDX-License-Identifier: Apache-2.0
// The tracking camera: measures the target's offset from the optical axis, with delay and noise.
//
// At every frame (50 Hz) it takes the place of the target in the picture, turns it into pixels of 11.499 urad, adds
// centroid noise and delivers the result one frame time (20 ms) later (paper section IV.C). Outside the picture, and in
// a dropout, the target is not measured.
//
// The scenario chooses what the place in the picture is:
//
//   CameraGeometry::kPerAxis       target angle minus line of sight, for each axis by itself (the paper's figures)
//   CameraGeometry::kLineOfSight   picture_of() in picture.hpp: a pinhole camera on both joints
//
// Use, every 1 ms tick: camera.expose(t, place); if (auto frame = camera.poll(t)) { ... }
#ifndef TRACKSERVO_SIM_SENSORS_CAMERA_HPP
#define TRACKSERVO_SIM_SENSORS_CAMERA_HPP

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "machine/base/axis.hpp"
#include "machine/base/random.hpp"
#include "machine/sensors/picture.hpp"

namespace trackservo::sim {

enum class CameraGeometry { kPerAxis = 0, kLineOfSight = 1 };

struct CameraConfig {
  double frame_rate_hz = 50;
  double delay_s = 0.02;  // from exposure to the result being available
  double pixel_rad = 11.499e-6;
  int width_px = 1920;   // along azimuth
  int height_px = 1080;  // along pitch
  double centroid_noise_rms_px = 0.2;
  CameraGeometry geometry = CameraGeometry::kPerAxis;
  PictureMounting mounting;           // kLineOfSight only
  double exposure_jitter_s = 0;       // a frame is exposed up to so long before it is due, at random; 0: in a tick
  std::vector<double> dropouts_at_s;  // times from which on the target is not found ...
  double dropout_s = 0;               // ... for so long
};

struct CameraFrame {
  double exposure_time_s = 0;
  double delay_s = 0;                     // from the exposure to the poll that delivered it
  std::array<double, kAxes> error_rad{};  // target minus optical axis, along rows and columns; 0 when not valid
  bool valid = false;                     // target inside the picture, and no dropout
};

class Camera {
 public:
  // Makes a camera with frames at 0, 1/rate, 2/rate, ... s. The seed determines the centroid noise of each axis.
  Camera(const CameraConfig& config, std::uint64_t seed);

  // Shows the camera the scene at a time [s] that never decreases; exposes when a frame is due, otherwise does nothing.
  // At most one frame per call: call at least once per frame time. A NaN counts as "not in the picture". With jitter an
  // exposure is between two calls, and sees the place between theirs on a straight line. Returns whether it has
  // exposed.
  bool expose(double time_s, std::array<double, kAxes> los_error_rad);

  // Returns the oldest frame whose delay has passed, each exactly once, otherwise nothing.
  std::optional<CameraFrame> poll(double time_s);

 private:
  struct Exposure {
    double time_s;
    std::array<double, kAxes> error_rad;
  };

  Exposure between_calls(std::int64_t index, const Exposure& now) const;

  static constexpr int kPipeline = 16;  // frames in progress; delay times frame rate is checked to stay below

  CameraConfig config_;
  std::array<RandomStream, kAxes> noise_;
  std::array<CameraFrame, kPipeline> frames_{};
  std::int64_t exposed_ = 0;    // frames taken
  std::int64_t delivered_ = 0;  // frames delivered
  std::int64_t next_index_ = 0;
  RandomStream jitter_;
  double early_s_ = 0;              // of the next frame
  std::optional<Exposure> before_;  // the last call
};

}  // namespace trackservo::sim

#endif
