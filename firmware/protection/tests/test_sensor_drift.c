/* SPDX-License-Identifier: Apache-2.0 */
/* Encoder and gyro in the long run, on a base that does not turn. */
#include "protection/sensor_drift.h"

#include <math.h>

#include "support/check.h"
#include "unity.h"

#define DT_S 0.001f
#define WINDOW_RAD 0.005f

void setUp(void) {}
void tearDown(void) {}

/* Seconds until a constant difference is found; 0: not within a minute. */
static float seconds_until(float difference_rad_s) {
  sensor_drift drift = {0};
  for (int i = 1; i <= 60000; ++i) {
    if (sensor_drift_step(&drift, WINDOW_RAD, difference_rad_s, 0.0f, DT_S)) {
      return (float)i * DT_S;
    }
  }
  return 0.0f;
}

static void test_a_difference_below_the_base_rate_is_found_when_the_header_says(void) {
  for (int sign = -1; sign <= 1; sign += 2) {
    const float rate_rad_s = (float)sign * 0.019f;
    const double expected_s = -5.0 * log(1.0 - 0.005 / (0.019 * 5.0));
    CHECK_NEAR("s", expected_s, seconds_until(rate_rad_s), 0.003);
  }
  CHECK_AT_MOST("s", 4.5, seconds_until(0.0017f));
}

static void test_a_bias_below_the_window_over_the_memory_is_tolerated(void) {
  CHECK_SAME("s", 0.0, seconds_until(0.98f * WINDOW_RAD / SENSOR_DRIFT_MEMORY_S));
  TEST_ASSERT_TRUE(seconds_until(1.03f * WINDOW_RAD / SENSOR_DRIFT_MEMORY_S) > 10.0f);
}

static void test_a_scale_error_of_the_gyro_is_no_drift_while_the_axis_turns(void) {
  sensor_drift drift = {0};
  for (int i = 0; i < 20000; ++i) {
    const float rate_rad_s = i < 10000 ? 1.0f : -1.4f;
    TEST_ASSERT_FALSE(sensor_drift_step(&drift, WINDOW_RAD, 0.004f * rate_rad_s, rate_rad_s, DT_S));
  }
  bool found = false;
  for (int i = 0; i < 20000; ++i) {
    found = found || sensor_drift_step(&drift, WINDOW_RAD, 0.02f, 1.0f, DT_S);
  }
  TEST_ASSERT_TRUE(found);
}

/* At 1 rad/s the path of the memory is 5 rad: 0.5 % of it, and the window, are 30 mrad. */
static void test_a_scale_error_of_half_a_percent_beside_the_window_is_permitted(void) {
  for (int sign = -1; sign <= 1; sign += 2) {
    for (int beyond = 0; beyond <= 1; ++beyond) {
      sensor_drift drift = {0};
      bool found = false;
      for (int i = 0; i < 60000; ++i) {
        const float difference_rad_s = (float)sign * (beyond == 0 ? 5.96e-3f : 6.04e-3f);
        found = found || sensor_drift_step(&drift, WINDOW_RAD, difference_rad_s, (float)sign, DT_S);
      }
      TEST_ASSERT_EQUAL(beyond != 0, found);
    }
  }
}

static void test_a_base_that_moves_is_not_compared_and_begins_anew_when_it_is_fixed(void) {
  sensor_drift drift = {0};
  for (int i = 0; i < 10000; ++i) {
    TEST_ASSERT_FALSE(sensor_drift_step(&drift, 0.0f, 0.5f, 0.0f, DT_S));
  }
  CHECK_SAME("rad", 0.0, drift.difference_rad);
  TEST_ASSERT_FALSE(sensor_drift_step(&drift, WINDOW_RAD, 0.5f, 0.0f, DT_S));
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_a_difference_below_the_base_rate_is_found_when_the_header_says);
  RUN_TEST(test_a_bias_below_the_window_over_the_memory_is_tolerated);
  RUN_TEST(test_a_scale_error_of_the_gyro_is_no_drift_while_the_axis_turns);
  RUN_TEST(test_a_scale_error_of_half_a_percent_beside_the_window_is_permitted);
  RUN_TEST(test_a_base_that_moves_is_not_compared_and_begins_anew_when_it_is_fixed);
  return UNITY_END();
}
