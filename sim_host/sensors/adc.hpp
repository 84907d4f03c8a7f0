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

#include "config/plant_config.hpp"
#include "random.hpp"
#include "sensors/rounding.hpp"

namespace trackservo::sim {

class CurrentAdc {
 public:
  CurrentAdc(const AdcConfig& config, std::uint64_t seed, int axis)
      : config_(config),
        current_noise_(seed, "adc.current", axis),
        voltage_noise_(seed, "adc.voltage", axis),
        most_code_(std::ldexp(1.0, config.resolution_bits)),
        current_step_a_(2.0 * config.current_full_scale_a / most_code_),
        voltage_step_v_(config.voltage_full_scale_v / most_code_),
        codes_per_a_(1.0 / current_step_a_),
        codes_per_v_(1.0 / voltage_step_v_) {}

  // Reading of a current [A]. Draws noise.
  double current_a(double true_a) {
    double seen_a = true_a + config_.current_offset_a;
    if (config_.current_noise_rms_a > 0.0) {
      seen_a += config_.current_noise_rms_a * current_noise_.normal();
    }
    const double half = 0.5 * most_code_;
    return current_step_a_ * nearest_whole(std::clamp(seen_a * codes_per_a_, -half, half - 1.0));
  }

  // Reading of the bus voltage [V]. Draws noise.
  double voltage_v(double true_v) {
    double seen_v = true_v;
    if (config_.voltage_noise_rms_v > 0.0) {
      seen_v += config_.voltage_noise_rms_v * voltage_noise_.normal();
    }
    return voltage_step_v_ * nearest_whole(std::clamp(seen_v * codes_per_v_, 0.0, most_code_ - 1.0));
  }

 private:
  AdcConfig config_;
  RandomStream current_noise_;
  RandomStream voltage_noise_;
  double most_code_;
  double current_step_a_;
  double voltage_step_v_;
  double codes_per_a_;
  double codes_per_v_;
};

}  // namespace trackservo::sim

#endif
