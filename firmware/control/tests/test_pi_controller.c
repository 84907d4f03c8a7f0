/* SPDX-License-Identifier: Apache-2.0 */
/* PI controller against analytic responses, and how it leaves a limit. */
#include "control/pi_controller.h"

#include "base/scalar.h"
#include "support/check.h"

void setUp(void) {}
void tearDown(void) {}

static pi_controller_params example(void) {
  return (pi_controller_params){
      .proportional_gain = 20.0f, .integral_gain = 300.0f, .setpoint_weight = 0.6f, .tracking_rate_per_s = 50.0f};
}

static void test_a_constant_error_gives_a_step_and_a_ramp(void) {
  const pi_controller_params params = example();
  pi_controller_state state;
  pi_controller_reset(&state, 0.0f);
  const float dt_s = 1e-3f;
  for (int tick = 0; tick < 1000; ++tick) {
    const float output = pi_controller_propose(&state, &params, 2.0f, 0.5f);
    const double expected = 20.0 * (0.6 * 2.0 - 0.5) + 300.0 * 1.5 * tick * 1e-3;
    CHECK_NEAR("output", expected, output, 1e-4 * expected);
    pi_controller_settle(&state, &params, 1.5f, 0.0f, dt_s);
  }
}

static void test_the_setpoint_weight_scales_the_kick_of_a_step_only(void) {
  pi_controller_params params = example();
  pi_controller_state state;
  pi_controller_reset(&state, 0.0f);
  const float weights[] = {0.0f, 0.3f, 1.0f};
  for (int i = 0; i < 3; ++i) {
    params.setpoint_weight = weights[i];
    CHECK_RELATIVE("kick", 20.0 * (double)weights[i], pi_controller_propose(&state, &params, 1.0f, 0.0f), 1e-6);
    CHECK_RELATIVE("answer to the measurement", -20.0, pi_controller_propose(&state, &params, 0.0f, 1.0f), 1e-6);
  }
}

static void test_reset_holds_the_torque_that_must_be_held(void) {
  const pi_controller_params params = example();
  pi_controller_state state;
  pi_controller_reset(&state, -3.25f);
  CHECK_SAME("output at zero error", -3.25, pi_controller_propose(&state, &params, 0.0f, 0.0f));
}

/* On an inertia J the loop is y'' = -(kp y' + ki y)/J with the zero of the weighted set-point:
 * y/r = (b kp s + ki) / (J s^2 + kp s + ki); here w = 20 rad/s, damping 0.5. */
static void test_step_response_on_an_inertia_is_the_analytic_one(void) {
  const double inertia = 2.0;
  const double w = 20.0;
  const double damping = 0.5;
  const double weight = 0.4;
  const pi_controller_params params = {.proportional_gain = (float)(2.0 * damping * w * inertia),
                                       .integral_gain = (float)(w * w * inertia),
                                       .setpoint_weight = (float)weight,
                                       .tracking_rate_per_s = 0.0f};
  pi_controller_state state;
  pi_controller_reset(&state, 0.0f);
  const double dt = 1e-5; /* fine enough that the hold shifts the response by less than the band: dt * slope = 3e-4 */
  const double damped = w * sqrt(1.0 - damping * damping);
  double y = 0.0;
  for (int tick = 0; tick < 60000; ++tick) {
    const double t = tick * dt;
    const double decay = exp(-damping * w * t);
    const double zero = 2.0 * damping * weight * w; /* (b kp / J) / w^2 * w^2 */
    const double expected = 1.0 - decay * (cos(damped * t) + (damping * w - zero) / damped * sin(damped * t));
    CHECK_NEAR("speed after a step", expected, y, 1e-3);
    const float output = pi_controller_propose(&state, &params, 1.0f, (float)y);
    pi_controller_settle(&state, &params, (float)(1.0 - y), 0.0f, (float)dt);
    y += (double)output / inertia * dt;
  }
}

/* Holds the loop at a limit by a constant error, then measures the ticks to leave it after the error reverses. */
static int ticks_to_leave(float tracking_rate_per_s, float minimum, float maximum, float error) {
  pi_controller_params params = example();
  params.tracking_rate_per_s = tracking_rate_per_s;
  params.setpoint_weight = 1.0f;
  pi_controller_state state;
  pi_controller_reset(&state, 0.0f);
  const float dt_s = 1e-3f;
  for (int tick = 0; tick < 5000; ++tick) {
    const float output = pi_controller_propose(&state, &params, error, 0.0f);
    pi_controller_settle(&state, &params, error, scalar_clamp(output, minimum, maximum) - output, dt_s);
  }
  const float held = error > 0.0f ? maximum : minimum;
  for (int tick = 0; tick < 100000; ++tick) {
    const float output = pi_controller_propose(&state, &params, -0.1f * error, 0.0f);
    const float limited = scalar_clamp(output, minimum, maximum);
    if (fabsf(limited - held) > 1e-6f) {
      return tick;
    }
    pi_controller_settle(&state, &params, -0.1f * error, limited - output, dt_s);
  }
  return 100000;
}

static void test_anti_windup_leaves_every_kind_of_limit_quickly(void) {
  const float limits[][2] = {{-1.0f, 0.3f}, {-0.2f, 5.0f}, {0.2f, 1.0f}, {-4.0f, -3.0f}};
  for (int i = 0; i < 4; ++i) {
    for (int side = -1; side <= 1; side += 2) {
      const float error = 0.2f * (float)side;
      const int with = ticks_to_leave(50.0f, limits[i][0], limits[i][1], error);
      const int without = ticks_to_leave(0.0f, limits[i][0], limits[i][1], error);
      CHECK_AT_MOST("ticks to leave the limit", 5.0, with);
      CHECK_AT_LEAST("ticks without anti-windup", 1000.0, without);
    }
  }
}

static void test_at_a_limit_the_integral_rests_where_back_calculation_balances_the_error(void) {
  const pi_controller_params params = example();
  const float limits[][2] = {{-1.0f, 0.3f}, {0.2f, 1.0f}, {-4.0f, -3.0f}};
  for (int i = 0; i < 3; ++i) {
    pi_controller_state state;
    pi_controller_reset(&state, 0.0f);
    for (int tick = 0; tick < 2000; ++tick) {
      const float output = pi_controller_propose(&state, &params, 0.5f, 0.1f);
      pi_controller_settle(&state, &params, 0.4f, scalar_clamp(output, limits[i][0], limits[i][1]) - output, 1e-3f);
    }
    /* 0 = ki e + w_t (u_limited - kp (b r - y) - i) */
    const double expected = (double)limits[i][1] - 20.0 * (0.6 * 0.5 - 0.1) + 300.0 * 0.4 / 50.0;
    CHECK_NEAR("integral at the limit", expected, state.integral, 1e-4);
  }
}

static void test_check_refuses_each_value_by_itself(void) {
  pi_controller_params params = example();
  CHECK_STATUS(CONTROL_OK, pi_controller_check(&params, 1e-3f));
  float *const values[] = {&params.proportional_gain, &params.integral_gain, &params.setpoint_weight,
                           &params.tracking_rate_per_s};
  const float highest[] = {1e6f, 1e8f, 1.0f, 1000.0f};
  for (int i = 0; i < 4; ++i) {
    const float good = *values[i];
    *values[i] = NAN;
    CHECK_STATUS(CONTROL_NOT_FINITE, pi_controller_check(&params, 1e-3f));
    *values[i] = -1e-3f;
    CHECK_STATUS(CONTROL_OUT_OF_RANGE, pi_controller_check(&params, 1e-3f));
    *values[i] = 1.01f * highest[i];
    CHECK_STATUS(CONTROL_OUT_OF_RANGE, pi_controller_check(&params, 1e-3f));
    *values[i] = highest[i];
    CHECK_STATUS(CONTROL_OK, pi_controller_check(&params, 1e-3f));
    *values[i] = good;
  }
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_a_constant_error_gives_a_step_and_a_ramp);
  RUN_TEST(test_the_setpoint_weight_scales_the_kick_of_a_step_only);
  RUN_TEST(test_reset_holds_the_torque_that_must_be_held);
  RUN_TEST(test_step_response_on_an_inertia_is_the_analytic_one);
  RUN_TEST(test_anti_windup_leaves_every_kind_of_limit_quickly);
  RUN_TEST(test_at_a_limit_the_integral_rests_where_back_calculation_balances_the_error);
  RUN_TEST(test_check_refuses_each_value_by_itself);
  return UNITY_END();
}
