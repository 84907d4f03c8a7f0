// SPDX-License-Identifier: Apache-2.0
// An image processor whose target leads the axes at random, and whose frames are often wrong: of any age, repeated,
// with counters that jump, without a target, or missing.
//
// The target is one of these:
//
//   at joint angles that move     at the rate of `lead`, but never out of the picture: towards an end and beyond, or
//   through
//                                 the zenith
//   on a straight path            that begins where the line of sight is; it may leave the picture
//   always ahead                  at the same place in the picture, whatever the axes do
//   swinging, or jumping          in the picture, whatever the axes do
#ifndef TRACKSERVO_SIM_ATTACK_RANDOM_CAMERA_HPP
#define TRACKSERVO_SIM_ATTACK_RANDOM_CAMERA_HPP

#include <Eigen/Core>
#include <array>
#include <cstdint>
#include <optional>

#include "machine/base/random.hpp"
#include "machine/plant/truth.hpp"
#include "machine/sensors/camera_sender.hpp"

namespace trackservo::sim {

class RandomCamera {
 public:
  // Keeps a reference to `random`, which must exist longer.
  RandomCamera(std::uint32_t cob_id, SplitMix64& random) : cob_id_(cob_id), random_(random), sender_(cob_id) {}

  // Begins another target from now on, for 0.2 to 4 s. Then the frames stop or have no target for a while.
  void begin(double time_s);

  // Does the same with a target that leads the axes, and is seen for so long at least.
  void begin_to_lead(double time_s, double seen_s);

  // Sets the rate at which targets lead an axis.
  void lead(int axis, double rate_rad_s) { lead_rad_s_[static_cast<std::size_t>(axis)] = rate_rad_s; }

  bool has_begun() const { return camera_.has_value(); }

  // Returns the frame that arrives. Call once per tick. The target stays where an axis looks that does not track.
  std::optional<can_frame> look(double time_s, const TruthState& truth, const std::array<bool, kAxes>& tracks);

 private:
  enum class Target { kMoving, kStraight, kAhead, kSwinging, kJumping };

  double uniform(double low, double high) { return low + (high - low) * random_.uniform(); }
  bool chance(double probability) { return random_.uniform() < probability; }
  std::uint32_t below(std::uint32_t count) { return static_cast<std::uint32_t>(random_() % count); }
  Target random_target();
  std::array<double, kAxes> place(double time_s, const TruthState& truth, const std::array<bool, kAxes>& tracks);
  std::array<double, kAxes> place_of_moving(const TruthState& truth, const std::array<bool, kAxes>& tracks);
  std::array<double, kAxes> place_of_straight(double time_s, const TruthState& truth);
  std::optional<can_frame> disturbed(can_frame frame);

  std::uint32_t cob_id_;
  SplitMix64& random_;
  CameraSender sender_;
  std::optional<Camera> camera_;
  std::array<double, kAxes> lead_rad_s_{};
  Target target_ = Target::kMoving;
  double seen_until_s_ = 0;
  double next_s_ = 0;       // another target begins
  bool silent_ = false;     // after seen_until_s_; otherwise there are frames without a target
  double wrong_share_ = 0;  // of the frames
  double misstated_s_ = 0;  // added to the age
  double swing_hz_ = 1;
  std::array<double, kAxes> amplitude_rad_{};  // in the picture
  std::array<double, kAxes> angle_rad_{};      // kMoving: where the target is
  std::optional<double> straight_from_s_;      // kStraight: the path has begun
  Eigen::Vector3d position_m_ = Eigen::Vector3d::Zero();
  Eigen::Vector3d velocity_m_s_ = Eigen::Vector3d::Zero();
  can_frame last_{};
};

}  // namespace trackservo::sim

#endif
