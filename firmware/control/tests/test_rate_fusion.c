/* SPDX-License-Identifier: Apache-2.0 */
/* Fusion of gyro and encoder: each source, loss of the gyro, the crossover. */
#include "control/rate_fusion.h"

#include <complex.h>

#include "support/check.h"

void setUp(void) {}
void tearDown(void) {}

#define imaginary ((double complex)I) /* I itself is a float */

static const float dt_s = 1e-3f;
static const float crossover_rad_s = 60.0f;

static void test_the_encoder_alone_takes_the_base_to_be_at_rest(void) {
  const rate_fusion_params params = {.source = RATE_FROM_ENCODER, .crossover_rad_s = crossover_rad_s};
  rate_fusion_state state;
  rate_fusion_reset(&state);
  for (int tick = 0; tick < 10; ++tick) {
    const rate_fusion_output out = rate_fusion_step(&state, &params, 5.0f, true, 0.3f, 0.0f, dt_s);
    CHECK_SAME("rate", 0.3f, out.rate_rad_s);
    CHECK_SAME("base", 0.0, out.base_rate_rad_s);
  }
}

static void test_the_gyro_alone_is_passed_on_at_once(void) {
  const rate_fusion_params params = {.source = RATE_FROM_GYRO, .crossover_rad_s = crossover_rad_s};
  rate_fusion_state state;
  rate_fusion_reset(&state);
  for (int tick = 0; tick < 10; ++tick) {
    const float gyro_rad_s = 0.01f * (float)tick;
    CHECK_SAME("rate", gyro_rad_s, rate_fusion_step(&state, &params, gyro_rad_s, true, -0.2f, 0.0f, dt_s).rate_rad_s);
  }
}

static void test_the_base_rate_is_found_by_both_sources_with_a_gyro(void) {
  const rate_source sources[] = {RATE_FROM_GYRO, RATE_FUSED};
  for (int i = 0; i < 2; ++i) {
    const rate_fusion_params params = {.source = sources[i], .crossover_rad_s = crossover_rad_s};
    rate_fusion_state state;
    rate_fusion_reset(&state);
    rate_fusion_output out = {0.0f, 0.0f};
    for (int tick = 1; tick <= 500; ++tick) {
      out = rate_fusion_step(&state, &params, 0.05f, true, 0.03f, 0.0f, dt_s);
      const double expected = 0.02 * (1.0 - pow(1.0 + 0.06, -tick)); /* the implicit low-pass step by step */
      CHECK_NEAR("base", expected, out.base_rate_rad_s, 1e-7);
    }
    CHECK_NEAR("inertial rate", 0.05, out.rate_rad_s, 1e-7);
  }
}

static void test_losing_the_gyro_makes_no_bump_and_keeps_the_base_rate(void) {
  const rate_source sources[] = {RATE_FROM_GYRO, RATE_FUSED};
  for (int i = 0; i < 2; ++i) {
    const rate_fusion_params params = {.source = sources[i], .crossover_rad_s = crossover_rad_s};
    rate_fusion_state state;
    rate_fusion_reset(&state);
    for (int tick = 0; tick < 500; ++tick) {
      (void)rate_fusion_step(&state, &params, 0.05f, true, 0.03f, 0.0f, dt_s);
    }
    const rate_fusion_output lost = rate_fusion_step(&state, &params, 0.0f, false, 0.03f, 0.0f, dt_s);
    CHECK_NEAR("rate in the tick of the loss", 0.05, lost.rate_rad_s, 1e-6);
    const rate_fusion_output later = rate_fusion_step(&state, &params, NAN, false, 0.07f, 0.0f, dt_s);
    CHECK_NEAR("rate follows the encoder", 0.09, later.rate_rad_s, 1e-6);
    CHECK_NEAR("base is kept", 0.02, later.base_rate_rad_s, 1e-6);
    const rate_fusion_output back = rate_fusion_step(&state, &params, 0.09f, true, 0.07f, 0.0f, dt_s);
    CHECK_NEAR("rate in the tick of the return", 0.09, back.rate_rad_s, 1e-6);
  }
}

static void test_reset_forgets_the_base(void) {
  const rate_fusion_params params = {.source = RATE_FUSED, .crossover_rad_s = crossover_rad_s};
  rate_fusion_state state = {.base_rate_rad_s = 1.0f};
  rate_fusion_reset(&state);
  CHECK_SAME("rate", 0.03f, rate_fusion_step(&state, &params, 0.0f, false, 0.03f, 0.0f, dt_s).rate_rad_s);
}

/* From one of the two sensors to the fused rate, measured on a cosine with a period of whole ticks. */
static double complex response(bool through_gyro, int period_ticks) {
  const rate_fusion_params params = {.source = RATE_FUSED, .crossover_rad_s = crossover_rad_s};
  rate_fusion_state state;
  rate_fusion_reset(&state);
  double complex sum = 0.0;
  const int count = 40 * period_ticks;
  for (int tick = -count; tick < count; ++tick) { /* the first half settles */
    const double phase = 6.283185307179586 * tick / period_ticks;
    const float wave = (float)cos(phase);
    const rate_fusion_output out =
        rate_fusion_step(&state, &params, through_gyro ? wave : 0.0f, true, through_gyro ? 0.0f : wave, 0.0f, dt_s);
    if (tick >= 0) {
      sum += (double)out.rate_rad_s * cexp(-imaginary * phase) * 2.0 / count;
    }
  }
  return sum;
}

static void test_below_the_crossover_the_gyro_leads_above_it_the_encoder(void) {
  const int periods_ticks[] = {1000, 200, 105, 50, 10}; /* 1, 5, 9.5, 20, 100 Hz; the crossover is at 9.55 Hz */
  for (int i = 0; i < 5; ++i) {
    const double w = 6283.185307179586 / periods_ticks[i];
    const double complex gyro = response(true, periods_ticks[i]);
    const double complex encoder = response(false, periods_ticks[i]);
    const double gap = 0.06 / 1.06;
    const double complex discrete = gap / (1.0 - (1.0 - gap) * cexp(-imaginary * w * 1e-3));
    CHECK_NEAR("gyro", 0.0, cabs(gyro - discrete), 1e-5);
    CHECK_NEAR("both together are the whole rate", 0.0, cabs(gyro + encoder - 1.0), 1e-5);
    /* The filter in steps differs from the continuous one by about w dt/2 of its gain. */
    CHECK_NEAR("gyro", cabs(60.0 / (imaginary * w + 60.0)), cabs(gyro), 0.035);
  }
  CHECK_NEAR("gyro's share at the crossover", sqrt(0.5), cabs(response(true, 105)), 0.03);
  CHECK_NEAR("encoder's share at the crossover", sqrt(0.5), cabs(response(false, 105)), 0.03);
}

static void test_check_refuses_each_value_by_itself(void) {
  rate_fusion_params params = {.source = RATE_FUSED, .crossover_rad_s = 60.0f};
  CHECK_STATUS(CONTROL_OK, rate_fusion_check(&params));
  params.source = (rate_source)3;
  CHECK_STATUS(CONTROL_OUT_OF_RANGE, rate_fusion_check(&params));
  params.source = (rate_source)-1;
  CHECK_STATUS(CONTROL_OUT_OF_RANGE, rate_fusion_check(&params));
  params.source = RATE_FROM_ENCODER;
  const float bad[] = {0.0099f, 2001.0f, -60.0f, NAN};
  for (int i = 0; i < 4; ++i) {
    params.crossover_rad_s = bad[i];
    CHECK_STATUS(i < 3 ? CONTROL_OUT_OF_RANGE : CONTROL_NOT_FINITE, rate_fusion_check(&params));
  }
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_the_encoder_alone_takes_the_base_to_be_at_rest);
  RUN_TEST(test_the_gyro_alone_is_passed_on_at_once);
  RUN_TEST(test_the_base_rate_is_found_by_both_sources_with_a_gyro);
  RUN_TEST(test_losing_the_gyro_makes_no_bump_and_keeps_the_base_rate);
  RUN_TEST(test_reset_forgets_the_base);
  RUN_TEST(test_below_the_crossover_the_gyro_leads_above_it_the_encoder);
  RUN_TEST(test_check_refuses_each_value_by_itself);
  return UNITY_END();
}
