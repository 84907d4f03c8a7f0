/* SPDX-License-Identifier: Apache-2.0 */
/* Which series of errors contradict themselves, at 500 Hz and slower. */
#include "servo/jumping_picture.h"

#include <string.h>

#include "support/random.h"
#include "unity.h"

#define TICK_S 1e-3f

static jumping_picture picture;

void setUp(void) { memset(&picture, 0, sizeof picture); }
void tearDown(void) {}

/* After so many ticks since the frame before it. */
static bool show(float x_rad, float y_rad, int ticks, int age_ticks) {
  for (int i = 1; i < ticks; ++i) {
    TEST_ASSERT_FALSE(jumping_picture_take(&picture, &(pointing_frame){0}, TICK_S));
  }
  const pointing_frame frame = {
      .fresh = true, .valid = true, .age_ticks = age_ticks, .error = {.x = x_rad, .y = y_rad}};
  return jumping_picture_take(&picture, &frame, TICK_S);
}

/* Number of frames until the picture jumps, 100 at most. */
static int frames_until_it_jumps(float amplitude_rad, int ticks) {
  for (int i = 0; i < 100; ++i) {
    const float error_rad = i % 2 == 0 ? amplitude_rad : -amplitude_rad;
    if (show(0.0f, error_rad, ticks, 20)) {
      return i;
    }
  }
  return 100;
}

static void test_jumps_to_and_fro_are_found_after_7_frames(void) {
  TEST_ASSERT_EQUAL(7, frames_until_it_jumps(1e-3f, 2));
  setUp();
  TEST_ASSERT_EQUAL(7, frames_until_it_jumps(20e-3f, 2));
  setUp();
  TEST_ASSERT_EQUAL(100, frames_until_it_jumps(1e-3f, 20)); /* 2 mrad in 20 ms */
  setUp();
  TEST_ASSERT_EQUAL(100, frames_until_it_jumps(0.4e-3f, 2));
}

/* 20 mrad to and fro, for so many frames each; the first jump of six is that from the zeros before. */
static void test_errors_that_stay_for_some_frames_and_jump_far_are_found(void) {
  for (int stay = 1; stay <= 12; ++stay) {
    setUp();
    bool jumps = false;
    for (int i = 0; i < 200; ++i) {
      jumps = show(i / stay % 2 == 0 ? 20e-3f : -20e-3f, 0.0f, 2, 20);
    }
    TEST_ASSERT_EQUAL(stay <= 10, jumps);
  }
}

static int frames_until_they_count(float error_rad, int ticks) {
  int frames = 0;
  while (frames < 100 && show(0.0f, error_rad, ticks, 20)) {
    frames++;
  }
  return frames;
}

static void test_as_many_good_frames_count_again(void) {
  (void)frames_until_it_jumps(5e-3f, 2);
  /* The first of them was a jump of 5 mrad, after which 3 take nothing away. */
  TEST_ASSERT_EQUAL(17, frames_until_they_count(0.0f, 2));
  TEST_ASSERT_FALSE(show(0.0f, 0.0f, 2, 20));
}

/* Twice as many as were needed. Errors that stay at -5 mrad are no jump; one back to it, with others between, is. */
static void test_however_long_it_jumped_as_many_good_frames_count_again(void) {
  for (int i = 0; i < 100; ++i) {
    (void)show(0.0f, i % 2 == 0 ? 5e-3f : -5e-3f, 2, 20);
  }
  TEST_ASSERT_EQUAL(JUMPING_HIGHEST_SCORE, picture.score);
  while (picture.score > JUMPING_HIGHEST_SCORE - 1) {
    TEST_ASSERT_TRUE(show(0.0f, -5e-3f, 2, 20));
  }
  TEST_ASSERT_TRUE(show(0.0f, 5e-3f, 2, 20));
  TEST_ASSERT_EQUAL(JUMPING_HIGHEST_SCORE, picture.score);
  TEST_ASSERT_EQUAL(JUMPING_FREE, picture.free); /* of a jump of 10 mrad, ten times too fast */
  TEST_ASSERT_EQUAL(JUMPING_FREE + JUMPING_HIGHEST_SCORE - 1, frames_until_they_count(5e-3f, 2));
}

/* 1 kHz: frames 1 ms apart may be 0.5 mrad apart. Jumps of 1.2 mrad are twice as fast: after the last one 1 frame takes
 * nothing away, and the last of 12 others counts again. */
static void test_frames_of_1_khz_are_a_ms_apart(void) {
  TEST_ASSERT_EQUAL(100, frames_until_it_jumps(0.24e-3f, 1));
  setUp();
  TEST_ASSERT_EQUAL(7, frames_until_it_jumps(0.6e-3f, 1));
  TEST_ASSERT_EQUAL(1 + JUMPING_SCORE - 1, frames_until_they_count(-0.6e-3f, 1));
}

/* 2 mrad further in each frame of 500 Hz: each is as fast as a jump, but none goes back. */
static void test_errors_that_run_away_in_one_direction_do_not_contradict_each_other(void) {
  for (int i = 0; i < 100; ++i) {
    TEST_ASSERT_FALSE(show(2e-3f * (float)i, -2e-3f * (float)i, 2, 20));
  }
}

static void test_a_frame_without_a_target_says_nothing(void) {
  for (int i = 0; i < 100; ++i) {
    const pointing_frame frame = {.fresh = true, .valid = false, .error = {.x = i % 2 == 0 ? 0.01f : -0.01f}};
    TEST_ASSERT_FALSE(jumping_picture_take(&picture, &frame, TICK_S));
  }
}

/* 2 mrad to and fro, 10 times in a second, in a camera of 500 Hz. */
static void test_an_imager_that_hops_between_two_targets_is_none(void) {
  for (int i = 0; i < 1000; ++i) {
    TEST_ASSERT_FALSE(show(i / 25 % 2 == 0 ? 1e-3f : -1e-3f, 0.0f, 2, 20));
  }
}

/* Frames of 100 Hz that come in pairs: by their ages they are 10 ms apart. */
static void test_the_time_between_two_exposures_counts(void) {
  for (int i = 0; i < 100; ++i) {
    const bool late = i % 2 == 0;
    TEST_ASSERT_FALSE(show(late ? 2e-3f : -2e-3f, 0.0f, late ? 19 : 1, late ? 29 : 20));
  }
}

/* Amplitudes are rms: 0.1 mrad at 500 Hz never, 3 mrad soon. */
static void test_noise_counts_by_its_rate(void) {
  random_source chance = {.state = 1};
  for (int i = 0; i < 20000; ++i) {
    TEST_ASSERT_FALSE(show(1e-4f * (float)random_normal(&chance), 0.0f, 2, 20));
  }
  bool jumps = false;
  for (int i = 0; i < 200; ++i) {
    jumps = show(3e-3f * (float)random_normal(&chance), 0.0f, 2, 20) || jumps;
  }
  TEST_ASSERT_TRUE(jumps);
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_jumps_to_and_fro_are_found_after_7_frames);
  RUN_TEST(test_errors_that_stay_for_some_frames_and_jump_far_are_found);
  RUN_TEST(test_as_many_good_frames_count_again);
  RUN_TEST(test_however_long_it_jumped_as_many_good_frames_count_again);
  RUN_TEST(test_frames_of_1_khz_are_a_ms_apart);
  RUN_TEST(test_errors_that_run_away_in_one_direction_do_not_contradict_each_other);
  RUN_TEST(test_a_frame_without_a_target_says_nothing);
  RUN_TEST(test_an_imager_that_hops_between_two_targets_is_none);
  RUN_TEST(test_the_time_between_two_exposures_counts);
  RUN_TEST(test_noise_counts_by_its_rate);
  return UNITY_END();
}
