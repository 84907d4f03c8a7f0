// SPDX-License-Identifier: Apache-2.0
// The fastest PI and observer that meet the requirements of a speed loop.
#ifndef TRACKSERVO_GAIN_DESIGN_SPEED_LOOP_SEARCH_HPP
#define TRACKSERVO_GAIN_DESIGN_SPEED_LOOP_SEARCH_HPP

#include <optional>
#include <vector>

#include "gain_design/margins.hpp"

namespace trackservo::gain_design {

struct SpeedLoopDemand {
  std::vector<LinearMachine> machines;  // all must be good: operating_points()
  SensorNoise noise;
  MinMargins least;
  double max_torque_noise_nm = 0.0;
};

// PI and observer, the two that decide the speed of the loop.
struct SpeedLoopPair {
  double natural_rad_s = 0.0;
  double observer_rad_s = 0.0;
};

// Absent values are chosen.
struct SpeedLoopRequirement {
  std::optional<double> natural_rad_s;
  std::optional<double> observer_rad_s;
  double damping = 1.0;
};

struct SpeedLoopVerdict {
  bool stable = false;
  Margins margins;  // the smallest of all machines
  double torque_noise_nm = 0.0;
};

class SpeedLoopSearch {
 public:
  // Takes sensors, filters and set-point weight from `loop`.
  SpeedLoopSearch(const SpeedLoopDemand& demand, const speed_loop_params& loop, const SpeedLoopRequirement& requirement)
      : demand_(demand), loop_(loop), requirement_(requirement) {}

  // Returns the required values if they are good, otherwise lowered: the observer first, then both. Nothing when no
  // pair down to a hundredth is good.
  std::optional<SpeedLoopPair> best();

  // Returns whether a pair was good except for its torque noise: a low-pass may help.
  bool noise_refused() const { return noise_refused_; }

  SpeedLoopVerdict judge(const SpeedLoopPair& pair) const;

  // Returns the slowest pair that is tried.
  SpeedLoopPair slowest() const;

 private:
  enum class Reserve { kNone, kKept };

  speed_loop_params loop_with(const SpeedLoopPair& pair) const;
  bool is_good(const SpeedLoopPair& pair, Reserve reserve);
  std::optional<SpeedLoopPair> first_good(SpeedLoopPair pair, bool natural_falls, bool observer_falls);
  std::optional<SpeedLoopPair> best_of_both();
  SpeedLoopPair fastest() const;

  const SpeedLoopDemand& demand_;
  speed_loop_params loop_;
  SpeedLoopRequirement requirement_;
  bool noise_refused_ = false;
};

// Returns the rejection of slow disturbances by a pair, as a logarithm.
double rejection(const SpeedLoopPair& pair);

}  // namespace trackservo::gain_design

#endif
