/* SPDX-License-Identifier: Apache-2.0 */
/* The rate towards a target within the braking of a joint: values, slope, and a joint that makes it. */
#include "control/approach.h"

#include "support/check.h"

void setUp(void) {}
void tearDown(void) {}

static void test_close_to_the_target_it_is_proportional(void) {
  CHECK_SAME("rate, rad/s", 20.0f * 2e-3f, approach_rate(20.0f, 1.0f, 2e-3f));
  CHECK_SAME("without a limit", 20.0f * 3.0f, approach_rate(20.0f, 0.0f, 3.0f));
  CHECK_SAME("without a loop", 0.0, approach_rate(0.0f, 1.0f, 3.0f));
}

static void test_value_and_slope_are_continuous_where_braking_begins(void) {
  const float edge_rad = 1.0f / (20.0f * 20.0f);
  const double step_rad = 0.01 * (double)edge_rad;
  const double before = (double)approach_rate(20.0f, 1.0f, edge_rad);
  const double after = (double)approach_rate(20.0f, 1.0f, edge_rad + (float)step_rad);
  CHECK_NEAR("slope, 1/s", 20.0, (after - before) / step_rad, 0.2);
}

static void test_both_directions_are_alike(void) {
  CHECK_SAME("rate", -approach_rate(20.0f, 1.0f, 0.3f), approach_rate(20.0f, 1.0f, -0.3f));
}

/* From rest, 0.25 rad away, with 1 rad/s^2: half of the path up, half down, 1 s. A proportional law overshoots. */
static void test_a_joint_at_its_limit_arrives_in_the_least_time_and_does_not_overshoot(void) {
  double angle_rad = 0.0;
  double rate_rad_s = 0.0;
  double time_s = 0.0;
  double farthest_rad = 0.0;
  for (int i = 0; i < 3000; ++i) {
    const double wanted = (double)approach_rate(20.0f, 1.0f, (float)(0.25 - angle_rad));
    rate_rad_s += fmax(-1e-3, fmin(1e-3, wanted - rate_rad_s));
    angle_rad += 1e-3 * rate_rad_s;
    farthest_rad = fmax(farthest_rad, angle_rad);
    time_s = fabs(angle_rad - 0.25) > 1e-3 ? 1e-3 * (double)(i + 1) : time_s;
  }
  LOG_VALUE("within 1 mrad after, s", time_s);
  CHECK_AT_MOST("time, s", 1.05, time_s);
  CHECK_AT_MOST("overshoot, rad", 1e-4, farthest_rad - 0.25);
}

static void test_a_target_that_slows_down_takes_its_share_of_the_braking(void) {
  CHECK_NEAR("it slows down", 0.4, approach_braking(1.0f, 0.1f, -0.6f), 1e-6);
  CHECK_NEAR("behind, likewise", 0.4, approach_braking(1.0f, -0.1f, 0.6f), 1e-6);
  CHECK_SAME("it speeds up", 1.0, approach_braking(1.0f, 0.1f, 0.6f));
  CHECK_SAME("it slows down harder than the joint can", 0.1f, approach_braking(1.0f, 0.1f, -3.0f));
  CHECK_SAME("no limit", 0.0, approach_braking(0.0f, 0.1f, -3.0f));
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_close_to_the_target_it_is_proportional);
  RUN_TEST(test_value_and_slope_are_continuous_where_braking_begins);
  RUN_TEST(test_both_directions_are_alike);
  RUN_TEST(test_a_joint_at_its_limit_arrives_in_the_least_time_and_does_not_overshoot);
  RUN_TEST(test_a_target_that_slows_down_takes_its_share_of_the_braking);
  return UNITY_END();
}
