// SPDX-License-Identifier: Apache-2.0
// Angular sway of the base under one axis: a mast or vehicle resonance driven by white noise.
//
// Angle and rate are exact at the ticks (shaped_noise.hpp). Within a tick the angle is the cubic through the angle and
// rate at both ends, so angle, rate and mean acceleration over a PWM period are consistent.
#ifndef TRACKSERVO_SIM_PLANT_BASE_SWAY_HPP
#define TRACKSERVO_SIM_PLANT_BASE_SWAY_HPP

#include <cstdint>

#include "machine/config/plant_config.hpp"
#include "machine/plant/shaped_noise.hpp"

namespace trackservo::sim {

// The rate over one tick: a polynomial of its fraction 0..1.
template <class Real>
struct SwayRate {
  Real start_rad_s{};
  Real linear_rad_s{};
  Real square_rad_s{};

  Real at(double u) const { return start_rad_s + u * (linear_rad_s + u * square_rad_s); }
};

class BaseSway {
 public:
  BaseSway(const BaseSwayConfig& config, std::uint64_t seed, int axis);

  // Draws the state at the end of the coming tick.
  void begin_tick();

  // Returns angle [rad] and rate [rad/s] at a fraction 0..1 of the tick.
  double angle_rad(double u) const { return start_angle_rad_ + u * (linear_ + u * (square_ + u * cubic_)); }
  double rate_rad_s(double u) const { return rate_.at(u); }
  const SwayRate<double>& rate() const { return rate_; }

 private:
  bool moves_;
  ShapedNoise sway_;
  double start_angle_rad_ = 0;
  double linear_ = 0;
  double square_ = 0;
  double cubic_ = 0;
  SwayRate<double> rate_;
};

}  // namespace trackservo::sim

#endif
