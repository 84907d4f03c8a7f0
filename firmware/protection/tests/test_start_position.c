/* SPDX-License-Identifier: Apache-2.0 */
/* Which turn an axis is in: from the travel, by motion, by confirmation. */
#include "protection/start_position.h"

#include "support/check.h"
#include "unity.h"

#define DEG 0.01745329252f

void setUp(void) {}
void tearDown(void) {}

static start_candidates step(start_position *start, float count_deg) {
  return start_position_step(start, count_deg * DEG, -279.0f * DEG, 279.0f * DEG);
}

static void test_a_start_near_zero_is_known_and_one_beyond_75_degrees_is_not(void) {
  for (int count_deg = -180; count_deg <= 180; ++count_deg) {
    start_position start = {0};
    const start_candidates found = step(&start, (float)count_deg);
    const bool sure = count_deg > -76 && count_deg < 76;
    TEST_ASSERT_EQUAL(sure, found.known);
    TEST_ASSERT_EQUAL(0, start.turn);
    TEST_ASSERT_EQUAL(count_deg <= -76 ? 1 : 0, found.highest);
    TEST_ASSERT_EQUAL(count_deg >= 76 ? -1 : 0, found.lowest);
  }
}

static void test_a_count_beyond_34_turns_of_the_travel_is_in_no_turn(void) {
  for (int sign = -1; sign <= 1; sign += 2) {
    start_position start = {0};
    TEST_ASSERT_TRUE(step(&start, (float)(sign * 34 * 360)).known);
    TEST_ASSERT_EQUAL(-sign * 34, start.turn);
    start = (start_position){0};
    const start_candidates found = step(&start, (float)(sign * 36 * 360));
    TEST_ASSERT_FALSE(found.known);
    TEST_ASSERT_TRUE(found.lowest > found.highest);
  }
}

/* The margin is the distance from the hard travel to the end stops: of two angles a revolution apart one is beyond
 * them. */
static void test_between_end_stops_at_280_degrees_a_reading_within_80_degrees_is_sure(void) {
  const float hard_rad = 280.0f * DEG - START_POSITION_MARGIN_RAD;
  for (int count_deg = -180; count_deg <= 180; ++count_deg) {
    if (count_deg == -80 || count_deg == 80) {
      continue; /* the other angle is at an end stop */
    }
    start_position start = {0};
    const start_candidates found = start_position_step(&start, (float)count_deg * DEG, -hard_rad, hard_rad);
    TEST_ASSERT_EQUAL(count_deg > -80 && count_deg < 80, found.known);
    start_position_confirm(&start, count_deg < 0 ? 1 : -1); /* beyond them, only who has seen it knows */
    TEST_ASSERT_TRUE(start_position_step(&start, (float)count_deg * DEG, -hard_rad, hard_rad).known);
  }
}

static void test_motion_excludes_the_turns_that_would_be_outside(void) {
  start_position start = {0};
  float count_deg = -120.0f; /* or 240 */
  while (!step(&start, count_deg).known && count_deg < 0.0f) {
    count_deg += 0.1f;
  }
  CHECK_NEAR("degrees", 279.0 + 5.73 - 360.0, count_deg, 0.2);
  TEST_ASSERT_EQUAL(0, start.turn);
  TEST_ASSERT_TRUE(step(&start, -120.0f).known); /* what was excluded once stays so */
}

static void test_motion_into_the_far_turn_is_found_as_well(void) {
  start_position start = {0};
  float count_deg = -120.0f; /* truly 240 */
  while (!step(&start, count_deg).known && count_deg > -400.0f) {
    count_deg -= 0.1f;
  }
  CHECK_NEAR("degrees", -284.8, count_deg, 0.2);
  TEST_ASSERT_EQUAL(1, start.turn);
}

static void test_a_travel_within_one_turn_that_is_not_around_zero_has_one_candidate(void) {
  start_position start = {0};
  const start_candidates found = start_position_step(&start, -160.0f * DEG, 10.0f * DEG, 350.0f * DEG);
  TEST_ASSERT_TRUE(found.known);
  TEST_ASSERT_EQUAL(1, start.turn);
}

static void test_the_operator_confirms_and_a_lost_encoder_forgets(void) {
  start_position start = {0};
  TEST_ASSERT_FALSE(step(&start, -120.0f).known);
  start_position_confirm(&start, 1);
  TEST_ASSERT_TRUE(step(&start, -120.0f).known);
  TEST_ASSERT_EQUAL(1, start.turn);
  start_position_forget(&start);
  TEST_ASSERT_FALSE(step(&start, -120.0f).known);
}

static void test_a_rough_position_gives_its_turn_and_one_between_two_gives_none(void) {
  int8_t turn;
  TEST_ASSERT_TRUE(start_position_turn_at(-2.0f, 4.0f, &turn)); /* 4.283 */
  TEST_ASSERT_EQUAL_INT8(1, turn);
  TEST_ASSERT_TRUE(start_position_turn_at(-2.0f, -3.5f, &turn));
  TEST_ASSERT_EQUAL_INT8(0, turn);
  TEST_ASSERT_FALSE(start_position_turn_at(-2.0f, 1.0f, &turn)); /* nearly half a turn from both */
  TEST_ASSERT_FALSE(start_position_turn_at(0.0f, 219.9f, &turn));
  TEST_ASSERT_FALSE(start_position_turn_at(-214.7f, 214.7f, &turn)); /* beyond 34 turns */
}

static void test_what_the_operator_has_seen_counts_once_and_only_when_it_is_taken(void) {
  start_position start = {.turn = 0};
  start_position_see(&start, 1);
  TEST_ASSERT_FALSE(start_position_step(&start, -2.0f, -4.9f, 4.9f).known);
  start_position_take_seen(&start);
  TEST_ASSERT_TRUE(start_position_step(&start, -2.0f, -4.9f, 4.9f).known);
  TEST_ASSERT_EQUAL_INT8(1, start.turn);
  start_position_forget(&start);
  start_position_take_seen(&start);
  TEST_ASSERT_FALSE(start_position_step(&start, -2.0f, -4.9f, 4.9f).known);
  start_position_see(&start, 1);
  start_position_forget(&start);
  start_position_take_seen(&start);
  TEST_ASSERT_FALSE(start_position_step(&start, -2.0f, -4.9f, 4.9f).known);
}

/* Nor what was known before it was forgotten. */
static void test_outside_of_the_travel_there_is_no_candidate_and_nothing_is_known(void) {
  start_position start = {0};
  for (int again = 0; again < 2; ++again) {
    const start_candidates found = start_position_step(&start, 150.0f * DEG, -19.0f * DEG, 94.0f * DEG);
    TEST_ASSERT_FALSE(found.known);
    TEST_ASSERT_TRUE(found.highest < found.lowest);
    start_position_forget(&start);
    TEST_ASSERT_TRUE(step(&start, 0.0f).known);
    start_position_forget(&start);
  }
}

/* The user sets a smaller travel after the axis has been outside of it. */
static void test_a_known_position_stays_known_when_the_travel_becomes_smaller_but_not_when_it_becomes_larger(void) {
  start_position start = {0};
  (void)step(&start, 0.0f);
  TEST_ASSERT_TRUE(step(&start, 38.0f).known);
  const start_candidates smaller = start_position_step(&start, 38.0f * DEG, 8.0f * DEG, 37.0f * DEG);
  TEST_ASSERT_TRUE(smaller.known && smaller.lowest > smaller.highest);
  TEST_ASSERT_EQUAL(0, start.turn);
  TEST_ASSERT_FALSE(start_position_step(&start, 38.0f * DEG, -800.0f * DEG, 800.0f * DEG).known);
  TEST_ASSERT_FALSE(start_position_step(&start, 38.0f * DEG, 8.0f * DEG, 37.0f * DEG).known);
  start_position_forget(&start);
  TEST_ASSERT_TRUE(step(&start, 38.0f).known);
}

static void test_without_a_travel_every_count_is_the_position(void) {
  start_position start = {0};
  TEST_ASSERT_TRUE(start_position_step(&start, 3.0f, 0.0f, 0.0f).known);
  TEST_ASSERT_TRUE(start_position_step(&start, 300.0f, 0.0f, 0.0f).known);
  TEST_ASSERT_EQUAL(0, start.turn);
}

/* Limits of +-200 rad are 31 turns to either side. */
static void test_the_widest_travel_does_not_overflow(void) {
  start_position start = {0};
  const start_candidates found = start_position_step(&start, 0.0f, -200.0f, 200.0f);
  TEST_ASSERT_EQUAL(-31, found.lowest);
  TEST_ASSERT_EQUAL(31, found.highest);
  const start_candidates far = start_position_step(&start, 1e4f, -200.0f, 200.0f);
  TEST_ASSERT_FALSE(far.known);
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_a_start_near_zero_is_known_and_one_beyond_75_degrees_is_not);
  RUN_TEST(test_a_count_beyond_34_turns_of_the_travel_is_in_no_turn);
  RUN_TEST(test_between_end_stops_at_280_degrees_a_reading_within_80_degrees_is_sure);
  RUN_TEST(test_motion_excludes_the_turns_that_would_be_outside);
  RUN_TEST(test_motion_into_the_far_turn_is_found_as_well);
  RUN_TEST(test_a_travel_within_one_turn_that_is_not_around_zero_has_one_candidate);
  RUN_TEST(test_the_operator_confirms_and_a_lost_encoder_forgets);
  RUN_TEST(test_a_rough_position_gives_its_turn_and_one_between_two_gives_none);
  RUN_TEST(test_what_the_operator_has_seen_counts_once_and_only_when_it_is_taken);
  RUN_TEST(test_outside_of_the_travel_there_is_no_candidate_and_nothing_is_known);
  RUN_TEST(test_a_known_position_stays_known_when_the_travel_becomes_smaller_but_not_when_it_becomes_larger);
  RUN_TEST(test_without_a_travel_every_count_is_the_position);
  RUN_TEST(test_the_widest_travel_does_not_overflow);
  return UNITY_END();
}
