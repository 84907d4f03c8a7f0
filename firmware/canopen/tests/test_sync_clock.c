/* SPDX-License-Identifier: Apache-2.0 */
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

/* The counts end: 4,294,977 ms are 2^32 us and 10 ms, but no period of 10 ms. */
static void test_a_pause_of_71_minutes_begins_anew(void) {
  sync_clock clock = {0};
  for (int ms = 1; ms <= 1000; ++ms) {
    sync_clock_tick(&clock);
    TEST_ASSERT_FALSE(ms % 10 == 0 && sync_clock_hear(&clock, 10000));
  }
  for (int ms = 0; ms < 4294977; ++ms) {
    sync_clock_tick(&clock);
  }
  TEST_ASSERT_FALSE(sync_clock_hear(&clock, 10000));
  TEST_ASSERT_EQUAL(0, clock.ticks);
  TEST_ASSERT_EQUAL(0, clock.deviating); /* the window has been abandoned */
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

/* A SYNC after so many ticks. */
static bool hear_after(sync_clock *clock, uint32_t ticks, uint32_t period_us) {
  for (uint32_t i = 0; i < ticks; ++i) {
    sync_clock_tick(clock);
  }
  return sync_clock_hear(clock, period_us);
}

/* An interval counts from half a period minus a tick to one and a half periods plus a tick. It is the first one of a
 * window, and then the second. */
static void test_an_interval_counts_from_half_a_period_to_one_and_a_half(void) {
  for (uint32_t ticks = 0; ticks < 20; ++ticks) {
    const bool regular = ticks >= 4 && ticks <= 16;
    sync_clock clock = {0};
    TEST_ASSERT_FALSE(hear_after(&clock, 7, 10000));
    TEST_ASSERT_TRUE(clock.open);
    TEST_ASSERT_EQUAL(0, clock.ticks);
    TEST_ASSERT_FALSE(hear_after(&clock, ticks, 10000));
    TEST_ASSERT_EQUAL(regular ? 1 : 0, clock.syncs);
    TEST_ASSERT_EQUAL(regular ? ticks : 0, clock.ticks);
    sync_clock_reset(&clock);
    (void)hear_after(&clock, 7, 10000);
    (void)hear_after(&clock, 10, 10000);
    (void)hear_after(&clock, ticks, 10000);
    TEST_ASSERT_EQUAL(regular ? 2 : 0, clock.syncs);
    TEST_ASSERT_EQUAL(regular ? 10 + ticks : 0, clock.ticks);
  }
}

static void test_a_window_ends_at_the_first_sync_after_2_s(void) {
  sync_clock clock = {0};
  (void)hear_after(&clock, 1, 10000);
  for (uint32_t syncs = 1; syncs < 200; ++syncs) {
    (void)hear_after(&clock, 10, 10000);
    TEST_ASSERT_EQUAL(syncs, clock.syncs);
  }
  (void)hear_after(&clock, 10, 10000);
  TEST_ASSERT_EQUAL(0, clock.syncs);
  TEST_ASSERT_EQUAL(0, clock.ticks);
  for (uint32_t syncs = 1; syncs < 200; ++syncs) {
    (void)hear_after(&clock, 10, 10000);
  }
  (void)hear_after(&clock, 9, 10000); /* at 1,999 ms: not yet */
  TEST_ASSERT_EQUAL(200, clock.syncs);
}

/* A window in which `regular` SYNCs come every 100 ms, and the last two after the given intervals. */
static void window(sync_clock *clock, uint32_t regular, uint32_t before_ms, uint32_t last_ms) {
  for (uint32_t i = 0; i < regular; ++i) {
    TEST_ASSERT_FALSE(hear_after(clock, 100, 100000));
  }
  (void)hear_after(clock, before_ms, 100000);
  (void)hear_after(clock, last_ms, 100000);
  TEST_ASSERT_EQUAL(0, clock->syncs);
}

/* 0.7 % of 20 periods is 14 ms, of 21 periods 14.7 ms; and 3 ms. */
static void test_a_window_deviates_beyond_0_7_percent_and_3_ms(void) {
  static const struct {
    uint32_t regular, before_ms, last_ms;
    int deviating;
  } windows[] = {{18, 100, 117, 0}, {18, 100, 118, 1}, {19, 99, 84, 0}, {19, 99, 83, 1}};
  for (unsigned i = 0; i < sizeof windows / sizeof windows[0]; ++i) {
    sync_clock clock = {0};
    (void)hear_after(&clock, 1, 100000);
    window(&clock, windows[i].regular, windows[i].before_ms, windows[i].last_ms);
    TEST_ASSERT_EQUAL(windows[i].deviating, clock.deviating);
    TEST_ASSERT_FALSE(clock.off);
  }
}

static void test_a_window_without_deviation_between_two_that_deviate_starts_the_count_again(void) {
  sync_clock clock = {0};
  (void)hear_after(&clock, 1, 100000);
  window(&clock, 18, 100, 118);
  window(&clock, 18, 100, 100);
  window(&clock, 18, 100, 118);
  TEST_ASSERT_FALSE(clock.off);
  window(&clock, 18, 100, 118);
  TEST_ASSERT_TRUE(clock.off);
}

static void test_a_period_of_1_s_is_compared(void) {
  sync_clock clock = {0};
  (void)hear_after(&clock, 1, 1000000);
  (void)hear_after(&clock, 1501, 1000000);
  TEST_ASSERT_EQUAL(1, clock.syncs);
  (void)hear_after(&clock, 1502, 1000000);
  TEST_ASSERT_EQUAL(0, clock.syncs);
  TEST_ASSERT_EQUAL(0, clock.deviating); /* this window has been abandoned */
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_a_drift_of_1_percent_is_found_within_7_s_and_of_0_5_percent_never);
  RUN_TEST(test_jitter_of_a_sender_is_no_drift);
  RUN_TEST(test_a_lost_or_additional_sync_begins_anew);
  RUN_TEST(test_a_clock_that_is_right_again_is_not_off);
  RUN_TEST(test_a_clock_that_stays_wrong_stays_off_and_a_reset_forgets_it);
  RUN_TEST(test_a_pause_of_71_minutes_begins_anew);
  RUN_TEST(test_without_a_period_or_with_one_above_a_second_nothing_is_compared);
  RUN_TEST(test_an_interval_counts_from_half_a_period_to_one_and_a_half);
  RUN_TEST(test_a_window_ends_at_the_first_sync_after_2_s);
  RUN_TEST(test_a_window_deviates_beyond_0_7_percent_and_3_ms);
  RUN_TEST(test_a_window_without_deviation_between_two_that_deviate_starts_the_count_again);
  RUN_TEST(test_a_period_of_1_s_is_compared);
  return UNITY_END();
}
