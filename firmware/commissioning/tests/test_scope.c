/* SPDX-License-Identifier: Apache-2.0 */
/* The scope: captured values come out bit for bit, around the requested trigger. */
#include "commissioning/scope.h"

#include <string.h>

#include "support/check.h"

void setUp(void) {}
void tearDown(void) {}

static const float tick_s = 1e-3f;
static scope bench_scope; /* 32 KiB */
static float ramp_value;
static int32_t counter;
static uint32_t pattern;

static void tick(int number, uint32_t state, uint32_t faults) {
  ramp_value = (float)number * 0.5f;
  counter = -number;
  pattern = (uint32_t)number * 2654435761u;
  scope_step(&bench_scope, state, faults);
}

static scope_config three_channels(scope_source source) {
  return (scope_config){.channels = 3,
                        .channel = {{.id = 0x206C, .kind = SCOPE_FLOAT, .source = &ramp_value},
                                    {.id = 0x2077, .kind = SCOPE_INT32, .source = &counter},
                                    {.id = 7, .kind = SCOPE_UINT32, .source = &pattern}},
                        .divider = 1,
                        .pretrigger = 100,
                        .trigger = {.source = source}};
}

static int arm_and_run(const scope_config *config, int limit) {
  CHECK_STATUS(SCOPE_OK, scope_arm(&bench_scope, config, tick_s));
  int number = 0;
  while (bench_scope.phase != SCOPE_DONE && number < limit) {
    tick(number, number >= 1000 ? 2u : 1u, number >= 1234);
    ++number;
  }
  return number;
}

static uint32_t word_at(uint32_t offset) {
  uint8_t bytes[4];
  CHECK_STATUS(SCOPE_OK, scope_read(&bench_scope, offset, bytes, 4));
  return (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 | (uint32_t)bytes[3] << 24;
}

/* The tick in which a frame was taken, from the counter. */
static int tick_of_frame(uint32_t frame) { return -(int32_t)word_at(word_at(8) + 4 * (frame * word_at(12) + 1)); }

static void check_frames(int first_tick, int divider) {
  const uint32_t frames = word_at(16);
  for (uint32_t frame = 0; frame < frames; ++frame) {
    const uint32_t offset = word_at(8) + 12 * frame;
    const int number = first_tick + (int)frame * divider;
    const float expected = (float)number * 0.5f;
    uint32_t bits;
    memcpy(&bits, &expected, 4);
    TEST_ASSERT_EQUAL_HEX32(bits, word_at(offset));
    TEST_ASSERT_EQUAL_INT32(-number, (int32_t)word_at(offset + 4));
    TEST_ASSERT_EQUAL_HEX32((uint32_t)number * 2654435761u, word_at(offset + 8));
  }
}

static void test_the_header_reports_what_was_captured(void) {
  scope_config config = three_channels(SCOPE_IMMEDIATELY);
  config.divider = 4;
  (void)arm_and_run(&config, 100000);
  TEST_ASSERT_EQUAL_HEX32(0x43535354, word_at(0));
  TEST_ASSERT_EQUAL_UINT32(1, word_at(4));
  TEST_ASSERT_EQUAL_UINT32(32 + 3 * 8, word_at(8));
  TEST_ASSERT_EQUAL_UINT32(3, word_at(12));
  TEST_ASSERT_EQUAL_UINT32(2730, word_at(16));
  TEST_ASSERT_EQUAL_UINT32(100, word_at(20));
  TEST_ASSERT_EQUAL_UINT32(4, word_at(24));
  TEST_ASSERT_EQUAL_UINT32(1000000, word_at(28));
  const uint32_t channels[] = {0x206C, SCOPE_FLOAT, 0x2077, SCOPE_INT32, 7, SCOPE_UINT32};
  for (uint32_t i = 0; i < 6; ++i) {
    TEST_ASSERT_EQUAL_UINT32(channels[i], word_at(32 + 4 * i));
  }
  TEST_ASSERT_EQUAL_UINT32(56 + 2730 * 12, scope_bytes(&bench_scope));
  check_frames(0, 4);
}

static void test_a_state_change_is_in_the_frame_of_the_trigger_after_the_ring_has_wrapped(void) {
  scope_config config = three_channels(SCOPE_STATE_CHANGE);
  config.pretrigger = 700;
  const int ticks = arm_and_run(&config, 100000);
  TEST_ASSERT_EQUAL_INT(1000 - 700 + 2730, ticks);
  TEST_ASSERT_EQUAL_INT(1000, tick_of_frame(word_at(20)));
  check_frames(300, 1);
}

static void test_a_fault_triggers_when_it_begins(void) {
  const scope_config config = three_channels(SCOPE_FAULT);
  (void)arm_and_run(&config, 100000);
  TEST_ASSERT_EQUAL_INT(1234, tick_of_frame(word_at(20)));
  check_frames(1134, 1);
}

static void test_an_event_between_two_frames_triggers_the_next_one(void) {
  scope_config config = three_channels(SCOPE_FAULT);
  config.divider = 10;
  config.pretrigger = 3;
  (void)arm_and_run(&config, 100000);
  TEST_ASSERT_EQUAL_INT(1240, tick_of_frame(word_at(20)));
  check_frames(1210, 10);
}

static void test_a_fault_that_was_there_before_is_no_trigger(void) {
  const scope_config config = three_channels(SCOPE_FAULT);
  CHECK_STATUS(SCOPE_OK, scope_arm(&bench_scope, &config, tick_s));
  for (int i = 0; i < 5000; ++i) {
    tick(i, 3, i < 4000 ? 1 : 0);
  }
  TEST_ASSERT_EQUAL_INT(SCOPE_WAITING, bench_scope.phase);
  tick(5000, 3, 1);
  TEST_ASSERT_EQUAL_INT(SCOPE_TRIGGERED, bench_scope.phase);
}

static void test_a_fault_of_the_second_axis_triggers_while_the_first_one_has_its_own(void) {
  const scope_config config = three_channels(SCOPE_FAULT);
  CHECK_STATUS(SCOPE_OK, scope_arm(&bench_scope, &config, tick_s));
  for (int i = 0; i < 500; ++i) {
    tick(i, 3, 1);
  }
  TEST_ASSERT_EQUAL_INT(SCOPE_WAITING, bench_scope.phase);
  tick(500, 3, 3);
  TEST_ASSERT_EQUAL_INT(SCOPE_TRIGGERED, bench_scope.phase);
}

static int level_trigger(scope_source source, uint8_t channel, float level) {
  scope_config config = three_channels(source);
  config.trigger.channel = channel;
  config.trigger.level = level;
  return arm_and_run(&config, 6000) < 6000 ? tick_of_frame(word_at(20)) : -1;
}

static void test_levels_and_edges_of_every_kind_of_channel_trigger_in_their_frame(void) {
  TEST_ASSERT_EQUAL_INT(401, level_trigger(SCOPE_ABOVE, 0, 200.0f));
  TEST_ASSERT_EQUAL_INT(401, level_trigger(SCOPE_RISING, 0, 200.0f));
  TEST_ASSERT_EQUAL_INT(301, level_trigger(SCOPE_BELOW, 1, -300.0f));
  TEST_ASSERT_EQUAL_INT(301, level_trigger(SCOPE_FALLING, 1, -300.0f));
  /* True from the start: a level triggers once the frames before it are complete, an edge never comes. */
  TEST_ASSERT_EQUAL_INT(100, level_trigger(SCOPE_ABOVE, 0, -1.0f));
  TEST_ASSERT_EQUAL_INT(-1, level_trigger(SCOPE_RISING, 0, -1.0f));
  TEST_ASSERT_EQUAL_INT(-1, level_trigger(SCOPE_FALLING, 0, -1.0f));
  TEST_ASSERT_EQUAL_INT(100, level_trigger(SCOPE_ABOVE, 2, -1.0f));
}

static void test_an_edge_while_the_pretrigger_fills_does_not_count(void) {
  TEST_ASSERT_EQUAL_INT(-1, level_trigger(SCOPE_RISING, 0, 20.0f)); /* at tick 41 of 100 */
}

static void test_an_event_while_the_pretrigger_fills_does_not_count(void) {
  const scope_config config = three_channels(SCOPE_STATE_CHANGE);
  CHECK_STATUS(SCOPE_OK, scope_arm(&bench_scope, &config, tick_s));
  for (int i = 0; i < 1000; ++i) {
    tick(i, i < 50 ? 3 : 4, 0);
  }
  TEST_ASSERT_EQUAL_INT(SCOPE_WAITING, bench_scope.phase);
  tick(1000, 5, 0);
  TEST_ASSERT_EQUAL_INT(SCOPE_TRIGGERED, bench_scope.phase);
}

static void test_a_forced_trigger_ends_the_wait_and_keeps_the_frames_before_it(void) {
  scope_config config = three_channels(SCOPE_ABOVE);
  config.trigger.level = 1e9f;
  TEST_ASSERT_EQUAL_INT(500, arm_and_run(&config, 500));
  TEST_ASSERT_EQUAL_INT(SCOPE_WAITING, bench_scope.phase);
  scope_force(&bench_scope);
  for (int i = 500; bench_scope.phase != SCOPE_DONE; ++i) {
    tick(i, 1, 0);
  }
  TEST_ASSERT_EQUAL_UINT32(2730, word_at(16));
  TEST_ASSERT_EQUAL_INT(500, tick_of_frame(word_at(20)));
  check_frames(400, 1);
}

static void test_a_trigger_forced_while_the_pretrigger_fills_has_fewer_frames_before_it(void) {
  scope_config config = three_channels(SCOPE_FAULT);
  config.pretrigger = 1000;
  TEST_ASSERT_EQUAL_INT(40, arm_and_run(&config, 40));
  TEST_ASSERT_EQUAL_INT(SCOPE_FILLING, bench_scope.phase);
  scope_force(&bench_scope);
  for (int i = 40; bench_scope.phase != SCOPE_DONE; ++i) {
    tick(i, 1, 0);
  }
  TEST_ASSERT_EQUAL_UINT32(40, word_at(20));
  TEST_ASSERT_EQUAL_UINT32(40 + 2730 - 1000, word_at(16));
  check_frames(0, 1);
}

static void test_a_force_without_a_wait_does_nothing(void) {
  scope_config config = three_channels(SCOPE_IMMEDIATELY);
  scope_reset(&bench_scope);
  scope_force(&bench_scope);
  TEST_ASSERT_EQUAL_INT(SCOPE_IDLE, bench_scope.phase);
  (void)arm_and_run(&config, 100000);
  scope_force(&bench_scope);
  TEST_ASSERT_EQUAL_INT(SCOPE_DONE, bench_scope.phase);
}

static void test_a_value_that_is_no_number_never_triggers_and_is_kept_bit_for_bit(void) {
  scope_config config = three_channels(SCOPE_ABOVE);
  config.pretrigger = 0;
  config.channels = 1;
  CHECK_STATUS(SCOPE_OK, scope_arm(&bench_scope, &config, tick_s));
  const uint32_t odd_nan = 0x7FC12345;
  for (int i = 0; i < 9000; ++i) {
    memcpy(&ramp_value, &odd_nan, 4);
    scope_step(&bench_scope, 0, 0);
  }
  TEST_ASSERT_EQUAL_INT(SCOPE_WAITING, bench_scope.phase);
  ramp_value = 1.0f;
  scope_step(&bench_scope, 0, 0);
  memcpy(&ramp_value, &odd_nan, 4);
  while (bench_scope.phase != SCOPE_DONE) {
    scope_step(&bench_scope, 0, 0);
  }
  TEST_ASSERT_EQUAL_HEX32(0x3F800000, word_at(40));
  TEST_ASSERT_EQUAL_HEX32(odd_nan, word_at(44));
  TEST_ASSERT_EQUAL_UINT32(40 + 32768, scope_bytes(&bench_scope));
}

static void test_the_stream_is_the_same_in_pieces_of_any_length(void) {
  static uint8_t whole[56 + 2730 * 12];
  scope_config config = three_channels(SCOPE_STATE_CHANGE);
  (void)arm_and_run(&config, 100000);
  const uint32_t total = scope_bytes(&bench_scope);
  TEST_ASSERT_EQUAL_UINT32(sizeof whole, total);
  CHECK_STATUS(SCOPE_OK, scope_read(&bench_scope, 0, whole, total));
  const uint32_t lengths[] = {1, 3, 7, 127, 889, 4096};
  uint8_t piece[4096];
  for (unsigned n = 0; n < 6; ++n) {
    for (uint32_t offset = 0; offset < total; offset += lengths[n]) {
      const uint32_t length = total - offset < lengths[n] ? total - offset : lengths[n];
      CHECK_STATUS(SCOPE_OK, scope_read(&bench_scope, offset, piece, length));
      TEST_ASSERT_EQUAL_MEMORY(&whole[offset], piece, length);
    }
  }
}

static void test_reads_outside_a_finished_capture_are_refused(void) {
  uint8_t byte = 0xAA;
  scope_config config = three_channels(SCOPE_IMMEDIATELY);
  scope_reset(&bench_scope);
  CHECK_STATUS(SCOPE_NO_DATA, scope_read(&bench_scope, 0, &byte, 1));
  (void)arm_and_run(&config, 10);
  TEST_ASSERT_EQUAL_UINT32(0, scope_bytes(&bench_scope));
  CHECK_STATUS(SCOPE_NO_DATA, scope_read(&bench_scope, 0, &byte, 1));
  (void)arm_and_run(&config, 100000);
  const uint32_t total = scope_bytes(&bench_scope);
  CHECK_STATUS(SCOPE_OUT_OF_RANGE, scope_read(&bench_scope, total, &byte, 1));
  CHECK_STATUS(SCOPE_OUT_OF_RANGE, scope_read(&bench_scope, UINT32_MAX, &byte, 2));
  CHECK_STATUS(SCOPE_OK, scope_read(&bench_scope, total, &byte, 0));
  TEST_ASSERT_EQUAL_HEX8(0xAA, byte);
}

static void test_a_stopped_scope_gives_what_it_has(void) {
  scope_config config = three_channels(SCOPE_STATE_CHANGE);
  (void)arm_and_run(&config, 50); /* filling */
  scope_stop(&bench_scope);
  TEST_ASSERT_EQUAL_UINT32(50, word_at(16));
  TEST_ASSERT_EQUAL_UINT32(50, word_at(20)); /* no trigger */
  check_frames(0, 1);
  (void)arm_and_run(&config, 900); /* waiting */
  scope_stop(&bench_scope);
  TEST_ASSERT_EQUAL_UINT32(900, word_at(20));
  (void)arm_and_run(&config, 3500); /* triggered, ring wrapped */
  scope_stop(&bench_scope);
  TEST_ASSERT_EQUAL_INT(1000, tick_of_frame(word_at(20)));
  check_frames(3500 - 2730, 1);
  scope_stop(&bench_scope); /* once more changes nothing */
  TEST_ASSERT_EQUAL_INT(1000, tick_of_frame(word_at(20)));
  scope_reset(&bench_scope);
  scope_stop(&bench_scope);
  TEST_ASSERT_EQUAL_UINT32(0, scope_bytes(&bench_scope));
  tick(0, 0, 0);
  TEST_ASSERT_EQUAL_INT(SCOPE_IDLE, bench_scope.phase);
}

static void test_a_pretrigger_as_long_as_the_buffer_allows_ends_with_the_trigger(void) {
  scope_config config = three_channels(SCOPE_FAULT);
  config.pretrigger = 2729;
  CHECK_STATUS(SCOPE_OK, scope_arm(&bench_scope, &config, tick_s));
  for (int i = 0; i < 5000; ++i) {
    tick(i, 0, i >= 4000);
  }
  TEST_ASSERT_EQUAL_INT(4000, tick_of_frame(2729));
  TEST_ASSERT_EQUAL_UINT32(2729, word_at(20));
}

static void test_bad_configurations_are_refused_and_change_nothing(void) {
  scope_config good = three_channels(SCOPE_IMMEDIATELY);
  (void)arm_and_run(&good, 100000);
  const uint32_t total = scope_bytes(&bench_scope);
  scope_config bad = good;
  bad.channels = 0;
  CHECK_STATUS(SCOPE_BAD_CHANNELS, scope_arm(&bench_scope, &bad, tick_s));
  bad.channels = 9;
  CHECK_STATUS(SCOPE_BAD_CHANNELS, scope_arm(&bench_scope, &bad, tick_s));
  bad = good;
  bad.channel[2].source = NULL;
  CHECK_STATUS(SCOPE_BAD_CHANNELS, scope_arm(&bench_scope, &bad, tick_s));
  bad = good;
  bad.channel[1].kind = (scope_kind)3;
  CHECK_STATUS(SCOPE_BAD_CHANNELS, scope_arm(&bench_scope, &bad, tick_s));
  bad = good;
  bad.divider = 0;
  CHECK_STATUS(SCOPE_BAD_DIVIDER, scope_arm(&bench_scope, &bad, tick_s));
  bad = good;
  bad.pretrigger = 2730;
  CHECK_STATUS(SCOPE_BAD_PRETRIGGER, scope_arm(&bench_scope, &bad, tick_s));
  bad.pretrigger = 60000;
  CHECK_STATUS(SCOPE_BAD_PRETRIGGER, scope_arm(&bench_scope, &bad, tick_s));
  bad = good;
  bad.trigger.source = (scope_source)7;
  CHECK_STATUS(SCOPE_BAD_TRIGGER, scope_arm(&bench_scope, &bad, tick_s));
  bad.trigger = (scope_trigger){.source = SCOPE_RISING, .channel = 3};
  CHECK_STATUS(SCOPE_BAD_TRIGGER, scope_arm(&bench_scope, &bad, tick_s));
  bad.trigger = (scope_trigger){.source = SCOPE_FALLING, .level = NAN};
  CHECK_STATUS(SCOPE_BAD_TRIGGER, scope_arm(&bench_scope, &bad, tick_s));
  TEST_ASSERT_EQUAL_UINT32(total, scope_bytes(&bench_scope));
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_the_header_reports_what_was_captured);
  RUN_TEST(test_a_state_change_is_in_the_frame_of_the_trigger_after_the_ring_has_wrapped);
  RUN_TEST(test_a_fault_triggers_when_it_begins);
  RUN_TEST(test_an_event_between_two_frames_triggers_the_next_one);
  RUN_TEST(test_a_fault_that_was_there_before_is_no_trigger);
  RUN_TEST(test_a_fault_of_the_second_axis_triggers_while_the_first_one_has_its_own);
  RUN_TEST(test_levels_and_edges_of_every_kind_of_channel_trigger_in_their_frame);
  RUN_TEST(test_an_edge_while_the_pretrigger_fills_does_not_count);
  RUN_TEST(test_an_event_while_the_pretrigger_fills_does_not_count);
  RUN_TEST(test_a_forced_trigger_ends_the_wait_and_keeps_the_frames_before_it);
  RUN_TEST(test_a_trigger_forced_while_the_pretrigger_fills_has_fewer_frames_before_it);
  RUN_TEST(test_a_force_without_a_wait_does_nothing);
  RUN_TEST(test_a_value_that_is_no_number_never_triggers_and_is_kept_bit_for_bit);
  RUN_TEST(test_the_stream_is_the_same_in_pieces_of_any_length);
  RUN_TEST(test_reads_outside_a_finished_capture_are_refused);
  RUN_TEST(test_a_stopped_scope_gives_what_it_has);
  RUN_TEST(test_a_pretrigger_as_long_as_the_buffer_allows_ends_with_the_trigger);
  RUN_TEST(test_bad_configurations_are_refused_and_change_nothing);
  return UNITY_END();
}
