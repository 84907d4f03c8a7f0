/* SPDX-License-Identifier: Apache-2.0 */
/* The camera's delay in the servo: the line of sight shakes as the pointing tracker measures it, the target stands, and
 * the sender states a wrong age. */
#include "servo/camera_delay.h"

#include <string.h>

#include "support/check.h"
#include "support/random.h"

enum { RING = 256, TRUE_AGE_MS = 28 };

static const float kTick_s = 1e-3f;

static camera_delay delay;
static camera_delay_params params;
static pointing_tracker_state tracker;

static const pointing_tracker_params kTracker = {
    .proportional_per_s = 20.0f, .estimator_rad_s = 4.0f, .coast_s = 1.0f, .rate_limit_rad_s = {1.0f, 1.0f}};

static struct {
  random_source random;
  double los_rad[2][RING];
  double inner[2];
  double rate_rad_s[2];
  double last_rad_s[2]; /* measured in the tick before */
  unsigned ms;
  int frame_ms; /* one frame every .. */
  int true_age_ms;
  int stated_ms;
  bool found;
} world;

void setUp(void) {
  camera_delay_reset(&delay);
  pointing_tracker_reset(&tracker);
  params = (camera_delay_params){.use = CAMERA_DELAY_REPORTED, .dither_rad = 2e-5f, .dither_hz = 5.0f};
  memset(&world, 0, sizeof world);
  world.random = (random_source){7};
  world.frame_ms = 20;
  world.true_age_ms = TRUE_AGE_MS;
  world.stated_ms = TRUE_AGE_MS;
  world.found = true;
}

void tearDown(void) {}

static void shake(int i) {
  world.last_rad_s[i] = world.rate_rad_s[i];
  world.inner[i] += -0.03 * world.inner[i] + sqrt(0.06) * random_normal(&world.random);
  world.rate_rad_s[i] += 0.03 * (280e-6 * world.inner[i] - world.rate_rad_s[i]);
  world.los_rad[i][(world.ms + 1) % RING] = world.los_rad[i][world.ms % RING] + 1e-3 * world.rate_rad_s[i];
}

/* The tracker gets the rates of the last tick, as in the node. */
static void run_for(int ms, bool tracks) {
  for (int k = 0; k < ms; ++k) {
    pointing_frame frame = {0};
    if (world.ms % (unsigned)world.frame_ms == 0 && world.ms > 130) {
      const unsigned then = (world.ms + RING - (unsigned)world.true_age_ms) % RING;
      frame = (pointing_frame){.fresh = true, .valid = world.found, .age_ticks = world.stated_ms};
      frame.error.x = (float)(-world.los_rad[0][then] + 2.3e-6 * random_normal(&world.random));
      frame.error.y = (float)(-world.los_rad[1][then] + 2.3e-6 * random_normal(&world.random));
    }
    const line_of_sight_rates los = {.rad_s = {(float)world.last_rad_s[0], (float)world.last_rad_s[1]}};
    camera_delay_notice(&delay, &frame);
    frame.age_ticks = camera_delay_age(&delay, &params, frame.age_ticks);
    (void)pointing_tracker_step(&tracker, &kTracker, &frame, &los, (rotation){.sine = 0.0f, .cosine = 1.0f}, kTick_s);
    camera_delay_step(&delay, &params, &tracker, 1e-6f, tracks, kTick_s);
    shake(0);
    shake(1);
    world.ms++;
  }
}

static void test_finds_how_wrong_the_stated_age_is_and_corrects_if_allowed(void) {
  for (int wrong_ms = -10; wrong_ms <= 10; wrong_ms += 10) {
    setUp();
    world.stated_ms = TRUE_AGE_MS - wrong_ms;
    run_for(40000, true);
    TEST_ASSERT_TRUE(delay.found.known);
    CHECK_NEAR("s", 1e-3 * wrong_ms, delay.found.error_s, 1e-3);
    CHECK_AT_MOST("s", 1e-3, delay.found.half_width_s);
    TEST_ASSERT_INT_WITHIN(1, wrong_ms, delay.offset_ticks);
    TEST_ASSERT_EQUAL(20, camera_delay_age(&delay, &params, 20));
    params.use = CAMERA_DELAY_CORRECTED;
    TEST_ASSERT_EQUAL(20 + delay.offset_ticks, camera_delay_age(&delay, &params, 20));
  }
}

/* Whenever it has been computed: by more than a tick and two half intervals it changes, by less it does not. What was
 * more than three ticks off is forgotten. */
static void test_the_believed_error_changes_only_where_it_is_sure(void) {
  static const int wrong_ms[] = {0, 2, -2, 3, -4, 12};
  int small = 0;
  int large = 0;
  for (int i = 0; i < 6; ++i) {
    setUp();
    world.stated_ms = TRUE_AGE_MS - wrong_ms[i];
    for (int ms = 0; ms < 20000; ++ms) {
      const int before = delay.offset_ticks;
      const delay_error found = delay.found;
      run_for(1, true);
      const double off = 1e3 * (double)delay.found.error_s - before;
      const double sure = fmax(1.0, 2e3 * (double)delay.found.half_width_s);
      if (delay.offset_ticks != before) {
        CHECK_AT_LEAST("off, ticks", sure - 1e-3, fabs(off));
        CHECK_NEAR("changed, ticks", 1.25 * off, delay.offset_ticks - before, 0.51);
        TEST_ASSERT_EQUAL(fabs(off) > 3.0, delay.estimator.weight == 0.0f);
        small += fabs(off) <= 3.0 ? 1 : 0;
        large += fabs(off) > 3.0 ? 1 : 0;
      } else if (delay.found.error_s != found.error_s && delay.found.known && delay.found.half_width_s <= 4e-3f) {
        CHECK_AT_MOST("off, ticks", sure + 1e-3, fabs(off));
      }
    }
  }
  TEST_ASSERT_TRUE(small > 0 && large > 0);
}

static void test_a_corrected_age_stays_within_the_history(void) {
  params.use = CAMERA_DELAY_CORRECTED;
  delay.offset_ticks = -30;
  TEST_ASSERT_EQUAL(0, camera_delay_age(&delay, &params, 20));
  delay.offset_ticks = 30;
  TEST_ASSERT_EQUAL(TARGET_TRACKER_HISTORY - 1, camera_delay_age(&delay, &params, 120));
}

static void test_an_age_that_is_ignored_is_forgotten(void) {
  run_for(20000, true);
  TEST_ASSERT_TRUE(delay.found.known);
  params.use = CAMERA_DELAY_IGNORED;
  run_for(1, true);
  TEST_ASSERT_FALSE(delay.found.known);
  TEST_ASSERT_EQUAL(0, delay.offset_ticks);
}

/* What was found is kept; nothing is added while the axes do not track. */
static void test_a_pause_of_tracking_keeps_what_was_found(void) {
  run_for(20000, true);
  const delay_error before = delay.found;
  run_for(3000, false);
  TEST_ASSERT_EQUAL_FLOAT(before.error_s, delay.found.error_s);
  run_for(1000, true); /* not settled yet */
  TEST_ASSERT_EQUAL_FLOAT(before.half_width_s, delay.found.half_width_s);
  run_for(20000, true);
  CHECK_AT_MOST("s", 0.9 * (double)before.half_width_s, delay.found.half_width_s);
  CHECK_NEAR("s", 0.0, delay.found.error_s, 1e-3);
}

static void test_frames_without_a_target_change_nothing(void) {
  world.found = false;
  run_for(20000, true);
  TEST_ASSERT_FALSE(delay.found.known);
}

/* 10 Hz to 500 Hz; beyond the limit of a delay the age is not believed. */
static void test_any_rate_of_frames(void) {
  const int frame_ms[] = {2, 3, 8, 100};
  for (int i = 0; i < 4; ++i) {
    setUp();
    world.frame_ms = frame_ms[i];
    world.stated_ms = TRUE_AGE_MS - 4;
    run_for(60000, true);
    TEST_ASSERT_TRUE(delay.found.known);
    CHECK_NEAR("s", 4e-3, delay.found.error_s, 2.0f * delay.found.half_width_s);
    CHECK_AT_MOST("s", 3e-3, delay.found.half_width_s);
  }
}

static void test_frames_that_are_rare_change_nothing(void) {
  world.frame_ms = 250;
  run_for(60000, true);
  TEST_ASSERT_FALSE(delay.found.known);
}

/* Nobody knows what the line of sight has moved since a frame of 200 ms ago: the predictors begin anew. */
static void test_a_gap_between_the_frames_begins_the_predictors_anew(void) {
  run_for(10000, true);
  CHECK_AT_LEAST("s", 9.0, delay.estimator.running_s);
  const float weight = delay.estimator.weight;
  world.frame_ms = 100000;
  run_for(200, true);
  world.frame_ms = 20;
  run_for(22, true);
  CHECK_AT_MOST("s", 0.03, delay.estimator.running_s);
  CHECK_NEAR("frames so far", (double)weight, delay.estimator.weight, 1.0);
}

/* Frames in this ms of tracking, and 20 ms later. */
static void show_two_frames_from(int tracked_ms) {
  world.frame_ms = 100000;
  run_for(tracked_ms - 1, true);
  for (int i = 0; i < 2; ++i) {
    world.frame_ms = 1;
    run_for(1, true);
    world.frame_ms = 100000;
    run_for(19, true);
  }
}

/* The motion is known up to the oldest exposure after 128 ms of tracking: frames up to then do not count. What the line
 * of sight has moved up to the first one that counts is not known; from there to the second one it is 20 ms. */
static void test_after_a_pause_the_motion_must_be_known_for_as_long_as_it_is_remembered(void) {
  static const struct {
    int first_ms;
    double running_s;
  } rows[] = {{64, 0.0}, {TARGET_TRACKER_HISTORY, 0.0}, {TARGET_TRACKER_HISTORY + 1, 0.02}, {150, 0.02}};
  for (unsigned i = 0; i < sizeof rows / sizeof *rows; ++i) {
    setUp();
    run_for(1000, true);
    CHECK_AT_LEAST("s", 0.5, delay.estimator.running_s);
    run_for(1, false);
    show_two_frames_from(rows[i].first_ms);
    CHECK_NEAR("s", rows[i].running_s, delay.estimator.running_s, 1e-6);
  }
}

/* The line of sight stands, but for 60 urad in the ms that begins `moves_ms` after the exposure. */
static delay_sample sample_of_one_move(int age_ms, int moves_ms) {
  enum { EXPOSED_MS = 300 };
  setUp();
  for (int ms = 0; ms <= EXPOSED_MS + age_ms; ++ms) {
    pointing_frame frame = {0};
    if (ms == EXPOSED_MS + age_ms) {
      frame = (pointing_frame){.fresh = true, .valid = true, .age_ticks = age_ms};
    }
    const line_of_sight_rates los = {.rad_s = {ms - 2 == EXPOSED_MS + moves_ms ? 0.06f : 0.0f, 0.0f}};
    camera_delay_notice(&delay, &frame);
    (void)pointing_tracker_step(&tracker, &kTracker, &frame, &los, (rotation){.sine = 0.0f, .cosine = 1.0f}, kTick_s);
    camera_delay_step(&delay, &params, &tracker, 1e-6f, true, kTick_s);
  }
  return delay.sample;
}

/* The mean from 3 ms before the instant that is taken for the exposure to 3 ms after it. */
static void test_the_rate_at_the_exposure_is_that_of_6_ms(void) {
  static const int ages_ms[] = {0, 28, TARGET_TRACKER_HISTORY - 1};
  static const int earlier_ms[] = {4, 0, -2}; /* where the history ends */
  for (int i = 0; i < 3; ++i) {
    for (int moves_ms = -12; moves_ms < 12 && moves_ms <= ages_ms[i] - 2; ++moves_ms) {
      const delay_sample sample = sample_of_one_move(ages_ms[i], moves_ms);
      const int from_there_ms = moves_ms + earlier_ms[i];
      CHECK_NEAR("s earlier", 1e-3 * earlier_ms[i], sample.assumed_s, 1e-7);
      CHECK_NEAR("rad/s", from_there_ms >= -3 && from_there_ms < 3 ? 0.01 : 0.0, sample.rate_rad_s.x, 1e-6);
    }
  }
}

/* At both ends of the history the motion is taken a few ms beside the exposure, and this is taken into account. */
static void test_ages_at_both_ends_of_the_history(void) {
  static const int ages_ms[] = {0, 2, 5, 120, TARGET_TRACKER_HISTORY - 1};
  for (int i = 0; i < 5; ++i) {
    setUp();
    world.true_age_ms = ages_ms[i];
    world.stated_ms = ages_ms[i];
    run_for(40000, true);
    TEST_ASSERT_TRUE(delay.found.known);
    CHECK_NEAR("s", 0.0, delay.found.error_s, 1e-3);
    CHECK_AT_MOST("s", 1e-3, delay.found.half_width_s);
  }
}

static void test_no_more_than_50_ms_are_corrected(void) {
  static const int true_ms[] = {90, 30};
  for (int i = 0; i < 2; ++i) {
    setUp();
    world.true_age_ms = true_ms[i];
    world.stated_ms = true_ms[1 - i];
    for (int ms = 0; ms < 60000; ++ms) {
      const int before = delay.offset_ticks;
      run_for(1, true);
      if (delay.offset_ticks != before) {
        CHECK_AT_MOST("half the interval of what is corrected, s", 4e-3, delay.found.half_width_s);
      }
    }
    TEST_ASSERT_EQUAL_INT(i == 0 ? CAMERA_DELAY_MOST_TICKS : -CAMERA_DELAY_MOST_TICKS, delay.offset_ticks);
  }
}

static void test_the_dither_is_a_sine_of_the_elevation(void) {
  double angle_rad = 0.0;
  double lowest_rad = 0.0;
  double highest_rad = 0.0;
  for (int ms = 0; ms < 1000; ++ms) {
    angle_rad += 1e-3 * (double)camera_delay_dither(&delay, &params, true, kTick_s);
    lowest_rad = fmin(lowest_rad, angle_rad);
    highest_rad = fmax(highest_rad, angle_rad);
  }
  CHECK_NEAR("rad, back after whole periods", 0.0, angle_rad, 1e-8);
  CHECK_NEAR("rad", 4e-5, highest_rad - lowest_rad, 1e-7);
  TEST_ASSERT_EQUAL_FLOAT(0.0f, camera_delay_dither(&delay, &params, false, kTick_s));
  TEST_ASSERT_EQUAL_UINT32(0, delay.dither_phase);
}

static float largest_rate_of_first_dither(int ms, bool tracks) {
  float largest_rad_s = 0.0f;
  for (int k = 0; k < ms; ++k) {
    run_for(1, tracks);
    largest_rad_s = fmaxf(largest_rad_s, camera_delay_dither(&delay, &params, false, kTick_s));
  }
  return largest_rad_s;
}

static void test_the_first_dither_runs_until_the_delay_is_known(void) {
  params.first_dither_rad = 2e-6f;
  TEST_ASSERT_EQUAL_FLOAT(0.0f, largest_rate_of_first_dither(1000, false));
  CHECK_NEAR("rad/s", 2e-6 * 2.0 * 3.14159265 * 5.0, largest_rate_of_first_dither(1000, true), 1e-7);
  TEST_ASSERT_EQUAL_FLOAT(0.0f, largest_rate_of_first_dither(1000, false));
  run_for(90000, true);
  CHECK_AT_MOST("s", CAMERA_DELAY_WELL_KNOWN_S, delay.found.half_width_s);
  TEST_ASSERT_EQUAL_FLOAT(0.0f, largest_rate_of_first_dither(1000, true));
  params.use = CAMERA_DELAY_IGNORED;
  TEST_ASSERT_EQUAL_FLOAT(0.0f, largest_rate_of_first_dither(1000, true));
}

static void test_the_first_dither_ends_without_a_result_as_well(void) {
  params.first_dither_rad = 2e-6f;
  world.found = false;
  CHECK_AT_LEAST("rad/s", 1e-5, largest_rate_of_first_dither(29000, true));
  (void)largest_rate_of_first_dither(1500, true);
  TEST_ASSERT_EQUAL_FLOAT(0.0f, largest_rate_of_first_dither(10000, true));
}

/* In quarters of a second, which add up without rounding. */
static void test_the_first_dither_lasts_30_s_in_all(void) {
  params.first_dither_rad = 2e-6f;
  world.found = false;
  run_for(200, true);
  for (int i = 0; i < 130; ++i) {
    (void)camera_delay_dither(&delay, &params, false, 0.25f);
  }
  CHECK_SAME("s", 30.0, delay.first_dither_s);
}

static void test_without_an_amplitude_there_is_no_first_dither(void) {
  TEST_ASSERT_EQUAL_FLOAT(0.0f, largest_rate_of_first_dither(1000, true));
  TEST_ASSERT_EQUAL_FLOAT(0.0f, delay.first_dither_s);
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_finds_how_wrong_the_stated_age_is_and_corrects_if_allowed);
  RUN_TEST(test_the_believed_error_changes_only_where_it_is_sure);
  RUN_TEST(test_a_corrected_age_stays_within_the_history);
  RUN_TEST(test_an_age_that_is_ignored_is_forgotten);
  RUN_TEST(test_a_pause_of_tracking_keeps_what_was_found);
  RUN_TEST(test_frames_without_a_target_change_nothing);
  RUN_TEST(test_any_rate_of_frames);
  RUN_TEST(test_frames_that_are_rare_change_nothing);
  RUN_TEST(test_a_gap_between_the_frames_begins_the_predictors_anew);
  RUN_TEST(test_after_a_pause_the_motion_must_be_known_for_as_long_as_it_is_remembered);
  RUN_TEST(test_the_rate_at_the_exposure_is_that_of_6_ms);
  RUN_TEST(test_ages_at_both_ends_of_the_history);
  RUN_TEST(test_no_more_than_50_ms_are_corrected);
  RUN_TEST(test_the_dither_is_a_sine_of_the_elevation);
  RUN_TEST(test_the_first_dither_runs_until_the_delay_is_known);
  RUN_TEST(test_the_first_dither_ends_without_a_result_as_well);
  RUN_TEST(test_the_first_dither_lasts_30_s_in_all);
  RUN_TEST(test_without_an_amplitude_there_is_no_first_dither);
  return UNITY_END();
}
