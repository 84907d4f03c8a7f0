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

namespace trackservo::sim {

class CurrentAdc {
 public:
  CurrentAdc(const AdcConfig &config, std::uint64_t seed, int axis)
      : config_(config),
        current_noise_(seed, "adc.current", axis),
        voltage_noise_(seed, "adc.voltage", axis),
        codes_(std::ldexp(1.0, config.resolution_bits)) {}

  // Reading of a current [A]. Draws noise.
  double current_a(double true_a) {
    const double noise = config_.current_noise_rms_a > 0.0 ? config_.current_noise_rms_a * current_noise_.normal() : 0.0;
    const double half = 0.5 * codes_;
    const double step = config_.current_full_scale_a / half;
    const double code = std::nearbyint((true_a + config_.current_offset_a + noise) / step);
    return step * std::clamp(code, -half, half - 1.0);
  }

  // Reading of the bus voltage [V]. Draws noise.
  double voltage_v(double true_v) {
    const double noise = config_.voltage_noise_rms_v > 0.0 ? config_.voltage_noise_rms_v * voltage_noise_.normal() : 0.0;
    const double step = config_.voltage_full_scale_v / codes_;
    return step * std::clamp(std::nearbyint((true_v + noise) / step), 0.0, codes_ - 1.0);
  }

 private:
  AdcConfig config_;
  RandomStream current_noise_;
  RandomStream voltage_noise_;
  double codes_;
};

}  // namespace trackservo::sim

#endif
