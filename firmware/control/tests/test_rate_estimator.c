/* SPDX-License-Identifier: Apache-2.0 */
/* Joint rate from encoder angles: exact on a ramp, delay, quantisation noise, wrap. */
#include "control/rate_estimator.h"

#include "support/check.h"
#include "support/random.h"

void setUp(void) {}
void tearDown(void) {}

static const float dt_s = 1e-3f;
static const double count_rad = 6.283185307179586 / 4294967296.0;

/* The encoder's reading of an angle in counts of 2^-32 turn, of which it has `bits` bits. */
static angle_turn32 encoder(double counts, int bits) {
  const double step = ldexp(1.0, 32 - bits);
  const double quantised = floor(counts / step) * step;
  return (angle_turn32)(uint64_t)(int64_t)fmod(quantised, 4294967296.0);
}

static void test_a_ramp_is_measured_exactly_by_every_window(void) {
  for (int window = 2; window <= RATE_ESTIMATOR_MAX_WINDOW; ++window) {
    const rate_estimator_params params = {.window_ticks = window};
    for (int direction = -1; direction <= 1; direction += 2) {
      const int32_t counts_per_tick = direction * 123457;
      rate_estimator_state state;
      angle_turn32 angle = 5000u;
      rate_estimator_reset(&state, angle);
      float rate_rad_s = 0.0f;
      for (int tick = 0; tick < 40; ++tick) {
        angle += (angle_turn32)counts_per_tick;
        rate_rad_s = rate_estimator_step(&state, &params, angle, dt_s);
      }
      CHECK_RELATIVE("rate", counts_per_tick * count_rad / 1e-3, rate_rad_s, 1e-6);
    }
  }
}

static void test_at_rest_the_rate_is_zero_from_the_first_tick_wherever_it_rests(void) {
  const rate_estimator_params params = {.window_ticks = 16};
  const angle_turn32 angles[] = {0u, 1u, 0x80000000u, 0xFFFFFFFFu};
  for (int i = 0; i < 4; ++i) {
    rate_estimator_state state;
    rate_estimator_reset(&state, angles[i]);
    for (int tick = 0; tick < 20; ++tick) {
      CHECK_SAME("rate", 0.0, rate_estimator_step(&state, &params, angles[i], dt_s));
    }
  }
}

static void test_the_wrap_through_zero_is_not_seen(void) {
  for (int window = 2; window <= RATE_ESTIMATOR_MAX_WINDOW; window += 7) {
    const rate_estimator_params params = {.window_ticks = window};
    rate_estimator_state state;
    angle_turn32 angle = 0u - 20u * 1000000u;
    rate_estimator_reset(&state, angle);
    for (int tick = 0; tick < 40; ++tick) { /* passes 0 in tick 20 */
      angle += 1000000u;
      const float rate_rad_s = rate_estimator_step(&state, &params, angle, dt_s);
      if (tick + 1 >= window) {
        CHECK_RELATIVE("rate", 1e6 * count_rad / 1e-3, rate_rad_s, 1e-6);
      }
    }
  }
}

static void test_the_delay_is_half_the_window(void) {
  /* Under a constant acceleration a pure delay shows the rate of (N-1)/2 ticks ago. */
  for (int window = 2; window <= RATE_ESTIMATOR_MAX_WINDOW; ++window) {
    const rate_estimator_params params = {.window_ticks = window};
    rate_estimator_state state;
    rate_estimator_reset(&state, 0u);
    const double counts_per_tick2 = 2000.0;
    double rate_rad_s = 0.0;
    const int ticks = 200;
    for (int tick = 1; tick <= ticks; ++tick) {
      rate_rad_s =
          (double)rate_estimator_step(&state, &params, encoder(0.5 * counts_per_tick2 * tick * tick, 32), dt_s);
    }
    const double seen_ticks = rate_rad_s * 1e-3 / count_rad / counts_per_tick2;
    CHECK_NEAR("delay in ticks", 0.5 * (window - 1), ticks - seen_ticks, 2e-3);
  }
}

/* Standard deviation of the rate of a 20-bit encoder over many ramps with different fractions of a count per tick. */
static double quantisation_noise(int window) {
  random_source source = {7};
  const rate_estimator_params params = {.window_ticks = window};
  double sum = 0.0;
  int count = 0;
  for (int ramp = 0; ramp < 2000; ++ramp) {
    const double counts_per_tick = random_uniform(&source, 3.0, 40.0) * 4096.0; /* 3 .. 40 encoder counts */
    const double start = random_uniform(&source, 0.0, 1e6);
    rate_estimator_state state;
    rate_estimator_reset(&state, encoder(start, 20));
    for (int tick = 1; tick < 60; ++tick) {
      const float rate = rate_estimator_step(&state, &params, encoder(start + counts_per_tick * tick, 20), dt_s);
      if (tick >= window) {
        const double error = (double)rate - counts_per_tick * count_rad / 1e-3;
        sum += error * error;
        ++count;
      }
    }
  }
  return sqrt(sum / count);
}

static void test_quantisation_noise_falls_with_the_window_to_the_power_of_one_and_a_half(void) {
  /* Uniform rounding of one count q has sigma q/sqrt(12); the slope of N points q/dt / sqrt(N (N^2 - 1)). */
  const double count20_rad_s = 4096.0 * count_rad / 1e-3;
  const int windows[] = {2, 4, 8, 16};
  double noise[4];
  for (int i = 0; i < 4; ++i) {
    const double n = windows[i];
    noise[i] = quantisation_noise(windows[i]);
    LOG_VALUE("noise of a 20-bit encoder, rad/s", noise[i]);
    CHECK_RELATIVE("noise", count20_rad_s / sqrt(n * (n * n - 1.0)), noise[i], 0.05);
  }
  CHECK_NEAR("power of N from 4 to 16", 1.5, log(noise[1] / noise[3]) / log(4.0), 0.06);
}

static void test_check_refuses_windows_outside_2_to_16(void) {
  const int windows[] = {-1, 0, 1, 17, 1000000};
  for (int i = 0; i < 5; ++i) {
    const rate_estimator_params params = {.window_ticks = windows[i]};
    CHECK_STATUS(CONTROL_OUT_OF_RANGE, rate_estimator_check(&params));
  }
  for (int window = 2; window <= 16; ++window) {
    const rate_estimator_params params = {.window_ticks = window};
    CHECK_STATUS(CONTROL_OK, rate_estimator_check(&params));
  }
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_a_ramp_is_measured_exactly_by_every_window);
  RUN_TEST(test_at_rest_the_rate_is_zero_from_the_first_tick_wherever_it_rests);
  RUN_TEST(test_the_wrap_through_zero_is_not_seen);
  RUN_TEST(test_the_delay_is_half_the_window);
  RUN_TEST(test_quantisation_noise_falls_with_the_window_to_the_power_of_one_and_a_half);
  RUN_TEST(test_check_refuses_windows_outside_2_to_16);
  return UNITY_END();
}
