// SPDX-License-Identifier: Apache-2.0
#include "machine/sensors/camera.hpp"

#include <algorithm>
#include <cmath>

namespace trackservo::sim {

namespace {

constexpr double kClockTolerance_s = 1e-9;  // sums of ticks do not match frame times exactly

bool drops_out(const CameraConfig& config, double time_s) {
  return std::any_of(config.dropouts_at_s.begin(), config.dropouts_at_s.end(), [&](double from_s) {
    return time_s + kClockTolerance_s >= from_s && time_s + kClockTolerance_s < from_s + config.dropout_s;
  });
}

}  // namespace

Camera::Camera(const CameraConfig& config, std::uint64_t seed)
    : config_(config),
      noise_{RandomStream(seed, "camera.centroid", 0), RandomStream(seed, "camera.centroid", 1)},
      jitter_(seed, "camera.jitter") {}

// The exposure of the frame with this number.
Camera::Exposure Camera::between_calls(std::int64_t index, const Exposure& now) const {
  const double due_s = static_cast<double>(index) / config_.frame_rate_hz - early_s_;
  if (config_.exposure_jitter_s == 0.0 || !before_ || due_s <= before_->time_s || due_s >= now.time_s) {
    return now;
  }
  const double share = (due_s - before_->time_s) / (now.time_s - before_->time_s);
  Exposure exposure{due_s, now.error_rad};
  for (std::size_t axis = 0; axis < kAxes; ++axis) {
    exposure.error_rad[axis] -= (1.0 - share) * (now.error_rad[axis] - before_->error_rad[axis]);
  }
  return exposure;
}

bool Camera::expose(double time_s, std::array<double, kAxes> los_error_rad) {
  const auto present =
      static_cast<std::int64_t>(std::floor((time_s + early_s_ + kClockTolerance_s) * config_.frame_rate_hz));
  const Exposure now{time_s, los_error_rad};
  if (present < next_index_) {
    before_ = now;
    return false;
  }
  const Exposure exposure = between_calls(present, now);
  before_ = now;
  next_index_ = present + 1;
  early_s_ = config_.exposure_jitter_s > 0.0 ? config_.exposure_jitter_s * jitter_.uniform() : 0.0;

  CameraFrame frame;
  frame.exposure_time_s = exposure.time_s;
  frame.valid = !drops_out(config_, exposure.time_s);
  const std::array<double, kAxes> half_picture_px{0.5 * config_.width_px, 0.5 * config_.height_px};
  for (std::size_t axis = 0; axis < kAxes; ++axis) {
    // Drawn also when the target is outside, so that the noise of later frames does not depend on it.
    const double noise_px = config_.centroid_noise_rms_px * noise_[axis].normal();
    const double true_px = exposure.error_rad[axis] / config_.pixel_rad;
    frame.valid = frame.valid && std::abs(true_px) <= half_picture_px[axis];
    frame.error_rad[axis] = (true_px + noise_px) * config_.pixel_rad;
  }
  if (!frame.valid) {
    frame.error_rad = {};
  }
  frames_[static_cast<std::size_t>(exposed_ % kPipeline)] = frame;
  ++exposed_;
  if (exposed_ - delivered_ > kPipeline) {
    delivered_ = exposed_ - kPipeline;  // nobody polled: the oldest frames are lost
  }
  return true;
}

std::optional<CameraFrame> Camera::poll(double time_s) {
  if (delivered_ == exposed_) {
    return std::nullopt;
  }
  CameraFrame frame = frames_[static_cast<std::size_t>(delivered_ % kPipeline)];
  if (time_s + kClockTolerance_s < frame.exposure_time_s + config_.delay_s) {
    return std::nullopt;
  }
  ++delivered_;
  frame.delay_s = time_s - frame.exposure_time_s;
  return frame;
}

}  // namespace trackservo::sim
