/* SPDX-License-Identifier: Apache-2.0 */
/* The set-point model against the second-order system that it stands for, and what passes it unchanged. */
#include "control/setpoint_model.h"

#include <math.h>

#include "support/check.h"

void setUp(void) {}
void tearDown(void) {}

#define DT_S 1e-3f

static setpoint_model_params model_of(float frequency_rad_s) {
  setpoint_model_params params = {.decay = 0.0f};
  CHECK_STATUS(CONTROL_OK, setpoint_model_design(&params, frequency_rad_s, DT_S));
  CHECK_STATUS(CONTROL_OK, setpoint_model_check(&params, DT_S));
  return params;
}

static speed_reference shown(setpoint_model_state *state, const setpoint_model_params *params, float rate_rad_s,
                             float acceleration_rad_s2) {
  const speed_reference wanted = {.rate_rad_s = rate_rad_s, .acceleration_rad_s2 = acceleration_rad_s2};
  return setpoint_model_step(state, params, &wanted, DT_S);
}

/* Of (s + w)^2 at rest. */
static double step_response(double w_rad_s, double time_s) {
  return 1.0 - exp(-w_rad_s * time_s) * (1.0 + w_rad_s * time_s);
}

static void test_a_jump_moves_as_the_second_order_system_does(void) {
  const float frequencies_rad_s[] = {100.0f, 400.0f, 1000.0f};
  for (int i = 0; i < 3; ++i) {
    const setpoint_model_params params = model_of(frequencies_rad_s[i]);
    setpoint_model_state state;
    setpoint_model_reset(&state, 2.0f);
    double highest = 0.0;
    for (int tick = 0; tick < 200; ++tick) {
      const double moved = ((double)shown(&state, &params, -2.0f, 0.0f).rate_rad_s - 2.0) / -4.0;
      const double now = step_response((double)frequencies_rad_s[i], tick * 1e-3);
      const double next = step_response((double)frequencies_rad_s[i], (tick + 1) * 1e-3);
      CHECK_AT_LEAST("share of the jump", fmin(now, next) - 2e-3, moved);
      CHECK_AT_MOST("share of the jump", fmax(now, next) + 2e-3, moved);
      highest = fmax(highest, moved);
    }
    CHECK_AT_MOST("highest share of the jump", 1.0 + 1e-6, highest);
    CHECK_NEAR("at the end, rad/s", -2.0, state.rate_rad_s, 1e-6);
  }
}

static void test_an_announced_ramp_passes_unchanged(void) {
  const setpoint_model_params params = model_of(400.0f);
  setpoint_model_state state;
  setpoint_model_reset(&state, 0.0f);
  for (int tick = 0; tick < 300; ++tick) {
    const float acceleration_rad_s2 = tick < 100 ? 2.0f : -1.0f;
    const float rate_rad_s = 1e-3f * (float)(tick < 100 ? 2 * tick : 300 - tick);
    const speed_reference reference = shown(&state, &params, rate_rad_s, acceleration_rad_s2);
    CHECK_NEAR("rate, rad/s", rate_rad_s, reference.rate_rad_s, 1e-6);
    CHECK_NEAR("acceleration, rad/s^2", acceleration_rad_s2, reference.acceleration_rad_s2, 1e-3);
  }
}

static void test_a_ramp_that_is_not_announced_lags_by_two_over_the_frequency(void) {
  const setpoint_model_params params = model_of(400.0f);
  setpoint_model_state state;
  setpoint_model_reset(&state, 0.0f);
  speed_reference reference = {.rate_rad_s = 0.0f};
  for (int tick = 0; tick <= 500; ++tick) {
    reference = shown(&state, &params, 1e-3f * (float)tick, 0.0f);
  }
  CHECK_NEAR("lag, s", 2.0 / 400.0, 0.5 - (double)reference.rate_rad_s, 0.6e-3); /* and half a tick */
  CHECK_NEAR("acceleration, rad/s^2", 1.0, reference.acceleration_rad_s2, 1e-3);
}

/* The feedforward of the acceleration then gives the rate exactly. */
static void test_the_rate_is_the_sum_of_the_accelerations(void) {
  const setpoint_model_params params = model_of(250.0f);
  setpoint_model_state state;
  setpoint_model_reset(&state, 0.5f);
  double rate_rad_s = 0.5;
  for (int tick = 0; tick < 1000; ++tick) {
    const float wanted_rad_s = tick % 170 < 60 ? 1.0f : -0.3f;
    const speed_reference reference = shown(&state, &params, wanted_rad_s, tick % 90 < 20 ? 3.0f : 0.0f);
    CHECK_NEAR("rate, rad/s", rate_rad_s, reference.rate_rad_s, 1e-5);
    rate_rad_s += 1e-3 * (double)reference.acceleration_rad_s2;
  }
}

static void test_without_a_model_the_setpoint_passes(void) {
  const setpoint_model_params params = model_of(0.0f);
  setpoint_model_state state;
  setpoint_model_reset(&state, 0.0f);
  const speed_reference reference = shown(&state, &params, 0.7f, -3.0f);
  CHECK_SAME("rate, rad/s", 0.7f, reference.rate_rad_s);
  CHECK_SAME("acceleration, rad/s^2", -3.0, reference.acceleration_rad_s2);
  const setpoint_model_params later = model_of(400.0f); /* begins where the set-point is */
  CHECK_SAME("rate, rad/s", 0.7f, shown(&state, &later, 0.7f, 0.0f).rate_rad_s);
  CHECK_SAME("rate, rad/s", 0.7f, shown(&state, &later, 0.7f, 0.0f).rate_rad_s);
}

static void test_a_frequency_out_of_range_is_refused(void) {
  setpoint_model_params params = {.decay = 0.25f, .gain_per_s = 7.0f};
  const float bad[] = {-400.0f, 1e-3f, 99.0f, 1001.0f, INFINITY};
  for (int i = 0; i < 5; ++i) {
    TEST_ASSERT_NOT_EQUAL(CONTROL_OK, setpoint_model_design(&params, bad[i], DT_S));
  }
  CHECK_STATUS(CONTROL_NOT_FINITE, setpoint_model_design(&params, NAN, DT_S));
  CHECK_SAME("unchanged", 0.25, params.decay);
  CHECK_SAME("unchanged", 7.0, params.gain_per_s);
  params.gain_per_s = 1001.0f;
  CHECK_STATUS(CONTROL_OUT_OF_RANGE, setpoint_model_check(&params, DT_S));
  params = (setpoint_model_params){.decay = 1.01f, .gain_per_s = 7.0f};
  CHECK_STATUS(CONTROL_OUT_OF_RANGE, setpoint_model_check(&params, DT_S));
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_a_jump_moves_as_the_second_order_system_does);
  RUN_TEST(test_an_announced_ramp_passes_unchanged);
  RUN_TEST(test_a_ramp_that_is_not_announced_lags_by_two_over_the_frequency);
  RUN_TEST(test_the_rate_is_the_sum_of_the_accelerations);
  RUN_TEST(test_without_a_model_the_setpoint_passes);
  RUN_TEST(test_a_frequency_out_of_range_is_refused);
  return UNITY_END();
}
