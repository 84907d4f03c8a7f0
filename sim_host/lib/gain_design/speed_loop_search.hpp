// SPDX-License-Identifier: Apache-2.0
// The fastest PI and observer that meet the requirements of a speed loop, or the ones with the least rate error.
#ifndef TRACKSERVO_GAIN_DESIGN_SPEED_LOOP_SEARCH_HPP
#define TRACKSERVO_GAIN_DESIGN_SPEED_LOOP_SEARCH_HPP

#include <optional>
#include <vector>

#include "gain_design/margins.hpp"
#include "gain_design/rate_error.hpp"

namespace trackservo::gain_design {

struct SpeedLoopDemand {
  std::vector<LinearMachine> machines;  // all must be good: operating_points()
  SensorNoise noise;
  MinMargins least;
  double max_torque_noise_nm = 0.0;
  std::optional<Disturbance> disturbance;
  bool for_least_error = false;  // the rate error is minimised, which needs a disturbance
};

struct SpeedLoopGains {
  double natural_rad_s = 0.0;  // of the PI
  double damping = 1.0;
  double observer_rad_s = 0.0;
  double crossover_rad_s = 0.0;  // of encoder and gyro
};

// Absent values are chosen. Damping and crossover are chosen only together with the others, for the least rate error.
struct SpeedLoopRequirement {
  std::optional<double> natural_rad_s;
  std::optional<double> observer_rad_s;
  std::optional<double> damping;
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
  // gains down to a hundredth are good.
  std::optional<SpeedLoopGains> best();

  // Returns whether gains were good except for their torque noise: a low-pass may help.
  bool noise_refused() const { return noise_refused_; }

  SpeedLoopVerdict judge(const SpeedLoopGains& gains) const;

  // Returns the gains with which the search for the fastest ones ends.
  SpeedLoopGains slowest() const;

  // Returns what the search makes large, as a logarithm: the rejection of slow disturbances, or one over the rate
  // error.
  double merit(const SpeedLoopGains& gains) const;

 private:
  enum class Reserve { kNone, kKept };
  class LeastError;

  speed_loop_params loop_with(const SpeedLoopGains& gains) const;
  bool is_good(const SpeedLoopGains& gains, Reserve reserve);
  SpeedLoopGains gains(double natural_rad_s, double observer_rad_s) const;
  std::optional<SpeedLoopGains> first_good(SpeedLoopGains gains, bool natural_falls, bool observer_falls);
  std::optional<SpeedLoopGains> best_of_both();
  std::optional<double> highest_natural_rad_s(SpeedLoopGains gains);
  SpeedLoopGains fastest() const;

  const SpeedLoopDemand& demand_;
  speed_loop_params loop_;
  SpeedLoopRequirement requirement_;
  bool noise_refused_ = false;
};

}  // namespace trackservo::gain_design

#endif
