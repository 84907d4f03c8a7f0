// SPDX-License-Identifier: Apache-2.0
// The converter that reads a motor's current and the bus voltage.
//
//   reading = quantise(clip(value + offset + noise)), step = full range / 2^bits; current range +-full scale
//
// Use: once per PWM period, with the values at that instant.
#ifndef TRACKSERVO_SIM_SENSORS_ADC_HPP
#define TRACKSERVO_SIM_SENSORS_ADC_HPP

#include <algorithm>
#include <cmath>
#include <cstdint>

#include "machine/base/random.hpp"
#include "machine/sensors/rounding.hpp"

namespace trackservo::sim {

struct AdcConfig {
  int resolution_bits = 12;
  double current_full_scale_a = 25;
  double current_noise_rms_a = 0;
  double current_offset_a = 0;
  double voltage_full_scale_v = 80;
  double voltage_noise_rms_v = 0;
};

class CurrentAdc {
 public:
  CurrentAdc(const AdcConfig& config, std::uint64_t seed, int axis)
      : config_(config),
        noise_a_(seed, "adc.current", axis),
        noise_v_(seed, "adc.voltage", axis),
        lowest_a_code_(-std::ldexp(0.5, config.resolution_bits)),
        highest_a_code_(-lowest_a_code_ - 1.0),
        highest_v_code_(std::ldexp(1.0, config.resolution_bits) - 1.0),
        current_step_a_(std::ldexp(2.0 * config.current_full_scale_a, -config.resolution_bits)),
        voltage_step_v_(std::ldexp(config.voltage_full_scale_v, -config.resolution_bits)),
        codes_per_a_(1.0 / current_step_a_),
        codes_per_v_(1.0 / voltage_step_v_) {}

  // Returns the reading of a current [A]. Draws noise.
  double current_a(double true_a) {
    const double seen_a = true_a + config_.current_offset_a + config_.current_noise_rms_a * noise_a_.nearly_normal();
    return current_step_a_ * nearest_whole(std::clamp(seen_a * codes_per_a_, lowest_a_code_, highest_a_code_));
  }

  // Returns the reading of the bus voltage [V]. Draws noise.
  double voltage_v(double true_v) {
    const double seen_v = true_v + config_.voltage_noise_rms_v * noise_v_.nearly_normal();
    return voltage_step_v_ * nearest_whole(std::clamp(seen_v * codes_per_v_, 0.0, highest_v_code_));
  }

 private:
  AdcConfig config_;
  RandomStream noise_a_;
  RandomStream noise_v_;
  double lowest_a_code_;
  double highest_a_code_;
  double highest_v_code_;
  double current_step_a_;
  double voltage_step_v_;
  double codes_per_a_;
  double codes_per_v_;
};

}  // namespace trackservo::sim

#endif
