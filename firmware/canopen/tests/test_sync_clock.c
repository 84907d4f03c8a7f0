/* The node's clock against that of the SYNC producer. */
#include "canopen/sync_clock.h"

#include <math.h>

#include "unity.h"

void setUp(void) {}
void tearDown(void) {}

/* Seconds of the node until its clock is off; 0: not within a minute. The SYNCs come too slowly by the share `drift`,
 * with a jitter of `jitter_ms` to either side. */
static double seconds_until(sync_clock *clock, uint32_t period_us, double drift, double jitter_ms) {
  double next_ms = 5.0;
  uint32_t number = 0;
  for (int ms = 1; ms <= 60000; ++ms) {
    sync_clock_tick(clock);
    const double late_ms = jitter_ms * (number % 2u == 0 ? 1.0 : -1.0);
    if ((double)ms >= next_ms + late_ms) {
      const bool changed = sync_clock_hear(clock, period_us);
      TEST_ASSERT_EQUAL(clock->off, changed);
      next_ms += 1e-3 * period_us * (1.0 + drift);
      ++number;
    }
    if (clock->off) {
      return 1e-3 * ms;
    }
  }
  return 0.0;
}

static void test_a_drift_of_1_percent_is_found_within_7_s_and_of_0_5_percent_never(void) {
  static const uint32_t periods_us[] = {2000, 5000, 10000, 100000, 1000000};
  for (unsigned i = 0; i < sizeof periods_us / sizeof periods_us[0]; ++i) {
    for (int sign = -1; sign <= 1; sign += 2) {
      sync_clock clock = {0};
      const double found_s = seconds_until(&clock, periods_us[i], 0.0101 * sign, 0.0);
      TEST_ASSERT_TRUE(found_s > 0.0 && found_s < 7.1);
      clock = (sync_clock){0};
      TEST_ASSERT_TRUE(seconds_until(&clock, periods_us[i], 0.05 * sign, 0.0) > 0.0);
      clock = (sync_clock){0};
      TEST_ASSERT_EQUAL_DOUBLE(0.0, seconds_until(&clock, periods_us[i], 0.005 * sign, 0.0));
    }
  }
}

static void test_jitter_of_a_sender_is_no_drift(void) {
  sync_clock clock = {0};
  TEST_ASSERT_EQUAL_DOUBLE(0.0, seconds_until(&clock, 10000, 0.0, 2.0));
}

static void test_a_lost_or_additional_sync_begins_anew(void) {
  sync_clock clock = {0};
  for (int ms = 1; ms <= 60000; ++ms) {
    sync_clock_tick(&clock);
    if (ms % 10 == 0 && ms % 500 != 0) {
      TEST_ASSERT_FALSE(sync_clock_hear(&clock, 10000));
    }
    if (ms % 777 == 0) {
      TEST_ASSERT_FALSE(sync_clock_hear(&clock, 10000));
    }
    TEST_ASSERT_FALSE(clock.off);
  }
}

static void test_a_clock_that_is_right_again_is_not_off(void) {
  sync_clock clock = {0};
  TEST_ASSERT_TRUE(seconds_until(&clock, 10000, 0.03, 0.0) > 0.0);
  int changes = 0;
  for (int ms = 1; ms <= 6000; ++ms) {
    sync_clock_tick(&clock);
    changes += ms % 10 == 0 && sync_clock_hear(&clock, 10000) ? 1 : 0;
  }
  TEST_ASSERT_FALSE(clock.off);
  TEST_ASSERT_EQUAL(1, changes);
}

static void test_a_clock_that_stays_wrong_stays_off_and_a_reset_forgets_it(void) {
  sync_clock clock = {0};
  TEST_ASSERT_TRUE(seconds_until(&clock, 10000, 0.2, 0.0) > 0.0);
  for (int ms = 1; ms <= 20000; ++ms) {
    sync_clock_tick(&clock);
    TEST_ASSERT_FALSE(ms % 12 == 0 && sync_clock_hear(&clock, 10000));
    TEST_ASSERT_TRUE(clock.off);
  }
  sync_clock_reset(&clock);
  TEST_ASSERT_FALSE(clock.off);
}

/* The counts end: a SYNC after an hour is one after a pause. */
static void test_a_pause_of_an_hour_begins_anew(void) {
  sync_clock clock = {0};
  for (int ms = 1; ms <= 1000; ++ms) {
    sync_clock_tick(&clock);
    TEST_ASSERT_FALSE(ms % 10 == 0 && sync_clock_hear(&clock, 10000));
  }
  for (int ms = 0; ms < 3600000; ++ms) {
    sync_clock_tick(&clock);
  }
  TEST_ASSERT_FALSE(sync_clock_hear(&clock, 10000));
  TEST_ASSERT_EQUAL(0, clock.ticks);
}

static void test_without_a_period_or_with_one_above_a_second_nothing_is_compared(void) {
  static const uint32_t periods_us[] = {0, 1000001};
  for (unsigned n = 0; n < 2; ++n) {
    sync_clock clock = {0};
    for (int ms = 0; ms < 100000; ++ms) {
      sync_clock_tick(&clock);
      TEST_ASSERT_FALSE(ms % 1100 == 0 && sync_clock_hear(&clock, periods_us[n]));
      TEST_ASSERT_FALSE(clock.off);
    }
  }
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_a_drift_of_1_percent_is_found_within_7_s_and_of_0_5_percent_never);
  RUN_TEST(test_jitter_of_a_sender_is_no_drift);
  RUN_TEST(test_a_lost_or_additional_sync_begins_anew);
  RUN_TEST(test_a_clock_that_is_right_again_is_not_off);
  RUN_TEST(test_a_clock_that_stays_wrong_stays_off_and_a_reset_forgets_it);
  RUN_TEST(test_a_pause_of_an_hour_begins_anew);
  RUN_TEST(test_without_a_period_or_with_one_above_a_second_nothing_is_compared);
  return UNITY_END();
}
