// SPDX-License-Identifier: Apache-2.0
#include "machine/sensors/encoder.hpp"

#include <cmath>

#include "machine/sensors/rounding.hpp"

namespace trackservo::sim {

const Keys<EncoderConfig>& encoder_keys() {
  using Config = EncoderConfig;
  static const Keys<EncoderConfig> keys = {
      number("resolution_bits", unit::kNone, {8, 32}, &Config::resolution_bits, "bits per turn"),
      number("jitter_rms_urad", unit::kMicroradian, {0, 1e4}, &Config::jitter_rms_rad, "white noise of a reading")
          .or_else(0),
      number("eccentricity_urad", unit::kMicroradian, {0, 1e5}, &Config::eccentricity_rad,
             "amplitude of the angle error once per turn")
          .or_else(0),
      number("eccentricity_phase_deg", unit::kDegree, {-360, 360}, &Config::eccentricity_phase_rad,
             "phase of the sine at joint angle 0")
          .or_else(0),
      number("subdivision_error_urad", unit::kMicroradian, {0, 1e4}, &Config::subdivision_error_rad,
             "amplitude of the angle error once per line of the disc, from the interpolation between lines")
          .or_else(0),
      number("lines_per_turn", unit::kNone, {1, 1000000}, &Config::lines_per_turn, "lines of the disc").or_else(20000),
      number("latency_us", unit::kMicrosecond, {0, 1e4}, &Config::latency_s, "time from the angle to the reading")
          .or_else(0),
      number("reads_per_tick", unit::kNone, {1, 20}, &Config::reads_per_tick,
             "number of readings averaged per tick, one in each of its last PWM periods")
          .or_else(1),
  };
  return keys;
}

Encoder::Encoder(const EncoderConfig& config, double dt_s, std::uint64_t seed, int axis)
    : config_(config),
      counts_per_rad_(std::ldexp(1.0, config.resolution_bits) / (2.0 * kPi)),
      history_(config.latency_s, dt_s),
      jitter_(seed, "encoder.jitter", axis) {}

std::uint32_t Encoder::reading(double shown_rad) {
  const double angle_rad = shown_rad + config_.jitter_rms_rad * jitter_.nearly_normal();
  const auto counts = static_cast<std::int64_t>(nearest_whole(angle_rad * counts_per_rad_));
  return static_cast<std::uint32_t>(counts) << (32 - config_.resolution_bits);  // whole turns overflow at the top
}

double Encoder::subdivision_rad(double angle_rad) const {
  return config_.subdivision_error_rad == 0.0
             ? 0.0
             : config_.subdivision_error_rad * std::sin(config_.lines_per_turn * angle_rad);
}

// The error of eccentricity is linear in the angle over the few periods of a mean. Differences to the newest reading
// are averaged, so that the mean is correct across the end of the turn.
std::uint32_t Encoder::sample() {
  const double newest_rad = history_.delayed(0);
  double error_rad = 0.0;
  double error_slope = 0.0;
  if (config_.eccentricity_rad != 0.0) {
    error_rad = config_.eccentricity_rad * std::sin(newest_rad + config_.eccentricity_phase_rad);
    error_slope = config_.eccentricity_rad * std::cos(newest_rad + config_.eccentricity_phase_rad);
  }
  const std::uint32_t newest = reading(newest_rad + error_rad + subdivision_rad(newest_rad));
  std::int64_t sum = 0;
  for (int i = 1; i < config_.reads_per_tick; ++i) {
    const double angle_rad = history_.delayed(static_cast<std::size_t>(i));
    const double shown_rad = angle_rad + error_rad + error_slope * (angle_rad - newest_rad);
    sum += static_cast<std::int32_t>(reading(shown_rad + subdivision_rad(angle_rad)) - newest);
  }
  return newest + static_cast<std::uint32_t>(sum / config_.reads_per_tick);
}

std::uint32_t Encoder::read() {
  const double angle_rad = history_.delayed(0);
  return reading(angle_rad + config_.eccentricity_rad * std::sin(angle_rad + config_.eccentricity_phase_rad) +
                 subdivision_rad(angle_rad));
}

}  // namespace trackservo::sim
