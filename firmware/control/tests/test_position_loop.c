/* SPDX-License-Identifier: Apache-2.0 */
/* Position loop with an ideal rate loop behind it. */
#include "control/position_loop.h"

#include "support/check.h"
#include "support/random.h"

void setUp(void) {}
void tearDown(void) {}

static const double count_rad = 6.283185307179586 / 4294967296.0;

static position_loop_params example(void) {
  return (position_loop_params){.proportional_per_s = 10.0f, .rate_limit_rad_s = 1.0f, .deceleration_rad_s2 = 2.0f};
}

static angle_turn32 angle_of(double angle_rad) {
  return (angle_turn32)(uint64_t)(int64_t)llround(fmod(angle_rad, 6.283185307179586) / count_rad);
}

/* The highest angle, and the angle at the end, of a step from 0 to `step_rad`. */
static void expect_arrival(const position_loop_params *params, double step_rad, double dt_s, double duration_s) {
  double angle_rad = 0.0;
  double overshoot_rad = -1.0;
  double previous_rad_s = 0.0;
  double hardest_rad_s2 = 0.0;
  const double side = step_rad > 0.0 ? 1.0 : -1.0;
  const angle_turn32 target = angle_of(step_rad);
  const int ticks = (int)lround(duration_s / dt_s);
  for (int tick = 0; tick < ticks; ++tick) {
    const double rate = (double)position_loop_rate(params, target, angle_of(angle_rad), 0.0f);
    if (tick > 0) {
      hardest_rad_s2 = fmax(hardest_rad_s2, side * (previous_rad_s - rate) / dt_s);
    }
    previous_rad_s = rate;
    angle_rad += rate * dt_s;
    overshoot_rad = fmax(overshoot_rad, side * (angle_rad - step_rad));
  }
  CHECK_AT_MOST("overshoot", 1e-8, overshoot_rad);
  CHECK_NEAR("angle at the end", step_rad, angle_rad, 1e-7);
  /* On the parabola a tick adds up to kp dt of it, because the rate is held for the tick. */
  const double held = 1.02 + (double)params->proportional_per_s * dt_s;
  CHECK_AT_MOST("deceleration", held * (double)params->deceleration_rad_s2, hardest_rad_s2);
}

static void test_large_steps_arrive_without_overshoot_and_brake_as_reported(void) {
  const double steps_rad[] = {0.001, 0.02, 0.5, 2.0, 3.1, -0.001, -0.5, -3.1};
  const position_loop_params params = example();
  for (int i = 0; i < 8; ++i) {
    expect_arrival(&params, steps_rad[i], 1e-3, 8.0);
  }
}

static void test_a_stiff_loop_at_the_edge_of_a_tick_does_not_overshoot_either(void) {
  const position_loop_params params = {
      .proportional_per_s = 900.0f, .rate_limit_rad_s = 100.0f, .deceleration_rad_s2 = 50.0f};
  const double steps_rad[] = {1e-4, 0.01, 1.0};
  for (int i = 0; i < 3; ++i) {
    expect_arrival(&params, steps_rad[i], 1e-3, 2.0);
  }
}

static void test_the_rate_follows_line_and_parabola(void) {
  const position_loop_params params = example(); /* they join at a/kp^2 = 0.02 rad */
  const double errors_rad[] = {0.0, 1e-6, 0.005, 0.0199, 0.0201, 0.05, 0.2};
  for (int i = 0; i < 7; ++i) {
    for (int side = -1; side <= 1; side += 2) {
      const double error = errors_rad[i];
      const double expected = side * (error <= 0.02 ? 10.0 * error : sqrt(2.0 * 2.0 * (error - 0.01)));
      CHECK_NEAR("rate", expected, position_loop_rate(&params, angle_of(6.3 + side * error), angle_of(6.3), 0.0f),
                 2e-6);
    }
  }
}

static void test_value_and_slope_are_continuous_where_line_and_parabola_join(void) {
  random_source source = {13};
  for (int trial = 0; trial < 200; ++trial) {
    const double kp = random_decades(&source, 1.0, 100.0);
    const double join_rad = random_decades(&source, 1e-3, 1.0);
    const position_loop_params params = {.proportional_per_s = (float)kp,
                                         .rate_limit_rad_s = 100.0f,
                                         .deceleration_rad_s2 = (float)(join_rad * kp * kp)};
    CHECK_STATUS(CONTROL_OK, position_loop_check(&params));
    const double h = 0.01 * join_rad;
    const double at = (double)position_loop_rate(&params, angle_of(join_rad), 0u, 0.0f);
    const double before = (double)position_loop_rate(&params, angle_of(join_rad - h), 0u, 0.0f);
    const double after = (double)position_loop_rate(&params, angle_of(join_rad + h), 0u, 0.0f);
    CHECK_RELATIVE("value at the join", kp * join_rad, at, 1e-5);
    CHECK_RELATIVE("slope before", kp, (at - before) / h, 1e-3);
    CHECK_RELATIVE("slope after", kp, (after - at) / h, 0.01); /* the parabola bends by h/(2 join) */
  }
}

static void test_the_shorter_direction_is_taken(void) {
  const position_loop_params params = example();
  CHECK_NEAR("up through zero", 0.1,
             position_loop_rate(&params, angle_of(0.005), angle_of(6.283185307179586 - 0.005), 0.0f), 1e-6);
  CHECK_NEAR("down through zero", -0.1,
             position_loop_rate(&params, angle_of(6.283185307179586 - 0.005), angle_of(0.005), 0.0f), 1e-6);
  CHECK_AT_LEAST("just below half a turn", 0.9, position_loop_rate(&params, 0x7FFFFFFFu, 0u, 0.0f));
  CHECK_AT_MOST("half a turn", -0.9, position_loop_rate(&params, 0x80000000u, 0u, 0.0f));
}

static void test_the_rate_stays_within_its_limit_with_feedforward_too(void) {
  const position_loop_params params = example();
  CHECK_SAME("up", 1.0, position_loop_rate(&params, angle_of(2.0), 0u, 0.0f));
  CHECK_SAME("down", -1.0, position_loop_rate(&params, 0u, angle_of(2.0), 0.0f));
  CHECK_SAME("fed forward beyond", 1.0, position_loop_rate(&params, angle_of(0.05), 0u, 0.9f));
  CHECK_SAME("fed forward beyond, down", -1.0, position_loop_rate(&params, 0u, 0u, -7.0f));
  CHECK_NEAR("fed forward within", 0.35, position_loop_rate(&params, angle_of(0.005), 0u, 0.3f), 1e-6);
}

static void test_check_refuses_each_value_by_itself(void) {
  position_loop_params params = example();
  CHECK_STATUS(CONTROL_OK, position_loop_check(&params));
  float *const values[] = {&params.proportional_per_s, &params.rate_limit_rad_s, &params.deceleration_rad_s2};
  const float bad[][2] = {{0.0099f, 1001.0f}, {0.9e-5f, 101.0f}, {0.9e-4f, 1.01e4f}};
  for (int i = 0; i < 3; ++i) {
    const float good = *values[i];
    *values[i] = NAN;
    CHECK_STATUS(CONTROL_NOT_FINITE, position_loop_check(&params));
    *values[i] = bad[i][0];
    CHECK_STATUS(CONTROL_OUT_OF_RANGE, position_loop_check(&params));
    *values[i] = bad[i][1];
    CHECK_STATUS(CONTROL_OUT_OF_RANGE, position_loop_check(&params));
    *values[i] = good;
  }
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_large_steps_arrive_without_overshoot_and_brake_as_reported);
  RUN_TEST(test_a_stiff_loop_at_the_edge_of_a_tick_does_not_overshoot_either);
  RUN_TEST(test_the_rate_follows_line_and_parabola);
  RUN_TEST(test_value_and_slope_are_continuous_where_line_and_parabola_join);
  RUN_TEST(test_the_shorter_direction_is_taken);
  RUN_TEST(test_the_rate_stays_within_its_limit_with_feedforward_too);
  RUN_TEST(test_check_refuses_each_value_by_itself);
  return UNITY_END();
}
