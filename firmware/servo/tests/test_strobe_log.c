/* SPDX-License-Identifier: Apache-2.0 */
/* Which edge of the camera's strobe is the exposure of a frame: 50 Hz, frames 20 ms after their exposure. */
#include "servo/strobe_log.h"

#include "unity.h"

enum { FRAME_US = 20000, DELAY_US = 20000, EDGE_US = 7 };

static strobe_log strobes;
static strobe_params params;
static uint8_t counter;
static uint32_t exposed_us; /* of the last frame */

void setUp(void) {
  strobe_log_reset(&strobes);
  params = (strobe_params){.youngest = 1100, .oldest = 2900};
  counter = 250;
  exposed_us = 0;
}

void tearDown(void) {}

static void edge(uint32_t at_us) { strobe_log_add(&strobes, &(hal_strobes){.count = 1, .at_us = {at_us}}); }

/* The next frame's edge, and `delay_us` later the frame. */
static bool frame(uint32_t delay_us) {
  exposed_us += FRAME_US;
  edge(exposed_us);
  return strobe_log_pair(&strobes, &params, ++counter, exposed_us + delay_us);
}

/* Frames until edges and frames are in step. */
static void get_in_step(void) {
  for (int i = 1; i < STROBE_LOG_AGREE; ++i) {
    TEST_ASSERT_FALSE(frame(DELAY_US));
  }
  TEST_ASSERT_EQUAL(STROBE_OUT_OF_ORDER, strobes.last_refusal);
  TEST_ASSERT_TRUE(frame(DELAY_US));
}

static void test_a_frame_has_the_age_of_its_edge(void) {
  get_in_step();
  TEST_ASSERT_TRUE(frame(DELAY_US + 3210));
  TEST_ASSERT_EQUAL_UINT32(23210, strobes.age_us);
  params.half_exposure_us = 500;
  TEST_ASSERT_TRUE(frame(DELAY_US));
  TEST_ASSERT_EQUAL_UINT32(19500, strobes.age_us);
  TEST_ASSERT_EQUAL_UINT32(exposed_us, strobe_log_newest_us(&strobes));
}

/* Two edges within a tick, as of a camera that bounces, are handed over together: the newest is known, and both count.
 */
static void test_edges_that_come_together_are_all_taken(void) {
  strobe_log_add(&strobes, &(hal_strobes){.count = 2, .at_us = {100, 300}});
  TEST_ASSERT_EQUAL_UINT32(2, strobes.edges);
  TEST_ASSERT_EQUAL_UINT32(300, strobe_log_newest_us(&strobes));
}

static void test_the_clock_may_wrap(void) {
  exposed_us = UINT32_MAX - 100000;
  get_in_step();
  for (int i = 0; i < 10; ++i) {
    TEST_ASSERT_TRUE(frame(DELAY_US));
    TEST_ASSERT_EQUAL_UINT32(DELAY_US, strobes.age_us);
  }
  TEST_ASSERT_TRUE(exposed_us < 1000000);
}

/* The strobe ends, and frames alone go on at 50 Hz, at once or after 40 min: 71.6 min after its end the clock has gone
 * round, and shows the age of the last edges as it was then. */
static void test_a_strobe_that_has_ended_does_not_come_back(void) {
  static const unsigned pauses_min[] = {0, 40};
  for (int p = 0; p < 2; ++p) {
    setUp();
    get_in_step();
    exposed_us += pauses_min[p] * 60u * 1000000u;
    for (unsigned i = 0; i < (75u - pauses_min[p]) * 60u * 50u; ++i) {
      exposed_us += FRAME_US;
      TEST_ASSERT_FALSE(strobe_log_pair(&strobes, &params, ++counter, exposed_us + DELAY_US));
      TEST_ASSERT_EQUAL(STROBE_NONE, strobes.last_refusal);
    }
  }
}

static void test_an_age_outside_the_window_is_refused(void) {
  get_in_step();
  TEST_ASSERT_TRUE(frame(11000));
  TEST_ASSERT_TRUE(frame(29000));
  TEST_ASSERT_FALSE(frame(10999));
  TEST_ASSERT_EQUAL(STROBE_NONE, strobes.last_refusal);
  TEST_ASSERT_FALSE(frame(29001));
  TEST_ASSERT_TRUE(frame(DELAY_US));
}

/* The strobe has paused. Its last edge but one is 71.6 minutes old, when the clock of 2^32 us has once gone round: it
 * looks 20 ms old. The last one is 70 ms old, and nothing before it can be the exposure. */
static void test_an_edge_before_one_that_is_too_old_is_no_exposure(void) {
  get_in_step();
  edge(exposed_us + FRAME_US);
  edge(exposed_us + FRAME_US - 50000);
  exposed_us += FRAME_US;
  TEST_ASSERT_FALSE(strobe_log_pair(&strobes, &params, ++counter, exposed_us + DELAY_US));
  TEST_ASSERT_EQUAL(STROBE_NONE, strobes.last_refusal);
}

/* Three frames are lost on the bus, their edges are not. */
static void test_frames_lost_on_the_bus_change_nothing(void) {
  get_in_step();
  for (int i = 0; i < 3; ++i) {
    exposed_us += FRAME_US;
    edge(exposed_us);
    ++counter;
  }
  TEST_ASSERT_TRUE(frame(DELAY_US));
  TEST_ASSERT_EQUAL_UINT32(DELAY_US, strobes.age_us);
  TEST_ASSERT_EQUAL_UINT32(0, strobes.missing + strobes.additional);
}

/* Its frame, and those until edges and frames are in step again, count by the sender's statement. */
static void test_a_missing_edge_is_counted(void) {
  get_in_step();
  exposed_us += FRAME_US;
  TEST_ASSERT_FALSE(strobe_log_pair(&strobes, &params, ++counter, exposed_us + DELAY_US));
  TEST_ASSERT_EQUAL(STROBE_NONE, strobes.last_refusal);
  get_in_step();
  TEST_ASSERT_EQUAL_UINT32(1, strobes.missing);
  TEST_ASSERT_EQUAL_UINT32(0, strobes.additional);
}

static void test_additional_edges_are_counted(void) {
  get_in_step();
  edge(exposed_us + 4000);
  edge(exposed_us + 5000);
  get_in_step();
  TEST_ASSERT_EQUAL_UINT32(2, strobes.additional);
  edge(exposed_us + 4000);
  get_in_step();
  TEST_ASSERT_EQUAL_UINT32(3, strobes.additional);
  TEST_ASSERT_EQUAL_UINT32(0, strobes.missing);
}

/* Noise next to the edge: nothing shows which of the two is the exposure. */
static void test_two_edges_within_the_window_are_refused(void) {
  get_in_step();
  edge(exposed_us + FRAME_US - EDGE_US);
  TEST_ASSERT_FALSE(frame(DELAY_US));
  TEST_ASSERT_EQUAL(STROBE_SEVERAL, strobes.last_refusal);
}

/* A frame that comes a whole frame time late meets the edge of the next one: out of step, and so refused. */
static void test_the_edge_of_another_frame_is_refused(void) {
  get_in_step();
  const uint32_t late_us = exposed_us + FRAME_US;
  edge(late_us);
  edge(late_us + FRAME_US);
  exposed_us = late_us + FRAME_US;
  TEST_ASSERT_FALSE(strobe_log_pair(&strobes, &params, ++counter, late_us + 2 * DELAY_US));
  TEST_ASSERT_EQUAL(STROBE_OUT_OF_ORDER, strobes.last_refusal);
  TEST_ASSERT_TRUE(strobe_log_pair(&strobes, &params, ++counter, exposed_us + DELAY_US));
  TEST_ASSERT_EQUAL_UINT32(DELAY_US, strobes.age_us);
}

static void test_a_frame_that_comes_twice_is_none(void) {
  get_in_step();
  const uint32_t unpaired = strobes.unpaired;
  TEST_ASSERT_FALSE(strobe_log_pair(&strobes, &params, counter, exposed_us + DELAY_US));
  TEST_ASSERT_TRUE(frame(DELAY_US));
  TEST_ASSERT_EQUAL_UINT32(unpaired, strobes.unpaired);
}

static void test_a_sender_that_began_anew_gets_in_step_again(void) {
  get_in_step();
  counter = (uint8_t)(counter - 100);
  get_in_step();
  TEST_ASSERT_EQUAL_UINT32(0, strobes.missing + strobes.additional);
}

/* The next frame, whose counter is `more` further than it should be. */
static void stray_frame(int more) {
  counter = (uint8_t)(counter + more);
  TEST_ASSERT_FALSE(frame(DELAY_US));
  TEST_ASSERT_EQUAL(STROBE_OUT_OF_ORDER, strobes.last_refusal);
}

/* Four frames in a row, one in step between them begins it anew. */
static void test_frames_that_agree_on_another_order_count_from_the_last_one_in_step(void) {
  get_in_step();
  for (int i = 0; i < 3; ++i) {
    stray_frame(3);
    for (int edges = 0; edges < 3; ++edges) {
      exposed_us += FRAME_US;
      edge(exposed_us);
    }
    TEST_ASSERT_TRUE(frame(DELAY_US)); /* as before */
  }
  counter = (uint8_t)(counter + 3);
  get_in_step();
  TEST_ASSERT_EQUAL_UINT32(3, strobes.missing);
}

/* One frame of another order, 200 that are lost on the bus, and a counter that looks like that of a new sender. */
static void test_frames_before_a_sender_that_began_anew_do_not_count_for_its_order(void) {
  get_in_step();
  stray_frame(100);
  for (int i = 0; i < 200; ++i) {
    exposed_us += FRAME_US;
    edge(exposed_us);
    ++counter;
  }
  get_in_step();
  TEST_ASSERT_EQUAL_UINT32(0, strobes.missing + strobes.additional);
}

/* 127 counters ahead it is the same sender, and 126 edges are missing; 128 ahead it is another one. */
static void test_half_of_the_counters_ahead_is_a_sender_that_began_anew(void) {
  for (int anew = 0; anew <= 1; ++anew) {
    setUp();
    get_in_step();
    counter = (uint8_t)(counter + 126 + anew);
    get_in_step();
    TEST_ASSERT_EQUAL_UINT32(anew != 0 ? 0 : 126, strobes.missing);
    TEST_ASSERT_EQUAL_UINT32(0, strobes.additional);
  }
}

/* As many as the log remembers; a frame of the oldest of them is paired, one of an edge before it is not. */
static void test_64_edges_are_remembered(void) {
  TEST_ASSERT_EQUAL_UINT32(0, strobe_log_newest_us(&strobes));
  for (int pass = 0; pass <= 1; ++pass) {
    strobe_log_reset(&strobes);
    for (uint32_t i = 0; i < 200; ++i) { /* at 1 kHz */
      edge(i * 1000);
      const uint32_t back_us = pass == 0 ? 63000 : 64000;
      params.youngest = (uint16_t)(back_us / 10);
      params.oldest = (uint16_t)(back_us / 10 + 99);
      const bool paired = strobe_log_pair(&strobes, &params, (uint8_t)i, i * 1000 + 1);
      TEST_ASSERT_EQUAL(pass == 0 && i >= 63 + STROBE_LOG_AGREE - 1, paired);
    }
  }
}

/* A sender whose counter says something else in each frame has no order to get in step with. */
static void test_a_counter_that_jumps_never_gets_in_step(void) {
  for (int i = 0; i < 10 * STROBE_LOG_AGREE; ++i) {
    counter = (uint8_t)(counter + 7 * i);
    TEST_ASSERT_FALSE(frame(DELAY_US));
  }
  TEST_ASSERT_EQUAL_UINT32(0, strobes.paired);
}

/* Edges at 20 kHz for 10 s: nothing is paired, each ms is counted, and then it works again. */
static void test_noise_is_counted_and_pairs_nothing(void) {
  get_in_step();
  const uint32_t paired = strobes.paired;
  for (int ms = 0; ms < 10000; ++ms) {
    strobe_log_add(&strobes, &(hal_strobes){.flooded = true});
  }
  exposed_us += 10000000;
  counter = (uint8_t)(counter + 500);
  TEST_ASSERT_FALSE(strobe_log_pair(&strobes, &params, ++counter, exposed_us + DELAY_US));
  TEST_ASSERT_EQUAL_UINT32(10000, strobes.floods);
  TEST_ASSERT_EQUAL_UINT32(paired, strobes.paired);
  get_in_step();
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_a_frame_has_the_age_of_its_edge);
  RUN_TEST(test_edges_that_come_together_are_all_taken);
  RUN_TEST(test_the_clock_may_wrap);
  RUN_TEST(test_an_age_outside_the_window_is_refused);
  RUN_TEST(test_a_strobe_that_has_ended_does_not_come_back);
  RUN_TEST(test_an_edge_before_one_that_is_too_old_is_no_exposure);
  RUN_TEST(test_frames_lost_on_the_bus_change_nothing);
  RUN_TEST(test_a_missing_edge_is_counted);
  RUN_TEST(test_additional_edges_are_counted);
  RUN_TEST(test_two_edges_within_the_window_are_refused);
  RUN_TEST(test_the_edge_of_another_frame_is_refused);
  RUN_TEST(test_a_frame_that_comes_twice_is_none);
  RUN_TEST(test_a_sender_that_began_anew_gets_in_step_again);
  RUN_TEST(test_frames_that_agree_on_another_order_count_from_the_last_one_in_step);
  RUN_TEST(test_frames_before_a_sender_that_began_anew_do_not_count_for_its_order);
  RUN_TEST(test_half_of_the_counters_ahead_is_a_sender_that_began_anew);
  RUN_TEST(test_64_edges_are_remembered);
  RUN_TEST(test_a_counter_that_jumps_never_gets_in_step);
  RUN_TEST(test_noise_is_counted_and_pairs_nothing);
  return UNITY_END();
}
