/* SPDX-License-Identifier: Apache-2.0 */
/* Which frames have nothing to do with those around them, at 50 Hz. */
#include "servo/stray_frame.h"

#include <string.h>

#include "support/random.h"
#include "unity.h"

enum { FRAME_MS = 20 };

static stray_frames frames;

/* The axes have followed the target for a second, with residuals of 10 urad. */
static void follow(void) {
  memset(&frames, 0, sizeof frames);
  for (int ms = 1; ms <= 1000; ++ms) {
    stray_frames_pass_ms(&frames);
    if (ms % FRAME_MS == 0) {
      TEST_ASSERT_FALSE(stray_frames_take(&frames, (image_vector){.x = 1e-5f}));
    }
    stray_frames_settle(&frames, true);
  }
}

void setUp(void) { follow(); }
void tearDown(void) {}

static bool show(float x_rad, float y_rad) {
  for (int ms = 0; ms < FRAME_MS; ++ms) {
    stray_frames_pass_ms(&frames);
  }
  return stray_frames_take(&frames, (image_vector){.x = x_rad, .y = y_rad});
}

static void test_a_frame_that_is_far_off_does_not_count(void) {
  TEST_ASSERT_TRUE(show(30e-3f, 0.0f));
  TEST_ASSERT_FALSE(show(1e-5f, 0.0f));
  TEST_ASSERT_TRUE(show(0.0f, -4e-4f));
  TEST_ASSERT_FALSE(show(0.0f, 2.5e-4f)); /* below STRAY_RAD */
}

/* The time since the last frame that counted goes on. */
static void test_the_next_frame_counts_as_one_after_a_longer_time(void) {
  TEST_ASSERT_TRUE(show(30e-3f, 0.0f));
  TEST_ASSERT_EQUAL(FRAME_MS, frames.ms);
  TEST_ASSERT_FALSE(show(1e-5f, 0.0f));
  TEST_ASSERT_EQUAL(0, frames.ms);
}

static void test_a_target_that_has_jumped_counts_from_the_second_frame(void) {
  TEST_ASSERT_TRUE(show(5e-3f, -5e-3f));
  TEST_ASSERT_FALSE(show(5e-3f, -5e-3f));
  TEST_ASSERT_FALSE(show(4e-3f, -4e-3f));
}

/* Along either axis. */
static void test_two_strays_on_different_sides_do_not_confirm_each_other(void) {
  const image_vector seconds[] = {{-5e-3f, 0.0f}, {0.0f, 5e-3f}, {2e-3f, 5e-3f}}; /* the last: less than half as far */
  for (unsigned i = 0; i < 6; ++i) {
    const image_vector second = seconds[i / 2];
    const bool vertical = i % 2 == 1;
    follow();
    TEST_ASSERT_TRUE(vertical ? show(0.0f, 5e-3f) : show(5e-3f, 0.0f));
    TEST_ASSERT_TRUE(vertical ? show(second.y, second.x) : show(second.x, second.y));
    TEST_ASSERT_FALSE(show(1e-5f, 0.0f));
  }
}

/* At 50 Hz the third frame in a row is later than 50 ms, at 10 Hz each one is. */
static void test_no_frame_is_dropped_that_is_late(void) {
  TEST_ASSERT_TRUE(show(5e-3f, 0.0f));
  TEST_ASSERT_TRUE(show(-5e-3f, 0.0f));
  TEST_ASSERT_FALSE(show(5e-3f, 0.0f));
  follow();
  for (int ms = FRAME_MS; ms < 100; ++ms) {
    stray_frames_pass_ms(&frames);
  }
  TEST_ASSERT_FALSE(show(30e-3f, 0.0f));
}

/* +-0.5 mrad from frame to frame at 500 Hz, after residuals of 10 urad. */
static void test_errors_that_alternate_soon_count(void) {
  int dropped = 0;
  for (int frame = 0; frame < 500; ++frame) {
    stray_frames_pass_ms(&frames);
    stray_frames_pass_ms(&frames);
    dropped += stray_frames_take(&frames, (image_vector){.x = frame % 2 == 0 ? 5e-4f : -5e-4f}) ? 1 : 0;
  }
  TEST_ASSERT_TRUE(dropped >= 1 && dropped <= 12);
}

/* Residuals of 1 mrad are usual: then 7 mrad are none to drop, 10 mrad are. */
static void test_what_is_usual_is_no_stray(void) {
  for (int i = 0; i < 50; ++i) {
    (void)show(i % 2 == 0 ? 2.5e-4f : -2.5e-4f, 0.0f);
  }
  for (int i = 0; i < 100; ++i) {
    TEST_ASSERT_FALSE(show(i % 2 == 0 ? 1e-3f : -1e-3f, 0.0f));
  }
  TEST_ASSERT_FALSE(show(7e-3f, 0.0f));
  follow();
  for (int i = 0; i < 100; ++i) {
    (void)show(i % 2 == 0 ? 1e-3f : -1e-3f, 0.0f);
  }
  TEST_ASSERT_TRUE(show(10e-3f, 0.0f));
}

static void test_until_the_target_has_been_followed_for_half_a_second_every_frame_counts(void) {
  stray_frames_settle(&frames, false);
  for (int ms = 0; ms < STRAY_SETTLED_MS - 1; ++ms) {
    stray_frames_settle(&frames, true);
  }
  TEST_ASSERT_FALSE(show(30e-3f, 0.0f));
  follow();
  stray_frames_settle(&frames, false);
  for (int ms = 0; ms < STRAY_SETTLED_MS; ++ms) {
    stray_frames_settle(&frames, true);
  }
  TEST_ASSERT_TRUE(show(30e-3f, 0.0f));
}

/* White noise, 100 urad rms: in an hour of frames fewer than one of 10,000. */
static void test_noise_is_hardly_ever_dropped(void) {
  random_source chance = {.state = 1};
  for (int i = 0; i < 100; ++i) {
    (void)show(1e-4f * (float)random_normal(&chance), 1e-4f * (float)random_normal(&chance));
  }
  int dropped = 0;
  for (int i = 0; i < 180000; ++i) {
    dropped += show(1e-4f * (float)random_normal(&chance), 1e-4f * (float)random_normal(&chance)) ? 1 : 0;
  }
  TEST_ASSERT_TRUE(dropped < 18);
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_a_frame_that_is_far_off_does_not_count);
  RUN_TEST(test_the_next_frame_counts_as_one_after_a_longer_time);
  RUN_TEST(test_a_target_that_has_jumped_counts_from_the_second_frame);
  RUN_TEST(test_two_strays_on_different_sides_do_not_confirm_each_other);
  RUN_TEST(test_no_frame_is_dropped_that_is_late);
  RUN_TEST(test_errors_that_alternate_soon_count);
  RUN_TEST(test_what_is_usual_is_no_stray);
  RUN_TEST(test_until_the_target_has_been_followed_for_half_a_second_every_frame_counts);
  RUN_TEST(test_noise_is_hardly_ever_dropped);
  return UNITY_END();
}
