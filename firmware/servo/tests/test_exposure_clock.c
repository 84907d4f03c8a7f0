/* SPDX-License-Identifier: Apache-2.0 */
/* The age of an exposure that an image processor has stamped with the node's clock (1013), also when that is set. */
#include "servo/exposure_clock.h"

#include "unity.h"

static exposure_clock clock;
static uint32_t machine_us;

/* Ticks of the machine; the stamps are of the coming one. */
static void pass_ms(unsigned ms) {
  for (unsigned i = 0; i < ms; ++i) {
    machine_us += 1000;
    exposure_clock_tick(&clock, machine_us);
  }
}

/* What an image processor sends: 1013 / 10, 16 bits. */
static uint16_t stamp_of(uint32_t time_us) { return (uint16_t)(time_us / 10); }

static int32_t age_of(uint32_t time_us) { return exposure_clock_age(&clock, stamp_of(time_us)); }

/* 1013 becomes this at the coming tick. */
static void set_clock(uint32_t time_us) { exposure_clock_set(&clock, time_us, machine_us); }

static uint32_t now_us(void) { return machine_us + clock.offset_us; }

void setUp(void) {
  exposure_clock_reset(&clock);
  machine_us = 0;
  pass_ms(1000);
}

void tearDown(void) {}

static void test_age_is_the_difference_of_the_clocks(void) {
  TEST_ASSERT_EQUAL_INT32(2000, age_of(now_us() - 20000));
  TEST_ASSERT_EQUAL_INT32(0, age_of(now_us()));
  TEST_ASSERT_EQUAL_INT32(-1, age_of(now_us() + 10));
  TEST_ASSERT_EQUAL_INT32(12700, age_of(now_us() - 127000));
}

static void test_stamps_wrap_after_655_ms(void) {
  while (clock.stamp > 100) {
    pass_ms(1);
  }
  TEST_ASSERT_EQUAL_INT32(2000, exposure_clock_age(&clock, (uint16_t)(clock.stamp - 2000)));
  TEST_ASSERT_EQUAL_INT32(-500, exposure_clock_age(&clock, (uint16_t)(clock.stamp + 500)));
}

/* A time producer corrects a drift of 100 us: nothing else than this difference is seen. */
static void test_a_small_correction_is_no_jump(void) {
  const uint32_t exposed_us = now_us() - 20000;
  set_clock(now_us() + 100);
  pass_ms(1);
  TEST_ASSERT_EQUAL_INT32(2110, age_of(exposed_us));
  TEST_ASSERT_EQUAL_INT32(0, age_of(now_us()));
}

/* Frames in flight were stamped before 1013 was set, by 3 s: they keep their age. Later ones have the new clock. */
static void test_setting_the_clock_does_not_change_the_age_of_frames_in_flight(void) {
  const uint32_t before_us = now_us() - 5000;
  set_clock(now_us() + 3000000);
  pass_ms(1);
  TEST_ASSERT_EQUAL_INT32(600, age_of(before_us));
  pass_ms(9);
  const uint32_t after_us = now_us() - 3000;
  pass_ms(10);
  TEST_ASSERT_EQUAL_INT32(2500, age_of(before_us));
  TEST_ASSERT_EQUAL_INT32(1300, age_of(after_us));
}

/* In the tick of the jump itself the old clock counts; a ms later an exposure of that tick does, and a later one is in
 * the new clock. */
static void test_an_exposure_in_the_tick_of_the_jump_is_of_the_old_clock(void) {
  const uint32_t at_us = now_us() + 1000;
  set_clock(now_us() + 3000000);
  pass_ms(1);
  TEST_ASSERT_EQUAL_INT32(0, age_of(at_us));
  pass_ms(1);
  TEST_ASSERT_EQUAL_INT32(100, age_of(at_us));
}

/* A sender in step with the new time from the start: its frames from before the jump were exposed in this clock. */
static void test_the_old_clock_is_forgotten_when_no_frame_can_be_that_old(void) {
  const uint32_t before_us = now_us();
  set_clock(now_us() + 100000);
  pass_ms(127);
  TEST_ASSERT_EQUAL_INT32(12700, age_of(before_us));
  pass_ms(10);
  TEST_ASSERT_EQUAL_INT32(10000 + 13700, age_of(before_us));
}

/* Set back by 5 ms: a stamp of 16 ms ago can be from before or after. It has no age, instead of a wrong one. */
static void test_a_stamp_with_two_readings_has_no_age(void) {
  set_clock(now_us() - 5000);
  pass_ms(18);
  TEST_ASSERT_EQUAL_INT32(CAMERA_AGE_AMBIGUOUS, age_of(now_us() - 16000));
  TEST_ASSERT_EQUAL_INT32(1000, age_of(now_us() - 10000));
  TEST_ASSERT_EQUAL_INT32(3000, age_of(now_us() - 25000)); /* 30 ms by the old clock */
}

/* Set back by 5 ms: 17 ms after it. Both readings hold from its own tick on, and while the old one may be that old. */
static void test_a_stamp_has_two_readings_where_both_clocks_may_have_given_it(void) {
  set_clock(now_us() - 5000);
  pass_ms(4);
  TEST_ASSERT_EQUAL_INT32(CAMERA_AGE_AMBIGUOUS, age_of(now_us())); /* of now, or of 2 ms before the jump */
  TEST_ASSERT_EQUAL_INT32(499, age_of(now_us() + 10));
  TEST_ASSERT_EQUAL_INT32(CAMERA_AGE_AMBIGUOUS, age_of(now_us() - 3000)); /* in the tick of the jump */
  TEST_ASSERT_EQUAL_INT32(801, age_of(now_us() - 3010));
  pass_ms(14);
  TEST_ASSERT_EQUAL_INT32(CAMERA_AGE_AMBIGUOUS, age_of(now_us() - 12000));
  TEST_ASSERT_EQUAL_INT32(1199, age_of(now_us() - 11990));
  TEST_ASSERT_EQUAL_INT32(EXPOSURE_CLOCK_FORGETS - 1, age_of(now_us() - 122990));
  TEST_ASSERT_EQUAL_INT32(EXPOSURE_CLOCK_FORGETS - 500, age_of(now_us() - 123000));
}

/* 500 us are a jump, 490 are none; either way. Frames in flight have the age that they had only after a jump. */
static void test_half_a_ms_is_a_jump(void) {
  static const struct {
    int32_t by_us;
    bool jumps;
  } rows[] = {{500, true}, {490, false}, {-500, true}, {-490, false}};
  for (unsigned i = 0; i < sizeof rows / sizeof rows[0]; ++i) {
    setUp();
    const uint32_t exposed_us = now_us() - 20000;
    set_clock(now_us() + (uint32_t)rows[i].by_us);
    pass_ms(1);
    TEST_ASSERT_EQUAL_INT32(2100 + (rows[i].jumps ? 0 : rows[i].by_us / 10), age_of(exposed_us));
  }
}

/* 2^32 us are not a multiple of 2^16 times 10 us: the stamps jump. */
static void test_frames_in_flight_survive_the_wrap_of_1013(void) {
  set_clock(UINT32_MAX - 200000);
  pass_ms(190);
  const uint32_t before_us = now_us() - 1000;
  pass_ms(20);
  TEST_ASSERT_TRUE(now_us() < 20000);
  TEST_ASSERT_INT32_WITHIN(1, 2100, age_of(before_us));
  TEST_ASSERT_EQUAL_INT32(500, age_of(now_us() - 5000));
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_age_is_the_difference_of_the_clocks);
  RUN_TEST(test_stamps_wrap_after_655_ms);
  RUN_TEST(test_a_small_correction_is_no_jump);
  RUN_TEST(test_setting_the_clock_does_not_change_the_age_of_frames_in_flight);
  RUN_TEST(test_an_exposure_in_the_tick_of_the_jump_is_of_the_old_clock);
  RUN_TEST(test_the_old_clock_is_forgotten_when_no_frame_can_be_that_old);
  RUN_TEST(test_a_stamp_with_two_readings_has_no_age);
  RUN_TEST(test_a_stamp_has_two_readings_where_both_clocks_may_have_given_it);
  RUN_TEST(test_half_a_ms_is_a_jump);
  RUN_TEST(test_frames_in_flight_survive_the_wrap_of_1013);
  return UNITY_END();
}
