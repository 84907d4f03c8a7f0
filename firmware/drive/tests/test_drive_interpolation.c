/* SPDX-License-Identifier: Apache-2.0 */
/* Set-points every few ms made continuous. */
#include "drive/interpolation.h"

#include "support/check.h"

void setUp(void) {}
void tearDown(void) {}

static const float dt_s = 1e-3f;
static const double rad_per_unit = 6.283185307179586 / 4294967296.0;

static drive_angle angle_of(double rad) { return llrint(rad / rad_per_unit); }

/* The place of the reset is one of the three points of the first parabola. */
static void test_the_second_set_point_ends_a_parabola_from_the_start(void) {
  position_interpolation state;
  position_interpolation_reset(&state, 0, 0.0f);
  (void)position_interpolation_aim(&state, angle_of(0.01), 10, 100.0f, dt_s);
  CHECK_NEAR("a line, rad/s", 1.0, state.end_rad_s, 1e-5);
  for (int tick = 0; tick < 10; ++tick) {
    (void)position_interpolation_step(&state, dt_s);
  }
  (void)position_interpolation_aim(&state, angle_of(0.03), 10, 100.0f, dt_s);
  CHECK_NEAR("a parabola, rad/s", (1.5 * 0.02 - 0.5 * 0.01) / 0.01, state.end_rad_s, 1e-5);
}

static void test_positions_on_a_parabola_are_followed_exactly_one_period_late(void) {
  for (int period = 1; period <= 20; ++period) {
    position_interpolation state;
    position_interpolation_reset(&state, 0, 0.0f);
    double worst_rad = 0.0;
    double worst_rad_s = 0.0;
    for (int tick = 0; tick < 50 * period; ++tick) {
      const double now_s = tick * 1e-3;
      if (tick % period == 0) {
        TEST_ASSERT_FALSE(position_interpolation_aim(&state, angle_of(3.0 + 0.2 * now_s + 0.5 * now_s * now_s - 3.0),
                                                     period, 100.0f, dt_s));
      }
      const interpolated_position out = position_interpolation_step(&state, dt_s);
      const double then_s = (tick - period) * 1e-3;
      if (tick > 5 * period) {
        const double exact_rad = 0.2 * then_s + 0.5 * then_s * then_s;
        worst_rad = fmax(worst_rad, fabs((double)out.position * rad_per_unit - exact_rad));
        worst_rad_s = fmax(worst_rad_s, fabs((double)out.rate_rad_s - (0.2 + then_s)));
      }
    }
    /* A unit of the angle is 1.5 nrad; divided by the period it is the resolution of the rate. */
    CHECK_AT_MOST("position error, rad", 5e-9, worst_rad);
    CHECK_AT_MOST("rate error, rad/s", 2e-5 / period + 1e-6, worst_rad_s);
  }
}

static void test_position_and_rate_go_on_without_a_step_whatever_the_set_points_do(void) {
  position_interpolation state;
  position_interpolation_reset(&state, angle_of(1.0), 0.3f);
  const double targets_rad[] = {1.01, 0.99, 1.05, 1.05, 1.05, 0.9};
  interpolated_position last = position_interpolation_step(&state, dt_s);
  for (int tick = 0; tick < 60; ++tick) {
    if (tick % 10 == 0) {
      (void)position_interpolation_aim(&state, angle_of(targets_rad[tick / 10]), 10, 100.0f, dt_s);
    }
    const interpolated_position now = position_interpolation_step(&state, dt_s);
    const double mean_rad_s = 0.5 * ((double)now.rate_rad_s + (double)last.rate_rad_s);
    CHECK_NEAR("position step, rad", mean_rad_s * 1e-3, (double)(now.position - last.position) * rad_per_unit, 4e-4);
    CHECK_NEAR("rate step, rad/s", last.rate_rad_s, now.rate_rad_s, 12.0);
    last = now;
  }
}

static void test_the_axis_keeps_its_rate_until_the_first_set_point_arrives(void) {
  position_interpolation state;
  position_interpolation_reset(&state, angle_of(1.0), -0.3f);
  for (int tick = 0; tick < 20; ++tick) {
    const interpolated_position now = position_interpolation_step(&state, dt_s);
    CHECK_NEAR("position, rad", 1.0 - 0.3e-3 * tick, (double)now.position * rad_per_unit, 2e-9);
    CHECK_SAME("rate, rad/s", -0.3f, now.rate_rad_s);
  }
}

/* Half a radian ahead, where the distance has 24 bits only: the first demand is the present one to its last bit. */
static void test_a_new_set_point_begins_exactly_at_the_present_demand(void) {
  for (int step = 1; step <= 50; ++step) {
    position_interpolation state;
    const drive_angle start = angle_of(1.0) + step;
    position_interpolation_reset(&state, start, 0.3f);
    (void)position_interpolation_aim(&state, start + angle_of(0.5) + 7 * step, 200, 100.0f, dt_s);
    const interpolated_position now = position_interpolation_step(&state, dt_s);
    TEST_ASSERT_EQUAL_INT64(start, now.position);
    CHECK_SAME("rate, rad/s", 0.3f, now.rate_rad_s);
  }
}

static void test_a_late_set_point_is_bridged_with_the_last_slope(void) {
  position_interpolation state;
  position_interpolation_reset(&state, 0, 0.0f);
  for (int k = 0; k < 5; ++k) {
    (void)position_interpolation_aim(&state, angle_of(0.01 * k), 10, 100.0f, dt_s);
    for (int i = 0; i < 10; ++i) {
      (void)position_interpolation_step(&state, dt_s);
    }
  }
  for (int late = 0; late < 10; ++late) { /* set-point 0.05 does not come */
    const interpolated_position now = position_interpolation_step(&state, dt_s);
    CHECK_NEAR("position, rad", 0.04 + 0.001 * late, (double)now.position * rad_per_unit, 1e-8);
    CHECK_NEAR("rate, rad/s", 1.0, now.rate_rad_s, 1e-5);
  }
}

static void test_a_set_point_too_far_away_is_approached_at_the_rate_limit(void) {
  position_interpolation state;
  position_interpolation_reset(&state, 0, 0.0f);
  double last_rad = 0.0;
  bool cut = true;
  int periods = 0;
  while (cut && periods < 1000) {
    cut = position_interpolation_aim(&state, angle_of(-0.1), 10, 0.5f, dt_s);
    ++periods;
    for (int i = 0; i < 10; ++i) {
      const interpolated_position now = position_interpolation_step(&state, dt_s);
      const double rad = (double)now.position * rad_per_unit;
      CHECK_AT_MOST("step, rad", 1e-3, fabs(rad - last_rad));
      CHECK_AT_LEAST("position, rad", -0.1 - 2e-3, rad);
      last_rad = rad;
    }
  }
  CHECK_NEAR("periods in motion", 0.1 / 0.005, periods, 2.0);
}

static void test_rates_on_a_straight_line_are_followed_exactly_one_period_late(void) {
  for (int period = 1; period <= 20; ++period) {
    rate_interpolation state;
    rate_interpolation_reset(&state, 0.0f);
    for (int tick = 0; tick < 30 * period; ++tick) {
      if (tick % period == 0) {
        rate_interpolation_aim(&state, (float)(0.5 * tick * 1e-3), period, dt_s);
      }
      const interpolated_rate now = rate_interpolation_step(&state, dt_s);
      if (tick >= 2 * period) {
        CHECK_NEAR("rate, rad/s", 0.5 * (tick - period) * 1e-3, now.rate_rad_s, 1e-7);
        CHECK_NEAR("acceleration, rad/s^2", 0.5, now.acceleration_rad_s2, 2e-4);
      }
    }
  }
}

static void test_a_rate_is_held_when_no_set_point_follows(void) {
  rate_interpolation state;
  rate_interpolation_reset(&state, 1.0f);
  rate_interpolation_aim(&state, 3.0f, 4, dt_s);
  const double rates[] = {1.0, 1.5, 2.0, 2.5, 3.0, 3.0, 3.0};
  for (int i = 0; i < 7; ++i) {
    const interpolated_rate now = rate_interpolation_step(&state, dt_s);
    CHECK_NEAR("rate", rates[i], now.rate_rad_s, 1e-6);
    CHECK_NEAR("acceleration", i < 4 ? 500.0 : 0.0, now.acceleration_rad_s2, 1e-3);
  }
}

static void test_periods_of_1_to_255_ms_are_taken_in_every_spelling(void) {
  TEST_ASSERT_EQUAL_INT(1, interpolation_ticks(1, -3, dt_s));
  TEST_ASSERT_EQUAL_INT(20, interpolation_ticks(20, -3, dt_s));
  TEST_ASSERT_EQUAL_INT(10, interpolation_ticks(1, -2, dt_s));
  TEST_ASSERT_EQUAL_INT(2, interpolation_ticks(20, -4, dt_s));
  TEST_ASSERT_EQUAL_INT(255, interpolation_ticks(255, -3, dt_s));
  TEST_ASSERT_EQUAL_INT(250, interpolation_ticks(25, -2, dt_s));
  TEST_ASSERT_EQUAL_INT(0, interpolation_ticks(26, -2, dt_s));
  TEST_ASSERT_EQUAL_INT(0, interpolation_ticks(0, -3, dt_s));
  TEST_ASSERT_EQUAL_INT(0, interpolation_ticks(1, 0, dt_s));
  TEST_ASSERT_EQUAL_INT(0, interpolation_ticks(1, 1, dt_s));
  TEST_ASSERT_EQUAL_INT(0, interpolation_ticks(255, -128, dt_s));
}

static void test_set_points_have_stopped_after_three_periods_but_never_before_20_ms(void) {
  TEST_ASSERT_FALSE(interpolation_stale(20, 1));
  TEST_ASSERT_TRUE(interpolation_stale(21, 1));
  TEST_ASSERT_FALSE(interpolation_stale(30, 10));
  TEST_ASSERT_TRUE(interpolation_stale(31, 10));
}

static void test_an_interpolation_that_is_never_fed_stays_defined(void) {
  position_interpolation state;
  position_interpolation_reset(&state, 77, 0.0f);
  state.elapsed_ticks = INT32_MAX - 1;
  for (int i = 0; i < 5; ++i) {
    TEST_ASSERT_TRUE(position_interpolation_step(&state, dt_s).position == 77);
  }
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_the_second_set_point_ends_a_parabola_from_the_start);
  RUN_TEST(test_positions_on_a_parabola_are_followed_exactly_one_period_late);
  RUN_TEST(test_position_and_rate_go_on_without_a_step_whatever_the_set_points_do);
  RUN_TEST(test_the_axis_keeps_its_rate_until_the_first_set_point_arrives);
  RUN_TEST(test_a_new_set_point_begins_exactly_at_the_present_demand);
  RUN_TEST(test_a_late_set_point_is_bridged_with_the_last_slope);
  RUN_TEST(test_a_set_point_too_far_away_is_approached_at_the_rate_limit);
  RUN_TEST(test_rates_on_a_straight_line_are_followed_exactly_one_period_late);
  RUN_TEST(test_a_rate_is_held_when_no_set_point_follows);
  RUN_TEST(test_periods_of_1_to_255_ms_are_taken_in_every_spelling);
  RUN_TEST(test_set_points_have_stopped_after_three_periods_but_never_before_20_ms);
  RUN_TEST(test_an_interpolation_that_is_never_fed_stays_defined);
  return UNITY_END();
}
