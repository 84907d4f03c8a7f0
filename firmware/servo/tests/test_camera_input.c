/* SPDX-License-Identifier: Apache-2.0 */
/* Camera frames from the bus: which count, how old they are, and what they mean. */
#include "servo/camera_input.h"

#include "support/check.h"
#include "unity.h"

static camera_input input;
static camera_input_params params;
static uint32_t tick;

void setUp(void) {
  camera_input_reset(&input);
  params = (camera_input_params){.scale_rad = 1e-6f, .min_quality = 1};
}

void tearDown(void) {}

/* A message whose time is its age, 20 ms after the one before. */
static pointing_frame give(camera_message message) {
  tick += 20;
  return camera_input_take(&input, &params, &message, camera_input_error(&input, &params, &message), message.time,
                           tick);
}

static pointing_frame give_counter(uint8_t counter) {
  return give((camera_message){.time = 3000, .quality = 100, .counter = counter});
}

static void test_a_frame_has_age_and_errors_in_rad(void) {
  const pointing_frame frame = give((camera_message){.x = -3000, .y = 32766, .time = 3049, .quality = 1, .counter = 7});
  TEST_ASSERT_TRUE(frame.fresh && frame.valid);
  TEST_ASSERT_EQUAL(30, frame.age_ticks);
  CHECK_NEAR("x, rad", -3e-3, frame.error.x, 1e-9);
  CHECK_NEAR("y, rad", 32.766e-3, frame.error.y, 1e-8);
  TEST_ASSERT_EQUAL(1, input.taken);
}

/* Sensor turned by a quarter: what it sees to its right is up. Then the boresight is taken off. */
static void test_roll_and_boresight_are_those_of_the_camera(void) {
  params.mounting = (camera_mounting){.roll_rad = 1.5707963f, .boresight = {.x = 1e-4f, .y = 2e-4f}};
  const pointing_frame frame = give((camera_message){.x = 1000, .quality = 100, .counter = 1});
  CHECK_NEAR("x, rad", -1e-4, frame.error.x, 1e-9);
  CHECK_NEAR("y, rad", 1e-3 - 2e-4, frame.error.y, 1e-9);
  params.mounting.roll_rad = 0.0f; /* in force with the next frame */
  const pointing_frame next = give((camera_message){.x = 1000, .quality = 100, .counter = 2});
  CHECK_NEAR("x, rad", 1e-3 - 1e-4, next.error.x, 1e-9);
  CHECK_NEAR("y, rad", -2e-4, next.error.y, 1e-9);
}

/* x is turned over along the sensor's rows, before the roll. */
static void test_a_mirrored_picture_is_turned_over(void) {
  params.mirrored = 1;
  params.mounting = (camera_mounting){.roll_rad = 1.5707963f, .boresight = {.x = 1e-4f}};
  const pointing_frame frame = give((camera_message){.x = 1000, .y = 300, .quality = 100, .counter = 1});
  CHECK_NEAR("x, rad", -0.3e-3 - 1e-4, frame.error.x, 1e-9);
  CHECK_NEAR("y, rad", -1e-3, frame.error.y, 1e-9);
}

static void test_an_exposure_that_is_later_or_not_known_does_not_count(void) {
  const camera_message message = {.quality = 9, .counter = 1};
  const image_vector centre = {0};
  TEST_ASSERT_FALSE(camera_input_take(&input, &params, &message, centre, -1, 1).fresh);
  TEST_ASSERT_EQUAL(CAMERA_IN_FUTURE, input.last_drop);
  TEST_ASSERT_FALSE(camera_input_take(&input, &params, &message, centre, CAMERA_AGE_AMBIGUOUS, 2).fresh);
  TEST_ASSERT_EQUAL(CAMERA_CLOCK_SET, input.last_drop);
  TEST_ASSERT_TRUE(camera_input_take(&input, &params, &message, centre, 0, 3).fresh);
}

/* 1 mrad per count would make five turns of the farthest place. */
static void test_a_target_beyond_half_a_turn_does_not_count(void) {
  params.scale_rad = 1e-3f;
  TEST_ASSERT_TRUE(give((camera_message){.x = 3141, .time = 3000, .quality = 100, .counter = 1}).valid);
  TEST_ASSERT_FALSE(give((camera_message){.x = -3142, .time = 3000, .quality = 100, .counter = 2}).fresh);
  TEST_ASSERT_EQUAL(CAMERA_BEYOND, input.last_drop);
  TEST_ASSERT_FALSE(give((camera_message){.y = 3142, .time = 3000, .quality = 100, .counter = 3}).fresh);
  TEST_ASSERT_FALSE(give((camera_message){.x = 2300, .y = 2300, .time = 3000, .quality = 100, .counter = 4}).fresh);
  TEST_ASSERT_EQUAL(3, input.dropped);
  TEST_ASSERT_TRUE(give((camera_message){.x = -3142, .time = 3000, .quality = 0, .counter = 5}).fresh); /* not found */
  TEST_ASSERT_EQUAL(2, input.taken);
}

/* A camera whose numbers end there sees its target somewhere beyond. */
static void test_an_error_at_the_end_of_its_numbers_does_not_count(void) {
  static const struct {
    int16_t x, y;
    bool counts;
  } cases[] = {{32766, -32766, true}, {32767, 0, false}, {-32767, 0, false}, {0, 32767, false}, {0, INT16_MIN, false}};
  for (unsigned i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
    const camera_message message = {.x = cases[i].x, .y = cases[i].y, .quality = 9, .counter = (uint8_t)(i + 1)};
    TEST_ASSERT_EQUAL(cases[i].counts, give(message).fresh);
  }
  TEST_ASSERT_EQUAL(CAMERA_BEYOND, input.last_drop);
}

/* An imager hangs: counters that step back for ever. Its rate is that of 20 ms, then of 4 ms. */
static void test_a_counter_that_runs_backwards_never_counts(void) {
  static const uint8_t steps[] = {1, 2, 7, 8, 9, 100};
  for (unsigned i = 0; i < 2 * sizeof steps; ++i) {
    camera_input_reset(&input);
    for (uint8_t counter = 0; counter < 50; ++counter) {
      TEST_ASSERT_TRUE(give_counter(counter).fresh);
    }
    uint8_t counter = 49;
    for (unsigned n = 0; n < 5000; ++n) {
      counter = (uint8_t)(counter - steps[i / 2]);
      tick -= i % 2 == 0 ? 0 : 16;
      const bool counts = give_counter(counter).fresh;
      TEST_ASSERT_FALSE_MESSAGE(counts && n >= CAMERA_RESTART, "backwards");
    }
  }
}

/* Counters that are far ahead for the time that has passed, each behind the one before; then the next frame. After
 * three it is one of a sender whose frames overtake each other, after four one that runs backwards. */
static void test_four_messages_in_a_row_run_backwards(void) {
  for (unsigned behind = 1; behind <= 5; ++behind) {
    camera_input_reset(&input);
    for (uint8_t counter = 0; counter < 50; ++counter) {
      TEST_ASSERT_TRUE(give_counter(counter).fresh);
    }
    for (unsigned n = 0; n < behind; ++n) {
      TEST_ASSERT_FALSE(give_counter((uint8_t)(110 - 10 * n)).fresh);
    }
    TEST_ASSERT_EQUAL(behind < CAMERA_RESTART, give_counter(51).fresh);
    TEST_ASSERT_TRUE(give_counter(52).fresh); /* one that goes on is heard */
  }
}

/* By the event timer of its PDO. After 100 frames the sender begins anew. */
static void test_a_frame_may_be_sent_many_times(void) {
  for (unsigned counter = 0; counter < 200; ++counter) {
    const bool restarts = counter >= 100 && counter < 103;
    TEST_ASSERT_EQUAL(!restarts, give_counter((uint8_t)(counter % 100)).fresh);
    for (unsigned again = 0; again < 10; ++again) {
      TEST_ASSERT_FALSE(give_counter((uint8_t)(counter % 100)).fresh);
    }
  }
}

/* Every 50th frame comes before some that are older, of which the fourth looks like a restart: all that follow count.
 */
static void test_frames_that_overtake_others_make_nobody_deaf(void) {
  for (uint8_t older = 1; older <= 8; ++older) {
    camera_input_reset(&input);
    for (unsigned frame = 0; frame < 1000; ++frame) {
      if (frame % 50 == 20) {
        tick += 20u * older;
        (void)give_counter((uint8_t)(frame + older)); /* newer, or too far ahead for the time that has passed */
      }
      const unsigned into = frame % 50;
      const bool counts = give_counter((uint8_t)frame).fresh;
      TEST_ASSERT_TRUE(counts || (into >= 20 && into <= 20u + older));
    }
  }
}

/* 100 frames of 50 Hz and of every 10th counter, a pause of 3 s, then as before. */
static void test_a_pause_does_not_change_the_rate(void) {
  uint8_t counter = 0;
  for (unsigned frame = 0; frame < 300; ++frame) {
    tick += frame % 100 == 0 ? 3000 : 180; /* of the camera's 50 Hz it sends 5 */
    counter = (uint8_t)(counter + 10);
    TEST_ASSERT_TRUE(give_counter(counter).fresh || frame == 0);
  }
}

static void test_a_frame_older_than_the_history_does_not_count(void) {
  TEST_ASSERT_EQUAL(127, give((camera_message){.time = 12749, .quality = 9, .counter = 1}).age_ticks);
  TEST_ASSERT_FALSE(give((camera_message){.time = 12750, .quality = 9, .counter = 2}).fresh);
  TEST_ASSERT_EQUAL(CAMERA_TOO_OLD, input.last_drop);
  TEST_ASSERT_FALSE(give((camera_message){.time = 65535, .quality = 9, .counter = 2}).fresh);
  TEST_ASSERT_EQUAL(2, input.dropped);
}

static void test_quality_decides_whether_there_is_a_target(void) {
  static const struct {
    uint8_t quality, least;
    bool fresh, valid;
  } cases[] = {{0, 1, true, false},  {1, 1, true, true},     {49, 50, true, false},
               {50, 50, true, true}, {100, 100, true, true}, {101, 1, false, false}};
  for (unsigned i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
    params.min_quality = cases[i].least;
    const pointing_frame frame = give((camera_message){.quality = cases[i].quality, .counter = (uint8_t)(i + 1)});
    TEST_ASSERT_EQUAL(cases[i].fresh, frame.fresh);
    TEST_ASSERT_EQUAL(cases[i].valid, frame.valid);
  }
  TEST_ASSERT_EQUAL(CAMERA_BAD_QUALITY, input.last_drop);
}

static void test_a_frame_counts_once_and_in_order_and_skipped_ones_are_counted(void) {
  static const struct {
    uint8_t counter;
    bool counts;
    unsigned missed;
  } cases[] = {{200, true, 0},  {200, false, 0}, {201, true, 0},   {199, false, 0},  {205, true, 3},
               {255, true, 52}, {0, true, 52},   {127, true, 178}, {255, false, 178}};
  for (unsigned i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
    tick += 30000; /* enough for any of them */
    TEST_ASSERT_EQUAL(cases[i].counts, give_counter(cases[i].counter).fresh);
    TEST_ASSERT_EQUAL(cases[i].missed, input.missed);
  }
  TEST_ASSERT_EQUAL(CAMERA_NOT_NEWER, input.last_drop);
}

/* Every 20 ms for 1 s; then a frame comes after some time. Four may be lost without: frames come late. */
static void test_frames_that_were_lost_take_time(void) {
  static const struct {
    uint8_t ahead;
    unsigned ticks;
    bool counts;
  } cases[] = {{1, 1, true},  {4, 1, true},    {5, 19, false},    {5, 20, true},   {8, 77, false},
               {8, 78, true}, {57, 20, false}, {57, 1027, false}, {57, 1028, true}};
  for (unsigned i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
    camera_input_reset(&input);
    for (uint8_t counter = 0; counter < 50; ++counter) {
      TEST_ASSERT_TRUE(give_counter(counter).fresh);
    }
    tick += cases[i].ticks - 20;
    TEST_ASSERT_EQUAL(cases[i].counts, give_counter((uint8_t)(49 + cases[i].ahead)).fresh);
  }
}

/* From 50 Hz to 10 Hz and back, five of six frames lost: it is heard at once, or as one that begins anew. */
static void test_a_sender_may_change_its_rate(void) {
  uint8_t counter = 0;
  for (int i = 0; i < 60; ++i) {
    const unsigned interval_ticks = i / 20 == 1 ? 100 : 20;
    tick += 6 * interval_ticks - 20;
    counter = (uint8_t)(counter + 6);
    const bool fresh = give_counter(counter).fresh;
    TEST_ASSERT_TRUE(fresh || (i >= 40 && i < 40 + CAMERA_RESTART - 1));
  }
}

/* Counters after 100 has counted; which of them count. Steps of 1 to 8 make a restart, also past 255. */
static void test_a_sender_that_began_anew_is_heard_from_its_fourth_advancing_counter(void) {
  static const struct {
    uint8_t counter[6];
    unsigned counts; /* bit i: counter i counts */
  } cases[] = {{{0, 1, 2, 3, 4, 5}, 0x38},       {{10, 18, 26, 34, 35, 36}, 0x38}, {{10, 19, 28, 37, 46, 55}, 0},
               {{250, 252, 255, 2, 3, 4}, 0x38}, {{5, 6, 7, 7, 8, 9}, 0x30},       {{5, 6, 7, 6, 7, 8}, 0},
               {{3, 4, 5, 101, 4, 5}, 0x08},     {{99, 100, 99, 100, 99, 100}, 0}};
  for (unsigned i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
    camera_input_reset(&input);
    TEST_ASSERT_TRUE(give_counter(100).fresh);
    unsigned counts = 0;
    for (unsigned n = 0; n < 6; ++n) {
      counts |= give_counter(cases[i].counter[n]).fresh ? 1u << n : 0u;
    }
    TEST_ASSERT_EQUAL_HEX8(cases[i].counts, counts);
    TEST_ASSERT_EQUAL(0, input.missed);
  }
}

static void test_a_frozen_counter_and_one_that_runs_backwards_never_count(void) {
  TEST_ASSERT_TRUE(give_counter(100).fresh);
  for (int i = 0; i < 1000; ++i) {
    TEST_ASSERT_FALSE(give_counter(100).fresh);
  }
  for (int i = 1; i < 128; ++i) {
    TEST_ASSERT_FALSE(give_counter((uint8_t)(100 - i)).fresh);
  }
  TEST_ASSERT_EQUAL(1127, input.dropped);
  TEST_ASSERT_EQUAL(CAMERA_NOT_NEWER, input.last_drop);
}

/* Of the last round; a ring is sent `rounds` times, with counters from 10 on. */
static unsigned taken_in_round(unsigned ring, unsigned rounds) {
  unsigned taken = 0;
  for (unsigned round = 0; round < rounds; ++round) {
    taken = 0;
    for (unsigned i = 0; i < ring; ++i) {
      taken += give_counter((uint8_t)(10 + i)).fresh ? 1 : 0;
    }
  }
  return taken;
}

/* In the second round it looks like a sender that was restarted, in the fifth it does not. */
static void test_frames_that_return_again_and_again_do_not_count(void) {
  for (unsigned ring = 1; ring <= CAMERA_COUNTERS - 8; ++ring) {
    camera_input_reset(&input);
    TEST_ASSERT_EQUAL(ring, taken_in_round(ring, 1));
    TEST_ASSERT_EQUAL(ring >= CAMERA_RESTART ? ring - CAMERA_RESTART + 1 : 0, taken_in_round(ring, 1));
    TEST_ASSERT_EQUAL(0, taken_in_round(ring, 4));
  }
}

/* Restarted by hand: once when its counters have gone round, and as often as wanted while no axis tracks. */
static void test_a_sender_that_begins_anew_later_is_heard_as_soon(void) {
  for (int restart = 0; restart < 20; ++restart) {
    for (unsigned i = 0; i <= CAMERA_COUNTERS + CAMERA_RESTART; ++i) {
      const bool fresh = give_counter((uint8_t)i).fresh;
      TEST_ASSERT_EQUAL(restart == 0 || i >= CAMERA_RESTART - 1, fresh);
    }
    tick += 3000;
    give_counter(105); /* then it begins anew from 0 */
  }
  for (int restart = 0; restart < 20; ++restart) {
    camera_input_expect_restarts(&input);
    TEST_ASSERT_EQUAL(20 - CAMERA_RESTART + 1, taken_in_round(20, 1));
  }
}

/* A sender has begun anew with counter 13: 256 frames up to the next 13, after which it may begin anew as soon again.
 */
static void test_the_counters_have_gone_round_after_256_frames(void) {
  TEST_ASSERT_TRUE(give_counter(100).fresh);
  TEST_ASSERT_EQUAL(20 - CAMERA_RESTART + 1, taken_in_round(20, 1)); /* counter 13 is heard, and then 16 more */
  for (unsigned frame = 17; frame <= CAMERA_COUNTERS; ++frame) {
    TEST_ASSERT_EQUAL(1, input.begun);
    TEST_ASSERT_TRUE(give_counter((uint8_t)(13 + frame)).fresh);
  }
  TEST_ASSERT_EQUAL(0, input.begun);
}

/* Again and again, each time after two frames that counted: counters 6, 14, 22, .. ahead of the last one are too far
 * for the time that has passed, and so never newer. More than 256 frames are not needed. */
static void test_a_sender_that_begins_anew_again_and_again_needs_256_frames_at_most(void) {
  static const unsigned needed[] = {4, 16, 64, 256, 256, 256};
  uint8_t counter = 0;
  TEST_ASSERT_TRUE(give_counter(counter).fresh);
  for (unsigned i = 0; i < sizeof needed / sizeof *needed; ++i) {
    TEST_ASSERT_TRUE(give_counter(++counter).fresh);
    TEST_ASSERT_TRUE(give_counter(++counter).fresh);
    counter = (uint8_t)(counter - 2);
    for (unsigned frame = 1; frame <= needed[i]; ++frame) {
      counter = (uint8_t)(counter + 8);
      TEST_ASSERT_EQUAL(frame == needed[i], give_counter(counter).fresh);
    }
  }
}

/* 128 counters apart, in turn: the first is heard, the other never. */
static void test_of_two_senders_half_of_the_counters_apart_the_first_is_heard(void) {
  for (int i = 0; i < 300; ++i) {
    tick += 10;
    TEST_ASSERT_TRUE(give_counter((uint8_t)i).fresh);
    tick += 10;
    TEST_ASSERT_FALSE(give_counter((uint8_t)(i + 128)).fresh);
  }
}

/* 60 counters apart, in turn: the one ahead is heard, the other never. */
static void test_of_two_senders_one_is_heard(void) {
  for (uint8_t i = 0; i < 200; ++i) {
    TEST_ASSERT_TRUE(give_counter((uint8_t)(60 + i)).fresh);
    TEST_ASSERT_FALSE(give_counter(i).fresh);
  }
  TEST_ASSERT_EQUAL(200, input.dropped);
}

static void test_parameters_out_of_range_are_refused(void) {
  TEST_ASSERT_EQUAL(CONTROL_OK, camera_input_check(&params));
  const camera_input_params good = params;
  params.scale_rad = 2e-3f;
  TEST_ASSERT_EQUAL(CONTROL_OUT_OF_RANGE, camera_input_check(&params));
  params = good;
  params.time = 4;
  TEST_ASSERT_EQUAL(CONTROL_OUT_OF_RANGE, camera_input_check(&params));
  params = good;
  params.min_quality = 0;
  TEST_ASSERT_EQUAL(CONTROL_OUT_OF_RANGE, camera_input_check(&params));
  params = good;
  params.mirrored = 2;
  TEST_ASSERT_EQUAL(CONTROL_OUT_OF_RANGE, camera_input_check(&params));
  params = good;
  params.mounting.boresight.y = 0.6f;
  TEST_ASSERT_EQUAL(CONTROL_OUT_OF_RANGE, camera_input_check(&params));
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_a_frame_has_age_and_errors_in_rad);
  RUN_TEST(test_roll_and_boresight_are_those_of_the_camera);
  RUN_TEST(test_a_mirrored_picture_is_turned_over);
  RUN_TEST(test_an_exposure_that_is_later_or_not_known_does_not_count);
  RUN_TEST(test_a_target_beyond_half_a_turn_does_not_count);
  RUN_TEST(test_an_error_at_the_end_of_its_numbers_does_not_count);
  RUN_TEST(test_a_counter_that_runs_backwards_never_counts);
  RUN_TEST(test_four_messages_in_a_row_run_backwards);
  RUN_TEST(test_a_frame_may_be_sent_many_times);
  RUN_TEST(test_frames_that_overtake_others_make_nobody_deaf);
  RUN_TEST(test_a_pause_does_not_change_the_rate);
  RUN_TEST(test_a_frame_older_than_the_history_does_not_count);
  RUN_TEST(test_quality_decides_whether_there_is_a_target);
  RUN_TEST(test_a_frame_counts_once_and_in_order_and_skipped_ones_are_counted);
  RUN_TEST(test_frames_that_were_lost_take_time);
  RUN_TEST(test_a_sender_may_change_its_rate);
  RUN_TEST(test_a_sender_that_began_anew_is_heard_from_its_fourth_advancing_counter);
  RUN_TEST(test_a_frozen_counter_and_one_that_runs_backwards_never_count);
  RUN_TEST(test_frames_that_return_again_and_again_do_not_count);
  RUN_TEST(test_a_sender_that_begins_anew_later_is_heard_as_soon);
  RUN_TEST(test_the_counters_have_gone_round_after_256_frames);
  RUN_TEST(test_a_sender_that_begins_anew_again_and_again_needs_256_frames_at_most);
  RUN_TEST(test_of_two_senders_half_of_the_counters_apart_the_first_is_heard);
  RUN_TEST(test_of_two_senders_one_is_heard);
  RUN_TEST(test_parameters_out_of_range_are_refused);
  return UNITY_END();
}
