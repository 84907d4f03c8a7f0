// SPDX-License-Identifier: Apache-2.0
// A camera whose picture is turned, mirrored or scaled, before axes that track, and how far it drives them.
#ifndef TRACKSERVO_TESTS_SUPPORT_TURNED_PICTURE_HPP
#define TRACKSERVO_TESTS_SUPPORT_TURNED_PICTURE_HPP

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <random>
#include <vector>

struct TurnedPicture {
  const char *name = "right";
  double roll_deg = 0;
  bool mirrored = false;  // its x
  double scale = 1;

  // What the image processor measures of a true error.
  std::array<double, 2> seen(double x, double y) const {
    const double roll_rad = roll_deg * 3.141592653589793 / 180.0;
    const double across = mirrored ? -x : x;
    return {scale * (std::cos(roll_rad) * across - std::sin(roll_rad) * y),
            scale * (std::sin(roll_rad) * across + std::cos(roll_rad) * y)};
  }
};

// A target at joint angles, by the time since it is seen.
using JointPair = std::array<double, 2>;
using TurnedTarget = std::function<JointPair(double)>;

struct PictureCamera {
  int period_ticks = 20;
  int age_ticks = 20;
  double noise_rad = 2.3e-6;
  double view_rad = 0.032;  // the target is seen up to here
  std::uint64_t seed = 1;   // of the noise
};

// What a camera and an observer see of a run, ms by ms.
class PictureRun {
 public:
  PictureRun(const TurnedPicture& picture, const PictureCamera& camera, TurnedTarget target)
      : picture_(picture), camera_(camera), target_(std::move(target)), draw_(camera.seed) {}

  // Of one frame.
  struct Frame {
    int x_urad;
    int y_urad;
    int age_ticks;
    bool found;
  };

  // The axes are at these angles; returns whether a frame arrives now.
  bool look(const JointPair& joints_rad, Frame *frame) {
    const JointPair at = target_(1e-3 * static_cast<double>(true_.size()));
    true_.push_back({(at[0] - joints_rad[0]) * std::cos(joints_rad[1]), at[1] - joints_rad[1]});
    if (!paths_rad_.empty()) {
      way_rad_ += std::hypot(joints_rad[0] - paths_rad_.back()[0], joints_rad[1] - paths_rad_.back()[1]);
    }
    ways_rad_.push_back(way_rad_);
    paths_rad_.push_back(joints_rad);
    const int exposed = static_cast<int>(true_.size()) - 1 - camera_.age_ticks;
    if (exposed < 0 || exposed % camera_.period_ticks != 0) {
      return false;
    }
    const JointPair& error = true_[static_cast<std::size_t>(exposed)];
    const std::array<double, 2> seen = picture_.seen(error[0], error[1]);
    const bool found = std::abs(seen[0]) < camera_.view_rad && std::abs(seen[1]) < camera_.view_rad;
    *frame = {found ? count(seen[0]) : 0, found ? count(seen[1]) : 0, camera_.age_ticks, found};
    return true;
  }

  double error_rad() const { return std::hypot(true_.back()[0], true_.back()[1]); }

  // That both joints have gone, after each tick.
  const std::vector<double>& ways_rad() const { return ways_rad_; }

 private:
  int count(double seen_rad) {
    return static_cast<int>(std::lround((seen_rad + camera_.noise_rad * noise_(draw_)) * 1e6));
  }

  TurnedPicture picture_;
  PictureCamera camera_;
  TurnedTarget target_;
  std::vector<JointPair> true_;
  std::vector<JointPair> paths_rad_;
  std::vector<double> ways_rad_;
  double way_rad_ = 0;
  std::mt19937_64 draw_;
  std::normal_distribution<double> noise_;
};

#endif
