// SPDX-License-Identifier: Apache-2.0
#include "machine/sensors/gyro.hpp"

#include <algorithm>
#include <cmath>

namespace trackservo::sim {

const Keys<GyroConfig>& gyro_keys() {
  using Config = GyroConfig;
  static const Keys<GyroConfig> keys = {
      number("noise_density_deg_s_rthz", unit::kDegreePerSecondRootHertz, {0, 1}, &Config::noise_density_rad_s_rthz,
             "one-sided density of the white rate noise"),
      number("bandwidth_hz", unit::kHertz, {1, 5e3}, &Config::bandwidth_hz, "-3 dB bandwidth"),
      number("filter_order", unit::kNone, {1, 2}, &Config::filter_order, "order of the low-pass filter").or_else(1),
      number("bias_deg_s", unit::kDegreePerSecond, {-10, 10}, &Config::bias_rad_s, "constant bias").or_else(0),
      number("scale_error_ppm", unit::kPpm, {-1e5, 1e5}, &Config::scale_error, "scale error of the rate").or_else(0),
      number("range_deg_s", unit::kDegreePerSecond, {0.1, 1e5}, &Config::range_rad_s,
             "rates above this magnitude are clipped and marked invalid"),
      number("latency_us", unit::kMicrosecond, {0, 1e4}, &Config::latency_s, "time from the rate to the reading")
          .or_else(0),
      choice("mounting", {"joint", "line_of_sight", "stage", "base"}, &Config::mounting,
             "part on which the gyro is fixed: what the joint turns, the line of sight, the azimuth stage or the base")
          .or_else(0),
  };
  return keys;
}

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
