// SPDX-License-Identifier: Apache-2.0
#include "machine/plant/base_sway.hpp"

namespace trackservo::sim {

BaseSway::BaseSway(const BaseSwayConfig& config, std::uint64_t seed, int axis)
    : moves_(config.rms_rad > 0.0),
      sway_(ShapedNoise::resonance(config.frequency_hz, config.damping, config.rms_rad, kTick_s,
                                   RandomStream(seed, "base.sway", axis))) {
  if (moves_) {
    start_angle_rad_ = sway_.state()[0];
    rate_.start_rad_s = sway_.state()[1];
  }
}

void BaseSway::begin_tick() {
  if (!moves_) {
    return;
  }
  const Eigen::Vector2d start = sway_.state();
  const Eigen::Vector2d& end = sway_.next();
  const double change = end[0] - start[0];
  const double start_slope = start[1] * kTick_s;
  const double end_slope = end[1] * kTick_s;
  start_angle_rad_ = start[0];
  linear_ = start_slope;
  square_ = 3.0 * change - 2.0 * start_slope - end_slope;
  cubic_ = start_slope + end_slope - 2.0 * change;
  rate_.start_rad_s = start[1];
  rate_.linear_rad_s = 2.0 * square_ / kTick_s;
  rate_.square_rad_s = 3.0 * cubic_ / kTick_s;
}

}  // namespace trackservo::sim
