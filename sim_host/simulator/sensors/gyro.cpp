#include "sensors/gyro.hpp"

#include <algorithm>
#include <cmath>

namespace trackservo::sim {

Gyro::Gyro(const GyroConfig& config, double dt_s, double tick_s, std::uint64_t seed, int axis)
    : config_(config),
      signal_(config.bandwidth_hz, config.filter_order, dt_s),
      noise_filter_(config.bandwidth_hz, config.filter_order, tick_s),
      history_(config.latency_s, dt_s),
      noise_(seed, "gyro.noise", axis),
      noise_rms_rad_s_(config.noise_density_rad_s_rthz * std::sqrt(0.5 / tick_s)) {}

Gyro::Reading Gyro::sample() {
  double rate = (1.0 + config_.scale_error) * history_.delayed() + config_.bias_rad_s;
  if (noise_rms_rad_s_ > 0.0) {
    rate += noise_filter_.advance_held(noise_rms_rad_s_ * noise_.normal());
  }
  const double clipped = std::clamp(rate, -config_.range_rad_s, config_.range_rad_s);
  return {clipped, clipped == rate};
}

}  // namespace trackservo::sim
