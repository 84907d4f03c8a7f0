/* SPDX-License-Identifier: Apache-2.0 */
/* Standstill: an axis that nobody commands to move stays where it is. */
#include "protection/standstill_monitor.h"

#include "support/check.h"
#include "unity.h"

#define DT_S 0.001f
#define WINDOW_RAD 0.01f

void setUp(void) {}
void tearDown(void) {}

static standstill_monitor standing(void) {
  standstill_monitor monitor = {0};
  for (int i = 0; i < 1100; ++i) {
    TEST_ASSERT_FALSE(standstill_monitor_step(&monitor, WINDOW_RAD, true, 0.0f, DT_S));
  }
  return monitor;
}

static int ticks_until(standstill_monitor *monitor, float step_rad, int most) {
  for (int i = 1; i <= most; ++i) {
    if (standstill_monitor_step(monitor, WINDOW_RAD, true, step_rad, DT_S)) {
      return i;
    }
  }
  return 0;
}

static void test_leaving_the_window_is_found_in_the_tick_that_leaves_it(void) {
  for (int sign = -1; sign <= 1; sign += 2) {
    standstill_monitor monitor = standing();
    TEST_ASSERT_EQUAL(21, ticks_until(&monitor, (float)sign * 5e-4f, 100));
  }
}

static void test_the_first_second_after_a_command_may_move(void) {
  standstill_monitor monitor = standing();
  TEST_ASSERT_FALSE(standstill_monitor_step(&monitor, WINDOW_RAD, false, 0.0f, DT_S));
  TEST_ASSERT_EQUAL(0, ticks_until(&monitor, 1e-3f, 1000));
  TEST_ASSERT_INT_WITHIN(1, 11, ticks_until(&monitor, 1e-3f, 20));
}

static void test_the_creep_of_a_gyro_is_tolerated_for_ever_and_ten_times_of_it_is_not(void) {
  standstill_monitor monitor = standing();
  TEST_ASSERT_EQUAL(0, ticks_until(&monitor, 0.9e-7f, 2000000));
  monitor = standing();
  TEST_ASSERT_INT_WITHIN(50, 11111, ticks_until(&monitor, 1e-6f, 20000));
}

static void test_the_delay_is_one_second(void) {
  standstill_monitor monitor = {0};
  for (int i = 0; i < 4; ++i) { /* a dt of which four are exactly a second */
    TEST_ASSERT_FALSE(standstill_monitor_step(&monitor, WINDOW_RAD, true, 1.0f, 0.25f));
  }
  TEST_ASSERT_TRUE(standstill_monitor_step(&monitor, WINDOW_RAD, true, 1.0f, 0.25f));
}

static void test_a_disturbance_that_comes_back_is_none(void) {
  standstill_monitor monitor = standing();
  for (int i = 0; i < 10000; ++i) {
    TEST_ASSERT_FALSE(standstill_monitor_step(&monitor, WINDOW_RAD, true, i % 20 < 10 ? 9e-4f : -9e-4f, DT_S));
  }
}

static void test_a_window_of_0_monitors_nothing(void) {
  standstill_monitor monitor = standing();
  TEST_ASSERT_FALSE(standstill_monitor_step(&monitor, 0.0f, true, 1.0f, DT_S));
  CHECK_SAME("rad", 0.0, monitor.from_rad);
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_leaving_the_window_is_found_in_the_tick_that_leaves_it);
  RUN_TEST(test_the_first_second_after_a_command_may_move);
  RUN_TEST(test_the_creep_of_a_gyro_is_tolerated_for_ever_and_ten_times_of_it_is_not);
  RUN_TEST(test_the_delay_is_one_second);
  RUN_TEST(test_a_disturbance_that_comes_back_is_none);
  RUN_TEST(test_a_window_of_0_monitors_nothing);
  return UNITY_END();
}
