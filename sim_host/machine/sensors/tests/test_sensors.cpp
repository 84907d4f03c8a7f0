// SPDX-License-Identifier: Apache-2.0
// Encoder, gyro and current converter of the simulated machine.
#include <cmath>
#include <vector>

#include "machine/sensors/adc.hpp"
#include "machine/sensors/encoder.hpp"
#include "machine/sensors/gyro.hpp"
#include "support/bench.hpp"
#include "support/check.h"

extern "C" void setUp(void) {}
extern "C" void tearDown(void) {}

namespace {

using namespace bench;

Encoder encoder_of(const EncoderConfig& config) { return Encoder(config, kPwmPeriod_s, 1, 0); }

std::uint32_t reading_at(const EncoderConfig& config, double angle_rad) {
  Encoder encoder = encoder_of(config);
  encoder.place(angle_rad);
  return encoder.sample();
}

void test_encoder_rounds_to_its_own_bits_and_leaves_the_rest_zero() {
  EncoderConfig config;
  config.resolution_bits = 12;
  const double count = 2.0 * kPi / 4096.0;
  TEST_ASSERT_EQUAL_UINT32(5U << 20, reading_at(config, 5.4 * count));
  TEST_ASSERT_EQUAL_UINT32(6U << 20, reading_at(config, 5.6 * count));
  config.resolution_bits = 32;
  CHECK_NEAR("1 rad in 2^-32 turns", 4294967296.0 / (2.0 * kPi), reading_at(config, 1.0), 1.0);
}

void test_encoder_wraps_forwards_and_backwards() {
  EncoderConfig config;
  config.resolution_bits = 16;
  const double count = 2.0 * kPi / 65536.0;
  TEST_ASSERT_EQUAL_UINT32(0U, reading_at(config, 2.0 * kPi));
  TEST_ASSERT_EQUAL_UINT32(0U, reading_at(config, 2.0 * kPi - 0.4 * count));
  TEST_ASSERT_EQUAL_UINT32(65535U << 16, reading_at(config, -count));
  TEST_ASSERT_EQUAL_UINT32(7U << 16, reading_at(config, 2.0 * kPi * 1000.0 + 7.0 * count));
  TEST_ASSERT_EQUAL_UINT32(7U << 16, reading_at(config, -2.0 * kPi * 1000.0 + 7.0 * count));
}

void test_encoder_eccentricity_is_one_sine_per_turn() {
  EncoderConfig config;
  config.resolution_bits = 32;
  config.eccentricity_rad = 15e-6;
  config.eccentricity_phase_rad = 0.3;
  for (int i = 0; i < 36; ++i) {
    const double angle = i * 10.0 * kRadPerDeg;
    const double read = reading_at(config, angle) * (2.0 * kPi / 4294967296.0);
    CHECK_NEAR("error in rad", 15e-6 * std::sin(angle + 0.3), std::remainder(read - angle, 2.0 * kPi), 2e-9);
  }
}

void test_encoder_interpolation_errs_by_one_sine_per_line() {
  EncoderConfig config;
  config.resolution_bits = 32;
  config.subdivision_error_rad = 0.2e-6;
  config.lines_per_turn = 20000;
  for (int i = 0; i < 36; ++i) {
    const double angle = 1.0 + i * 10e-6;
    const double read = reading_at(config, angle) * (2.0 * kPi / 4294967296.0);
    CHECK_NEAR("error in rad", 0.2e-6 * std::sin(20000.0 * angle), std::remainder(read - angle, 2.0 * kPi), 2e-9);
  }
}

void test_encoder_reads_the_angle_of_a_latency_ago() {
  EncoderConfig config;
  config.resolution_bits = 32;
  for (const double latency : {0.0, 20e-6, 50e-6, 130e-6, 5e-3}) {
    config.latency_s = latency;
    Encoder encoder = encoder_of(config);
    for (int step = 1; step <= 400; ++step) {
      encoder.advance(3.0 * step * kPwmPeriod_s);
    }
    const double read = encoder.sample() * (2.0 * kPi / 4294967296.0);
    CHECK_NEAR("angle in rad at 3 rad/s", 3.0 * (400.0 * kPwmPeriod_s - latency), read, 2e-9);
  }
}

void test_encoder_jitter_has_its_rms() {
  EncoderConfig config;
  config.resolution_bits = 32;
  config.jitter_rms_rad = 1e-6;
  Encoder encoder = encoder_of(config);
  encoder.place(1.0);
  double square = 0.0;
  const int samples = 100000;
  for (int i = 0; i < samples; ++i) {
    square += std::pow(encoder.sample() * (2.0 * kPi / 4294967296.0) - 1.0, 2.0) / samples;
  }
  CHECK_RELATIVE("rms in rad", 1e-6, std::sqrt(square), 0.02);
}

// Mean and variance of the sampled angle's error, the joint at rest [rad, rad2].
struct Spread {
  double mean;
  double variance;
};

Spread spread_of(const EncoderConfig& config, double angle_rad, int samples) {
  Encoder encoder = encoder_of(config);
  encoder.place(angle_rad);
  Spread spread{0.0, 0.0};
  double square = 0.0;
  for (int i = 0; i < samples; ++i) {
    const double error = std::remainder(encoder.sample() * (2.0 * kPi / 4294967296.0) - angle_rad, 2.0 * kPi);
    spread.mean += error / samples;
    square += error * error / samples;
  }
  spread.variance = square - spread.mean * spread.mean;
  return spread;
}

void test_encoder_reads_per_tick_divide_the_variance_and_add_no_bias() {
  EncoderConfig config;
  config.resolution_bits = 32;
  config.jitter_rms_rad = 1e-6;
  const int samples = 100000;
  for (const int reads : {1, 2, 4, 8, 20}) {
    config.reads_per_tick = reads;
    for (const double angle_rad : {1.0, 0.0, -1e-7}) {  // also across the end of the turn
      const Spread spread = spread_of(config, angle_rad, samples);
      CHECK_RELATIVE("variance in rad2", 1e-12 / reads, spread.variance, 0.03);
      // Four standard errors, and a step of the 2^-32 turn that the division truncates.
      CHECK_NEAR("bias in rad", 0.0, spread.mean, 4e-6 / std::sqrt(static_cast<double>(reads) * samples) + 1.5e-9);
    }
  }
}

void test_averaged_readings_resolve_more_than_a_count_where_jitter_dithers() {
  EncoderConfig config;
  config.resolution_bits = 20;
  const double count_rad = 2.0 * kPi / 1048576.0;
  config.jitter_rms_rad = count_rad;
  config.reads_per_tick = 16;
  const int samples = 100000;
  // Jitter of one count makes the rounding a second, independent noise of a twelfth count squared.
  const double variance = (1.0 + 1.0 / 12.0) * count_rad * count_rad / 16;
  for (const double fraction : {0.0, 0.3, 0.5}) {
    const Spread spread = spread_of(config, fraction * count_rad, samples);
    CHECK_RELATIVE("variance in rad2", variance, spread.variance, 0.03);
    CHECK_NEAR("bias in counts", 0.0, spread.mean / count_rad, 4.0 * std::sqrt(variance / samples) / count_rad);
  }
}

void test_averaging_delays_a_moving_angle_by_half_the_readings() {
  EncoderConfig config;
  config.resolution_bits = 32;
  config.reads_per_tick = 4;
  Encoder encoder = encoder_of(config);
  for (int step = 1; step <= 400; ++step) {
    encoder.advance(3.0 * step * kPwmPeriod_s);
  }
  const double read = encoder.sample() * (2.0 * kPi / 4294967296.0);
  CHECK_NEAR("angle in rad at 3 rad/s", 3.0 * (400.0 - 1.5) * kPwmPeriod_s, read, 3e-9);
}

Gyro gyro_of(const GyroConfig& config) { return Gyro(config, kPwmPeriod_s, kTick_s, 1, 0); }

void test_gyro_noise_density_is_the_one_of_the_data_sheet() {
  // Angle random walk: the integral over T of white noise of one-sided density N has variance N^2 T / 2.
  for (const int order : {1, 2}) {
    GyroConfig config;
    config.noise_density_rad_s_rthz = 0.0002 * kRadPerDeg;
    config.filter_order = order;
    Gyro gyro = gyro_of(config);
    const int windows = 4000;
    const double window_s = 0.5;
    double square = 0.0;
    for (int w = 0; w < windows; ++w) {
      double angle = 0.0;
      for (int tick = 0; tick < 500; ++tick) {
        angle += gyro.sample().rate_rad_s * kTick_s;
      }
      square += angle * angle / windows;
    }
    const double density = std::sqrt(2.0 * square / window_s);
    LOG_VALUE("density from angle random walk, deg/s/sqrt(Hz)", density / kRadPerDeg);
    CHECK_RELATIVE("density", config.noise_density_rad_s_rthz, density, 0.04);
  }
}

void test_gyro_noise_stays_below_white_at_its_sampling_rate() {
  GyroConfig config;
  config.noise_density_rad_s_rthz = 1.0;
  config.bandwidth_hz = 100.0;
  config.range_rad_s = 1e6;
  Gyro gyro = gyro_of(config);
  double square = 0.0;
  const int samples = 200000;
  for (int i = 0; i < samples; ++i) {
    square += std::pow(gyro.sample().rate_rad_s, 2.0) / samples;
  }
  // x' = a x + (1 - a) w: variance (1 - a)/(1 + a) of the white one
  const double a = std::exp(-2.0 * kPi * 0.1);
  CHECK_RELATIVE("variance", 500.0 * (1.0 - a) / (1.0 + a), square, 0.02);
}

void test_gyro_bandwidth_is_minus_3_db_in_both_orders() {
  for (const int order : {1, 2}) {
    GyroConfig config;
    config.bandwidth_hz = 440.0;
    config.filter_order = order;
    Gyro gyro = gyro_of(config);
    const double w = 2.0 * kPi * 440.0;
    double in_phase = 0.0;
    double quadrature = 0.0;
    const int steps = 20000;
    for (int step = 1; step <= 2 * steps; ++step) {
      const double t = step * kPwmPeriod_s;
      gyro.advance(std::sin(w * t));
      if (step > steps) {
        const double y = gyro.sample().rate_rad_s;
        in_phase += 2.0 * y * std::sin(w * t) / steps;
        quadrature += 2.0 * y * std::cos(w * t) / steps;
      }
    }
    CHECK_NEAR("gain in dB", -3.01, 20.0 * std::log10(std::hypot(in_phase, quadrature)), 0.03);
    CHECK_NEAR("phase in deg", order == 1 ? -45.0 : -90.0, std::atan2(quadrature, in_phase) / kRadPerDeg, 0.2);
  }
}

void test_gyro_bias_scale_latency_and_range() {
  GyroConfig config;
  config.bias_rad_s = 0.01;
  config.scale_error = 300e-6;
  config.range_rad_s = 2.0;
  config.latency_s = 200e-6;
  Gyro gyro = gyro_of(config);
  for (int step = 1; step <= 2000; ++step) {
    gyro.advance(10.0 * step * kPwmPeriod_s);
  }
  // 10 rad/s2 ramp: behind by the latency and by the filter's time constant
  const double lag = 200e-6 + 1.0 / (2.0 * kPi * 440.0);
  const Gyro::Reading reading = gyro.sample();
  CHECK_NEAR("rate in rad/s", (1.0 + 300e-6) * (1.0 - 10.0 * lag) + 0.01, reading.rate_rad_s, 1e-9);
  TEST_ASSERT_TRUE(reading.valid);
  for (int step = 0; step < 1000; ++step) {
    gyro.advance(-3.0);
  }
  const Gyro::Reading clipped = gyro.sample();
  CHECK_SAME("clipped to the range", -2.0, clipped.rate_rad_s);
  TEST_ASSERT_FALSE(clipped.valid);
}

void test_converter_quantises_offsets_and_clips() {
  AdcConfig config;
  config.resolution_bits = 12;
  config.current_full_scale_a = 25.0;
  config.current_offset_a = 0.1;
  config.voltage_full_scale_v = 66.0;
  CurrentAdc adc(config, 1, 0);
  const double step = 50.0 / 4096.0;
  CHECK_NEAR("3 A in A", step * std::round(3.1 / step), adc.current_a(3.0), 1e-12);
  CHECK_NEAR("full scale in A", 25.0 - step, adc.current_a(1e9), 1e-12);
  CHECK_NEAR("negative full scale in A", -25.0, adc.current_a(-1e9), 1e-12);
  CHECK_NEAR("48 V in V", 48.0, adc.voltage_v(48.0), 0.5 * 66.0 / 4096.0);
  CHECK_SAME("negative voltage reads zero", 0.0, adc.voltage_v(-1.0));
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_encoder_rounds_to_its_own_bits_and_leaves_the_rest_zero);
  RUN_TEST(test_encoder_wraps_forwards_and_backwards);
  RUN_TEST(test_encoder_eccentricity_is_one_sine_per_turn);
  RUN_TEST(test_encoder_interpolation_errs_by_one_sine_per_line);
  RUN_TEST(test_encoder_reads_the_angle_of_a_latency_ago);
  RUN_TEST(test_encoder_jitter_has_its_rms);
  RUN_TEST(test_encoder_reads_per_tick_divide_the_variance_and_add_no_bias);
  RUN_TEST(test_averaged_readings_resolve_more_than_a_count_where_jitter_dithers);
  RUN_TEST(test_averaging_delays_a_moving_angle_by_half_the_readings);
  RUN_TEST(test_gyro_noise_density_is_the_one_of_the_data_sheet);
  RUN_TEST(test_gyro_noise_stays_below_white_at_its_sampling_rate);
  RUN_TEST(test_gyro_bandwidth_is_minus_3_db_in_both_orders);
  RUN_TEST(test_gyro_bias_scale_latency_and_range);
  RUN_TEST(test_converter_quantises_offsets_and_clips);
  return UNITY_END();
}
