/* A picture that is sent again as if it were new: its place stays, and the line of sight runs after it faster and
 * faster. */
#include "servo/frozen_picture.h"

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

static bool give(int16_t x, double azimuth_rad, double pitch_rad, unsigned tick) {
  const camera_message message = {.x = x, .y = -1, .quality = 80, .counter = (uint8_t)(tick / FRAME_TICKS)};
  const joint_place joints = {.azimuth = turn32(azimuth_rad), .pitch = turn32(pitch_rad)};
  const bool shown = frozen_picture_shows(&picture, &message);
  if (!shown) {
    frozen_picture_take(&picture, &message, count_rad * (float)x, count_rad, joints, tick);
  }
  return shown;
}

/* Two seconds; the azimuth turns with this rate and acceleration. Returns the tick from which on pictures were frozen;
 * 0: none was. */
static unsigned show(int16_t x, double rate_rad_s, double acceleration_rad_s2, double pitch_rad) {
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
  TEST_ASSERT_EQUAL(540, show(OFF_COUNTS / 4, 0.0, 0.1, 1.3962634));
}

/* One within a count is the same place: an image processor that rounds to and fro. */
static void test_another_place_ends_it(void) {
  for (int off = -2; off <= 2; ++off) {
    setUp();
    TEST_ASSERT_NOT_EQUAL(0, show(OFF_COUNTS, 0.0, 0.1, 0.0));
    TEST_ASSERT_TRUE(give(OFF_COUNTS, 0.2, 0.0, 2000));
    TEST_ASSERT_EQUAL(off >= -1 && off <= 1, give((int16_t)(OFF_COUNTS + off), 0.2, 0.0, 2020));
  }
}

static void test_a_place_that_jitters_by_a_count_is_frozen_too(void) {
  unsigned frozen_at = 0;
  for (unsigned tick = 0; tick < 2000 && frozen_at == 0; tick += FRAME_TICKS) {
    const int jitter = tick / FRAME_TICKS % 3 == 2 ? 1 - 2 * (int)(tick / FRAME_TICKS % 2) : 0;
    if (give((int16_t)(OFF_COUNTS + jitter), 0.5 * 0.1 * 1e-6 * tick * tick, 0.0, tick)) {
      frozen_at = tick;
    }
  }
  TEST_ASSERT_EQUAL(540, frozen_at);
}

static void give_none(unsigned tick) {
  const camera_message none = {.quality = CAMERA_NO_TARGET};
  frozen_picture_take(&picture, &none, 0.0f, count_rad, (joint_place){0}, tick);
}

/* Every fourth picture shows no target. */
static void test_pictures_without_a_target_do_not_end_it(void) {
  unsigned frozen_at = 0;
  for (unsigned tick = 0; tick < 2000 && frozen_at == 0; tick += FRAME_TICKS) {
    if (tick / FRAME_TICKS % 4 == 3) {
      give_none(tick);
    } else if (give(OFF_COUNTS, 0.5 * 0.1 * 1e-6 * tick * tick, 0.0, tick)) {
      frozen_at = tick;
    }
  }
  TEST_ASSERT_EQUAL(560, frozen_at); /* 540 shows none */
  give_none(600);
  TEST_ASSERT_TRUE(give(OFF_COUNTS, 0.5, 0.0, 620));
}

/* A target in the same place after a second without one: the axes have moved at a constant rate. */
static void test_a_long_time_without_a_target_is_no_window(void) {
  for (unsigned tick = 0; tick < 3000; tick += FRAME_TICKS) {
    if (tick >= 400 && tick < 1400) {
      give_none(tick);
    } else {
      TEST_ASSERT_FALSE(give(OFF_COUNTS, 1.0e-3 * tick, 0.0, tick));
    }
  }
}

/* A coarse camera shows a target that is followed well in the same one or two counts, also while it turns. */
static void test_a_coarse_camera_shows_a_target_at_the_centre_without_a_change(void) {
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
  RUN_TEST(test_a_place_that_jitters_by_a_count_is_frozen_too);
  RUN_TEST(test_pictures_without_a_target_do_not_end_it);
  RUN_TEST(test_a_long_time_without_a_target_is_no_window);
  RUN_TEST(test_a_coarse_camera_shows_a_target_at_the_centre_without_a_change);
  return UNITY_END();
}
