/* SPDX-License-Identifier: Apache-2.0 */
/* A picture that is sent again as if it were new: its place stays, and the line of sight runs after it faster and
 * faster. */
#include "servo/frozen_picture.h"

#include <math.h>

#include "support/check.h"
#include "unity.h"

enum { FRAME_TICKS = 20 };
#define COUNT_RAD 1e-6f
#define OFF_COUNTS 2000

static frozen_picture picture;
static float count_rad;

void setUp(void) {
  picture = (frozen_picture){0};
  count_rad = COUNT_RAD;
}
void tearDown(void) {}

static angle_turn32 turn32(double angle_rad) {
  return (angle_turn32)(int64_t)(angle_rad / 6.283185307179586 * 4294967296.0);
}

static bool give_both(double x, double y, double azimuth_rad, double pitch_rad, unsigned tick) {
  const image_vector error = {.x = count_rad * (float)x, .y = count_rad * (float)y};
  const joint_place joints = {.azimuth = turn32(azimuth_rad), .pitch = turn32(pitch_rad)};
  const bool shown = frozen_picture_shows(&picture, error);
  if (!shown) {
    frozen_picture_take(&picture, error, count_rad, joints, tick);
  }
  return shown;
}

static bool give(double x, double azimuth_rad, double pitch_rad, unsigned tick) {
  return give_both(x, -1.0, azimuth_rad, pitch_rad, tick);
}

/* Two seconds; the azimuth turns with this rate and acceleration. Returns the tick from which on pictures were frozen;
 * 0: none was. */
static unsigned show(double x, double rate_rad_s, double acceleration_rad_s2, double pitch_rad) {
  for (unsigned tick = 0; tick < 2000; tick += FRAME_TICKS) {
    const double time_s = 1e-3 * tick;
    if (give(x, (rate_rad_s + 0.5 * acceleration_rad_s2 * time_s) * time_s, pitch_rad, tick)) {
      return tick;
    }
  }
  return 0;
}

/* 0.1 rad/s2: in each window 6.8 mrad (260 ms: 13 pictures) more than in the one before. 2 * 2 mrad are enough. */
static void test_a_place_that_stays_while_the_sight_runs_faster_and_faster_is_frozen(void) {
  TEST_ASSERT_EQUAL(540, show(OFF_COUNTS, 0.0, 0.1, 0.0));
  setUp();
  TEST_ASSERT_EQUAL(540, show(OFF_COUNTS, -0.3, 0.1, 0.0)); /* slower and slower, too */
}

static void test_a_lag_at_a_constant_rate_is_a_target_that_is_followed(void) {
  TEST_ASSERT_EQUAL(0, show(OFF_COUNTS, 1.0, 0.0, 0.0));
}

/* At 80 deg of pitch the azimuth moves the line of sight by 0.17 of its own motion: 1.2 mrad. */
static void test_the_motion_of_the_line_of_sight_counts(void) {
  TEST_ASSERT_EQUAL(0, show(OFF_COUNTS, 0.0, 0.1, 1.3962634));
  setUp();
  TEST_ASSERT_EQUAL(540, show(OFF_COUNTS / 4, 0.0, 0.1, 1.3962634));
}

/* One within a sixteenth of what it is off is the same place. */
static void test_another_place_ends_it(void) {
  for (int off = -130; off <= 130; off += 10) { /* 2000 / 16 = 125 */
    setUp();
    TEST_ASSERT_NOT_EQUAL(0, show(OFF_COUNTS, 0.0, 0.1, 0.0));
    TEST_ASSERT_TRUE(give(OFF_COUNTS, 0.2, 0.0, 2000));
    TEST_ASSERT_EQUAL(off >= -125 && off <= 125, give(OFF_COUNTS + off, 0.2, 0.0, 2020));
  }
}

/* An image processor that rounds to and fro, a spot on the sensor in its noise. */
static void test_a_place_that_jitters_is_frozen_too(void) {
  const struct {
    int off;
    int jitter;
    bool frozen;
  } rows[] = {{15, 1, true}, {15, 6, false}, {OFF_COUNTS, 62, true}, {OFF_COUNTS, 200, false}};
  for (unsigned row = 0; row < 4; ++row) {
    setUp();
    unsigned frozen_at = 0;
    for (unsigned tick = 0; tick < 2000 && frozen_at == 0; tick += FRAME_TICKS) {
      const double jitter = rows[row].jitter * (1.0 - tick / FRAME_TICKS % 7 / 3.0);
      if (give(rows[row].off + jitter, 0.5 * 0.1 * 1e-6 * tick * tick, 0.0, tick)) {
        frozen_at = tick;
      }
    }
    TEST_ASSERT_EQUAL_MESSAGE(rows[row].frozen ? 540 : 0, frozen_at, row < 2 ? "near the centre" : "far off");
  }
}

/* The first picture shows the target exactly at the centre, the next one 2 counts off: the same place. The third one, 4
 * counts off, is another place, which stays: two windows of 260 ms from 40 ms on. */
static void test_a_first_picture_at_the_centre_is_a_place_as_well(void) {
  unsigned frozen_at = 0;
  for (unsigned tick = 0; tick < 2000 && frozen_at == 0; tick += FRAME_TICKS) {
    const double off = fmin(2.0 * tick / FRAME_TICKS, 4.0);
    frozen_at = give(off, 0.5 * 0.1 * 1e-6 * tick * tick, 0.0, tick) ? tick : 0;
  }
  TEST_ASSERT_EQUAL(40 + 2 * 260 + FRAME_TICKS, frozen_at);
}

/* The other axis follows a target that moves in the picture. */
static void test_each_axis_is_judged_for_itself(void) {
  for (int axis = 0; axis < 2; ++axis) {
    setUp();
    unsigned frozen_at = 0;
    for (unsigned tick = 0; tick < 2000 && frozen_at == 0; tick += FRAME_TICKS) {
      const double runs_rad = 0.5 * 0.1 * 1e-6 * tick * tick;
      const double moves = 700.0 - 3.0 * tick;
      if (axis == 0 ? give_both(OFF_COUNTS, moves, runs_rad, 0.0, tick)
                    : give_both(moves, OFF_COUNTS, 0.0, runs_rad, tick)) {
        frozen_at = tick;
      }
    }
    TEST_ASSERT_EQUAL(540, frozen_at);
  }
}

/* Every fourth picture shows no target. */
static void test_pictures_without_a_target_do_not_end_it(void) {
  unsigned frozen_at = 0;
  for (unsigned tick = 0; tick < 2000 && frozen_at == 0; tick += FRAME_TICKS) {
    if (tick / FRAME_TICKS % 4 != 3 && give(OFF_COUNTS, 0.5 * 0.1 * 1e-6 * tick * tick, 0.0, tick)) {
      frozen_at = tick;
    }
  }
  TEST_ASSERT_EQUAL(560, frozen_at); /* 540 shows none */
  TEST_ASSERT_TRUE(give(OFF_COUNTS, 0.5, 0.0, 620));
}

/* 240 ms of pictures, 140 ms without one. */
static void test_gaps_do_not_end_it(void) {
  bool frozen = false;
  for (unsigned tick = 0; tick < 3000; tick += FRAME_TICKS) {
    frozen = (tick % 380 < 240 && give(OFF_COUNTS, 0.5 * 0.1 * 1e-6 * tick * tick, 0.0, tick)) || frozen;
  }
  TEST_ASSERT_TRUE(frozen);
}

/* A straight pass at 0.2 rad/s: the motion passes from the pitch to the azimuth, and the lags stay. */
static void test_a_pass_at_a_constant_rate_near_the_zenith_is_a_target(void) {
  double azimuth_rad = 0.0;
  double pitch_rad = 1.0;
  for (unsigned tick = 0; tick < 3000; ++tick) {
    const double turned_rad = 4e-4 * tick;
    const double rate_rad_s = 0.2;
    azimuth_rad += 1e-3 * rate_rad_s * sin(turned_rad) / cos(pitch_rad);
    pitch_rad += 1e-3 * rate_rad_s * cos(turned_rad);
    if (tick % FRAME_TICKS == 0) {
      TEST_ASSERT_FALSE(give_both(1000, 1000, azimuth_rad, pitch_rad, tick));
    }
  }
}

/* A target that passes: the azimuth turns at a constant 0.2 rad/s with a constant lag, and the pitch faster and faster
 * after a target that moves in the picture. In all the motion grows; along the place that stays it does not. */
static void test_motion_across_a_place_that_stays_is_that_of_a_target(void) {
  for (unsigned gap_ms = 0; gap_ms <= 400; gap_ms += 200) { /* which makes the second window longer */
    setUp();
    for (unsigned tick = 0; tick < 1500; tick += FRAME_TICKS) {
      const double time_s = 1e-3 * tick;
      if (tick <= 300 || tick > 300 + gap_ms) {
        TEST_ASSERT_FALSE(give_both(OFF_COUNTS, 700.0 - 3.0 * tick, 0.2 * time_s, 0.2 * time_s * time_s, tick));
      }
    }
  }
}

/* A target in the same place after a second without one: the axes have moved at a constant rate, or at one before and
 * another one after it. */
static void test_a_long_time_without_a_target_is_no_window(void) {
  for (int faster = 0; faster <= 1; ++faster) {
    setUp();
    for (unsigned tick = 0; tick < 3000; tick += FRAME_TICKS) {
      const double rate_rad_ms = tick >= 1600 && faster != 0 ? 1.2e-3 : 1.0e-3;
      if (tick < 400 || tick >= 1600) {
        TEST_ASSERT_FALSE(give(OFF_COUNTS, rate_rad_ms * tick, 0.0, tick));
      }
    }
  }
}

/* Both places have stayed for a while without a picture: the windows of both begin anew with the same picture. At 1 s
 * it is a window, at 1001 ms it is not, and only one of them is judged. */
static void test_a_window_that_lasts_too_long_is_not_judged(void) {
  for (unsigned late = 0; late <= 1; ++late) {
    setUp();
    (void)give_both(OFF_COUNTS, OFF_COUNTS, 0.0, 0.0, 0);
    (void)give_both(OFF_COUNTS, OFF_COUNTS, 0.0, 0.0, 1000 + late);
    TEST_ASSERT_EQUAL(1000 + late, picture.azimuth.since_tick);
    TEST_ASSERT_EQUAL(late == 0 ? 0 : 1001, picture.pitch.since_tick);
    TEST_ASSERT_EQUAL(late == 0, picture.azimuth.has_before);
    TEST_ASSERT_FALSE(picture.pitch.has_before);
  }
}

/* A coarse camera shows a target that is followed well in the same one or two counts, also while it turns. */
static void test_a_coarse_camera_shows_a_target_at_the_centre_without_a_change(void) {
  count_rad = 1e-4f;
  TEST_ASSERT_EQUAL(0, show(1, 0.0, 0.1, 0.0));
  setUp();
  count_rad = 1e-4f;
  TEST_ASSERT_EQUAL(0, show(2, 0.0, 0.1, 0.0));
  TEST_ASSERT_EQUAL(0, show(3, 0.0, 0.03, 0.0)); /* 2 mrad faster: less than 25 counts */
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_a_place_that_stays_while_the_sight_runs_faster_and_faster_is_frozen);
  RUN_TEST(test_a_lag_at_a_constant_rate_is_a_target_that_is_followed);
  RUN_TEST(test_the_motion_of_the_line_of_sight_counts);
  RUN_TEST(test_another_place_ends_it);
  RUN_TEST(test_a_place_that_jitters_is_frozen_too);
  RUN_TEST(test_a_first_picture_at_the_centre_is_a_place_as_well);
  RUN_TEST(test_each_axis_is_judged_for_itself);
  RUN_TEST(test_gaps_do_not_end_it);
  RUN_TEST(test_a_pass_at_a_constant_rate_near_the_zenith_is_a_target);
  RUN_TEST(test_motion_across_a_place_that_stays_is_that_of_a_target);
  RUN_TEST(test_pictures_without_a_target_do_not_end_it);
  RUN_TEST(test_a_long_time_without_a_target_is_no_window);
  RUN_TEST(test_a_window_that_lasts_too_long_is_not_judged);
  RUN_TEST(test_a_coarse_camera_shows_a_target_at_the_centre_without_a_change);
  return UNITY_END();
}
