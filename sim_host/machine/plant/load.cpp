// SPDX-License-Identifier: Apache-2.0
#include "machine/plant/load.hpp"

#include <cmath>

namespace trackservo::sim {

ExternalLoad::ExternalLoad(const LoadConfig& config, std::uint64_t seed, int axis)
    : config_(config),
      gust_(ShapedNoise::two_poles(config.wind_turbulence_corner_hz, config.wind_admittance_corner_hz,
                                   config.wind_gust_rms_nm, kTick_s, RandomStream(seed, "load.gust", axis))),
      broadband_(seed, "load.broadband", axis),
      gust_nm_(gust_.state()[0]) {}

LoadOfTick<double> ExternalLoad::begin_tick() {
  LoadOfTick<double> tick;
  tick.cable_stiffness_nm_rad = config_.cable_stiffness_nm_rad;
  tick.cable_nm = -config_.cable_stiffness_nm_rad * config_.cable_neutral_rad;
  tick.wind_nm = config_.wind_mean_nm + gust_nm_;
  if (config_.wind_gust_rms_nm > 0.0) {
    const double next_nm = gust_.next()[0];
    tick.wind_change_nm = next_nm - gust_nm_;
    gust_nm_ = next_nm;
  }
  if (config_.broadband_rms_nm > 0.0) {
    tick.wind_nm += config_.broadband_rms_nm * broadband_.normal();
  }
  return tick;
}

FrictionDrift::Factors FrictionDrift::at(double time_s, double load_nm) const {
  const double temperature_k = config_.temperature_end_k + (config_.temperature_start_k - config_.temperature_end_k) *
                                                               std::exp(-time_s / config_.temperature_time_constant_s);
  return {(1.0 + config_.level_per_load_1_nm * std::abs(load_nm)) * std::exp(config_.level_per_k * temperature_k),
          std::exp(config_.viscosity_per_k * temperature_k)};
}

}  // namespace trackservo::sim
