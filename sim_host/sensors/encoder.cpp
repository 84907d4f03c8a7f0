#include "sensors/encoder.hpp"

#include <cmath>

namespace trackservo::sim {

Encoder::Encoder(const EncoderConfig& config, double dt_s, std::uint64_t seed, int axis)
    : config_(config), history_(config.latency_s, dt_s), jitter_(seed, "encoder.jitter", axis) {}

std::uint32_t Encoder::reading(std::size_t periods_ago) {
  double angle_rad = history_.delayed(periods_ago);
  if (config_.eccentricity_rad != 0.0) {
    angle_rad += config_.eccentricity_rad * std::sin(angle_rad + config_.eccentricity_phase_rad);
  }
  if (config_.jitter_rms_rad > 0.0) {
    angle_rad += config_.jitter_rms_rad * jitter_.normal();
  }
  const double turns = angle_rad / (2.0 * kPi);
  const double within_turn = turns - std::floor(turns);
  const auto counts = static_cast<std::uint64_t>(std::llround(std::ldexp(within_turn, config_.resolution_bits)));
  return static_cast<std::uint32_t>(counts << (32 - config_.resolution_bits));  // a full turn wraps to zero
}

// Differences to the newest reading are averaged, so that the mean is right across the end of the turn.
std::uint32_t Encoder::sample() {
  const std::uint32_t newest = reading(0);
  std::int64_t sum = 0;
  for (int i = 1; i < config_.reads_per_tick; ++i) {
    sum += static_cast<std::int32_t>(reading(static_cast<std::size_t>(i)) - newest);
  }
  return newest + static_cast<std::uint32_t>(sum / config_.reads_per_tick);
}

}  // namespace trackservo::sim
