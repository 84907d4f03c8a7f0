// SPDX-License-Identifier: Apache-2.0
#include "judge/attack/random_camera.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace trackservo::sim {
namespace {

constexpr double kPixel_rad = 11.5e-6;
constexpr int kWidth_px = 5600;           // nearly all that 16 bits of 1 urad can say
constexpr double kMaxAhead_rad = 0.030;   // within that picture
constexpr double kInPicture_rad = 0.025;  // where a target at joint angles waits for an axis
constexpr double kRange_m = 1000.0;
constexpr double kPipeline = 14.0;  // frames in progress: fewer than `Camera` keeps

CameraConfig random_config(double rate_hz, double delay_s) {
  CameraConfig config;
  config.frame_rate_hz = rate_hz;
  config.delay_s = delay_s;
  config.pixel_rad = kPixel_rad;
  config.width_px = kWidth_px;
  config.height_px = kWidth_px;
  config.geometry = CameraGeometry::kLineOfSight;
  return config;
}

}  // namespace

RandomCamera::Target RandomCamera::random_target() {
  const double kind = random_.uniform();
  return kind < 0.4    ? Target::kMoving
         : kind < 0.55 ? Target::kStraight
         : kind < 0.8  ? Target::kAhead
         : kind < 0.9  ? Target::kSwinging
                       : Target::kJumping;
}

void RandomCamera::begin(double time_s) {
  const double rate_hz = 10.0 * std::pow(50.0, random_.uniform());
  const double delay_s = std::min(uniform(0.0, 0.12), kPipeline / rate_hz);
  camera_.emplace(random_config(rate_hz, delay_s), random_());
  if (chance(0.1)) {
    sender_ = CameraSender(cob_id_);  // restarted
  }
  target_ = random_target();
  seen_until_s_ = time_s + 0.2 * std::pow(20.0, random_.uniform());
  next_s_ = seen_until_s_ + 0.1 * std::pow(50.0, random_.uniform());
  silent_ = chance(0.7);
  wrong_share_ = chance(0.5) ? 0.0 : uniform(0.0, 0.5);
  misstated_s_ = chance(0.7) ? 0.0 : uniform(-0.02, 0.1);
  swing_hz_ = 0.3 * std::pow(50.0, random_.uniform());
  for (double& amplitude_rad : amplitude_rad_) {
    amplitude_rad = chance(0.3) ? 0.0 : uniform(0.001, kMaxAhead_rad);
  }
  straight_from_s_.reset();
}

void RandomCamera::begin_to_lead(double time_s, double seen_s) {
  begin(time_s);
  target_ = chance(0.5) ? Target::kAhead : Target::kMoving;
  seen_until_s_ = std::max(seen_until_s_, time_s + seen_s);
  next_s_ = std::max(next_s_, seen_until_s_ + uniform(0.1, 5.0));
  wrong_share_ = chance(0.5) ? 0.0 : wrong_share_;
  for (double& amplitude_rad : amplitude_rad_) {
    amplitude_rad = std::max(amplitude_rad, uniform(0.0, kMaxAhead_rad));
  }
}

// At joint angles. It waits at the edge of the picture for axes that are slower.
std::array<double, kAxes> RandomCamera::place_of_moving(const TruthState& truth,
                                                        const std::array<bool, kAxes>& tracks) {
  for (std::size_t i = 0; i < kAxes; ++i) {
    const double looks_rad = truth.inertial_angle_rad[i];
    const double moved_rad = angle_rad_[i] + lead_rad_s_[i] * 1e-3;
    angle_rad_[i] =
        tracks[i] ? std::clamp(moved_rad, looks_rad - kInPicture_rad, looks_rad + kInPicture_rad) : looks_rad;
  }
  const PicturePose of_target{angle_rad_, truth.base};
  return picture_of(kRange_m * camera_axes_of(of_target, 0.0).col(0), pose_of(truth), {});
}

std::array<double, kAxes> RandomCamera::place_of_straight(double time_s, const TruthState& truth) {
  if (!straight_from_s_) {
    const Eigen::Matrix3d axes = camera_axes_of(pose_of(truth), 0.0);
    straight_from_s_ = time_s;
    position_m_ = kRange_m * axes.col(0);
    velocity_m_s_ = kRange_m * (lead_rad_s_[kAzimuth] * axes.col(1) + lead_rad_s_[kPitch] * axes.col(2));
  }
  return picture_of(position_m_ + (time_s - *straight_from_s_) * velocity_m_s_, pose_of(truth), {});
}

std::array<double, kAxes> RandomCamera::place(double time_s, const TruthState& truth,
                                              const std::array<bool, kAxes>& tracks) {
  if (target_ == Target::kMoving) {
    return place_of_moving(truth, tracks);
  }
  if (target_ == Target::kStraight) {
    return place_of_straight(time_s, truth);
  }
  std::array<double, kAxes> place{};
  for (std::size_t i = 0; i < kAxes; ++i) {
    const double share = target_ == Target::kAhead      ? (lead_rad_s_[i] < 0.0 ? -1.0 : 1.0)
                         : target_ == Target::kSwinging ? std::sin(2.0 * kPi * swing_hz_ * time_s)
                                                        : uniform(-1.0, 1.0);
    place[i] = share * amplitude_rad_[i];
  }
  return place;
}

// As a bad sender, or a bad bus, would do it.
std::optional<can_frame> RandomCamera::disturbed(can_frame frame) {
  switch (below(6)) {
    case 0:
      return std::nullopt;
    case 1:
      return last_;
    case 2:
      frame.data[7] = static_cast<std::uint8_t>(frame.data[7] + below(256));
      break;
    case 3:
      frame.data[4] = static_cast<std::uint8_t>(below(256));
      frame.data[5] = static_cast<std::uint8_t>(below(chance(0.5) ? 50 : 256));
      break;
    case 4:
      frame.data[6] = static_cast<std::uint8_t>(below(256));
      break;
    default:
      for (int i = 0; i < 4; ++i) {
        frame.data[i] = static_cast<std::uint8_t>(below(256));
      }
      break;
  }
  return frame;
}

std::optional<can_frame> RandomCamera::look(double time_s, const TruthState& truth,
                                            const std::array<bool, kAxes>& tracks) {
  if (time_s >= next_s_) {
    begin(time_s);
  }
  constexpr double kNowhere = std::numeric_limits<double>::quiet_NaN();
  const bool seen = time_s < seen_until_s_;
  if (!seen && silent_) {
    return std::nullopt;
  }
  camera_->expose(time_s, seen ? place(time_s, truth, tracks) : std::array<double, kAxes>{kNowhere, kNowhere});
  std::optional<CameraFrame> result = camera_->poll(time_s);
  if (!result) {
    return std::nullopt;
  }
  result->delay_s += misstated_s_;
  const can_frame frame = sender_.frame_of(*result);
  const std::optional<can_frame> sent = chance(wrong_share_) ? disturbed(frame) : std::optional(frame);
  last_ = frame;
  return sent;
}

}  // namespace trackservo::sim
