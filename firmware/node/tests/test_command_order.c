/* SPDX-License-Identifier: Apache-2.0 */
/* Controlwords and NMT commands that arrive within one tick: each takes effect as in a tick of its own, in the order of
 * arrival. */
#include <stdio.h>

#include "support/check.h"
#include "support/node_bench.h"

enum {
  RPDO1 = 0x200 + NODE_ID, /* controlword, mode */
  EMCY = 0x080 + NODE_ID,
  SYNC = 0x080,
  NONE = 0xFFFF,
  NMT = 0x1000, /* in a row of frames: the NMT command in the low byte, not a controlword */
  START = NMT | 0x01,
  STOP = NMT | 0x02,
  PRE_OPERATIONAL = NMT | 0x80,
  PP = 1,
  PV = 3,
  STATE_OFF = 0x60, /* switch on disabled */
  STATE_IN_FAULT = 0x28,
  NODE_STOPPED = 26, /* fault */
  STOPPED_MS = 1500
};

/* NONE: no frame. */
static void burst(uint16_t first, uint16_t second, uint16_t third) {
  const uint16_t words[] = {first, second, third};
  for (uint32_t i = 0; i < 3 && words[i] != NONE; ++i) {
    give(RPDO1, 3, (const uint8_t[]){(uint8_t)words[i], (uint8_t)(words[i] >> 8), PV});
  }
}

static void turn_with_quick_stop_option(uint16_t option) {
  node_bench_start();
  nmt(1);
  SET(0x6007, 0, 0); /* the master may be silent */
  SET(0x605A, 0, option);
  enable(0, PV);
  SET(0x60FF, 0, 300000);
  wait_ms(900);
  CHECK_NEAR("rad/s", 0.3, machine.axis[0].rate_rad_s, 0.003);
}

void setUp(void) { node_bench_start(); }
void tearDown(void) {}

/* Rows: 605A and the words of one burst; the state in which the axis ends. */
static void test_a_stop_is_not_undone_by_a_later_word_of_the_same_tick(void) {
  static const struct {
    uint16_t option, word[3];
    uint32_t state;
  } rows[] = {
      {0, {0x02, 0x8F, NONE}, STATE_OFF},          {1, {0x02, 0x8F, NONE}, STATE_OFF},
      {2, {0x02, 0x8F, NONE}, STATE_OFF},          {5, {0x02, 0x8F, NONE}, STATE_QUICK_STOP},
      {6, {0x02, 0x8F, NONE}, STATE_QUICK_STOP},   {2, {0x010F, 0x02, 0x8F}, STATE_OFF},
      {5, {0x010F, 0x02, 0x8F}, STATE_QUICK_STOP}, {2, {0x02, 0x0F, NONE}, STATE_OFF},
      {2, {0x00, 0x0F, NONE}, STATE_OFF},          {6, {0x00, 0x0F, NONE}, STATE_OFF},
  };
  for (uint32_t i = 0; i < sizeof rows / sizeof rows[0]; ++i) {
    turn_with_quick_stop_option(rows[i].option);
    burst(rows[i].word[0], rows[i].word[1], rows[i].word[2]);
    wait_ms(STOPPED_MS);
    char row[16];
    (void)snprintf(row, sizeof row, "row %u", (unsigned)i);
    TEST_ASSERT_EQUAL_HEX32_MESSAGE(rows[i].state, state_of(0), row);
    const bool coasts = rows[i].option == 0 || rows[i].word[0] == 0x00;
    CHECK_NEAR(row, 0.0, coasts ? 0.0 : machine.axis[0].rate_rad_s, 0.002);
  }
}

static void test_enable_operation_after_a_quick_stop_that_stays_enables_again(void) {
  turn_with_quick_stop_option(5);
  burst(0x02, 0x0F, NONE); /* transitions 11 and 16 */
  wait_ms(STOPPED_MS);
  TEST_ASSERT_EQUAL_HEX32(STATE_ENABLED, state_of(0));
  CHECK_NEAR("rad/s", 0.3, machine.axis[0].rate_rad_s, 0.003);
}

static void test_halt_is_a_level(void) {
  turn_with_quick_stop_option(2);
  burst(0x010F, 0x0F, NONE);
  wait_ms(STOPPED_MS);
  CHECK_NEAR("rad/s", 0.3, machine.axis[0].rate_rad_s, 0.003);
}

static void map_rpdo1_to_controlword_and_target(void) {
  SET(0x1400, 1, 0x80000000u | RPDO1);
  SET(0x1600, 0, 0);
  SET(0x1600, 2, 0x607A0020);
  SET(0x1600, 0, 2);
  SET(0x1400, 1, RPDO1);
}

static void test_each_edge_of_bit_4_starts_a_move_with_its_own_target(void) {
  map_rpdo1_to_controlword_and_target();
  nmt(1);
  SET(0x6007, 0, 0);
  enable(0, PP);
  const int32_t start = (int32_t)get(0x6064, 0);
  const uint16_t relative = 0x4F;
  const int32_t moves[] = {100000, 0, 50000};
  for (uint32_t i = 0; i < 3; ++i) {
    const uint16_t word = (uint16_t)(relative | (i == 1 ? 0x00 : 0x10));
    const uint32_t target = (uint32_t)moves[i];
    give(RPDO1, 6,
         (const uint8_t[]){(uint8_t)word, 0, (uint8_t)target, (uint8_t)(target >> 8), (uint8_t)(target >> 16),
                           (uint8_t)(target >> 24)});
  }
  wait_ms(3000);
  CHECK_NEAR("counts", 150000.0, (int32_t)get(0x6064, 0) - start, 50.0);
}

/* The download of 02 takes effect in the tick after its answer; the RPDO arrives before that tick. */
static void test_a_stop_by_sdo_is_not_undone_by_an_rpdo(void) {
  turn_with_quick_stop_option(2);
  SET(0x6040, 0, 0x02);
  burst(0x8F, 0x0F, NONE);
  wait_ms(STOPPED_MS);
  TEST_ASSERT_EQUAL_HEX32(STATE_OFF, state_of(0));
}

static void give_at(uint16_t received_us, uint32_t id, uint8_t length, const uint8_t *bytes) {
  can_frame frame = {.id = id, .length = length, .received_us = received_us};
  memcpy(frame.data, bytes, length);
  TEST_ASSERT_TRUE(servo_node_receive(&node, &frame));
}

/* Both arrive while the deferred task runs, so it comes before the tick that takes the RPDO. 605C = 0. */
static void test_a_controlword_by_sdo_does_not_overtake_one_by_pdo(void) {
  static const struct {
    uint16_t rpdo_us, sdo_us; /* modulo 2^16 */
    uint32_t state;
  } rows[] = {{100, 300, STATE_READY}, {65500, 50, STATE_READY}, {300, 100, STATE_SWITCHED_ON}};
  for (uint32_t i = 0; i < sizeof rows / sizeof rows[0]; ++i) {
    turn_with_quick_stop_option(2);
    SET(0x605C, 0, 0);
    give_at(rows[i].rpdo_us, RPDO1, 3, (const uint8_t[]){0x07, 0, PV});
    give_at(rows[i].sdo_us, 0x600 + NODE_ID, 8, (const uint8_t[]){0x2B, 0x40, 0x60, 0, 0x06, 0, 0, 0});
    servo_node_serve(&node);
    wait_ms(10);
    TEST_ASSERT_EQUAL_HEX32(rows[i].state, state_of(0));
  }
}

/* 60 frames within one tick: the queue of 64 is more than half full. The stop comes behind them. */
static void test_a_stop_behind_a_flood_of_commands_is_obeyed_within_40_ms(void) {
  turn_with_quick_stop_option(2);
  sent_count = 0;
  for (int i = 0; i < 58; ++i) {
    give(RPDO1, 3, (const uint8_t[]){i % 2 == 0 ? 0x1F : 0x0F, 0, PV});
  }
  burst(0x02, 0x0F, NONE);
  wait_ms(40);
  const can_frame *reported = last_sent(EMCY);
  TEST_ASSERT_NOT_NULL(reported);
  TEST_ASSERT_EQUAL_HEX16(0x8110, reported->data[0] | reported->data[1] << 8);
  TEST_ASSERT_EQUAL_HEX32(STATE_QUICK_STOP, state_of(0));
  wait_ms(STOPPED_MS);
  TEST_ASSERT_EQUAL_HEX32(STATE_OFF, state_of(0));
}

/* 34 commands within one tick: the second one finds the queue of 64 more than half full, and is dropped. In the
 * second round the controller has lost one frame in the same tick. */
static void test_a_dropped_command_and_a_lost_frame_in_one_tick_are_an_overrun(void) {
  for (uint32_t lost = 0; lost <= 1; ++lost) {
    turn_with_quick_stop_option(2);
    sent_count = 0;
    for (int i = 0; i < 34; ++i) {
      give(RPDO1, 3, (const uint8_t[]){i % 2 == 0 ? 0x1F : 0x0F, 0, PV});
    }
    canopen_node_lost_frames(&node.canopen, lost);
    wait_ms(2);
    const can_frame *reported = last_sent(EMCY);
    TEST_ASSERT_NOT_NULL(reported);
    TEST_ASSERT_EQUAL_HEX16(0x8110, reported->data[0] | reported->data[1] << 8);
  }
}

static void give_in_one_tick(const uint16_t *row, uint32_t count) {
  for (uint32_t i = 0; i < count && row[i] != NONE; ++i) {
    if ((row[i] & NMT) != 0) {
      give(0, 2, (const uint8_t[]){(uint8_t)row[i], NODE_ID});
    } else {
      burst(row[i], NONE, NONE);
    }
  }
}

/* The node was stopped while the axis turned. `word` is the controlword since then: its edge came during the reaction,
 * where it resets nothing. */
static void end_in_fault_with(uint16_t word) {
  turn_with_quick_stop_option(2);
  nmt(2);
  nmt(1);
  burst(word, NONE, NONE);
  wait_ms(STOPPED_MS);
  TEST_ASSERT_EQUAL_HEX32(STATE_IN_FAULT, state_of(0));
}

/* A stop, then a weaker one that is obeyed although its frame is too short, or replaced before the SYNC; then 0F. */
static void test_a_weaker_stop_of_the_same_tick_does_not_undo_a_stop(void) {
  static const uint16_t first[] = {0x02, 0x00};
  static const uint16_t second[] = {0x010F, 0x07};
  for (uint32_t row = 0; row < 8; ++row) {
    const bool synchronous = row >= 4;
    const uint16_t stop = first[row % 2];
    const uint16_t weaker = second[row / 2 % 2];
    turn_with_quick_stop_option(2);
    if (synchronous) {
      SET(0x1400, 2, 1);
    }
    burst(stop, NONE, NONE);
    give(RPDO1, synchronous ? 3 : 2, (const uint8_t[]){(uint8_t)weaker, (uint8_t)(weaker >> 8), PV});
    burst(0x0F, NONE, NONE);
    if (synchronous) {
      give(SYNC, 0, (const uint8_t[]){0});
    }
    wait_ms(STOPPED_MS);
    char text[48];
    (void)snprintf(text, sizeof text, "%04X, %04X, %s", stop, weaker, synchronous ? "replaced" : "too short");
    TEST_ASSERT_EQUAL_HEX32_MESSAGE(STATE_OFF, state_of(0), text);
  }
}

/* Rows: words for the words of a tick, 0x8000 with those whose frame is too short, and the state in which the axis
 * ends. */
static void test_a_stop_in_a_frame_that_is_too_short_has_its_place_in_the_order(void) {
  enum { SHORT = 0x8000 };
  static const struct {
    uint16_t option, word[4];
    uint32_t state;
  } rows[] = {
      {2, {0x06, SHORT | 0x86, NONE}, STATE_READY},
      {2, {0x07, SHORT | 0x87, NONE}, STATE_SWITCHED_ON},
      {5, {0x06, SHORT | 0x02, 0x0F, NONE}, STATE_OFF},     /* as one word 02 would be left by 0F */
      {2, {0x00, SHORT | 0x06, 0x0F, NONE}, STATE_ENABLED}, /* the sequence of CiA 402 */
      {2, {0x07, 0x87, NONE}, STATE_SWITCHED_ON},           /* no short one: bit 7 is no command */
      {2, {0x06, 0x8F, NONE}, STATE_READY},
  };
  for (uint32_t i = 0; i < sizeof rows / sizeof rows[0]; ++i) {
    turn_with_quick_stop_option(rows[i].option);
    for (uint32_t n = 0; n < 4 && rows[i].word[n] != NONE; ++n) {
      const uint16_t word = rows[i].word[n] & 0x7FFF;
      give(RPDO1, rows[i].word[n] > 0x7FFF ? 2 : 3, (const uint8_t[]){(uint8_t)word, (uint8_t)(word >> 8), PV});
    }
    wait_ms(STOPPED_MS);
    char row[16];
    (void)snprintf(row, sizeof row, "row %u", (unsigned)i);
    TEST_ASSERT_EQUAL_HEX32_MESSAGE(rows[i].state, state_of(0), row);
  }
}

/* 00, then 80 and 06 in frames that are too short: the edge of bit 7 is not lost. */
static void test_an_edge_of_bit_7_beside_a_stop_resets_the_fault(void) {
  end_in_fault_with(0x0F);
  burst(0x00, 0x80, NONE);
  give(RPDO1, 2, (const uint8_t[]){0x06, 0x00});
  wait_ms(10);
  TEST_ASSERT_NOT_EQUAL(STATE_IN_FAULT, state_of(0));
}

/* 60 frames in a tick: most are dropped. */
static void test_a_weaker_stop_in_a_dropped_frame_does_not_undo_a_stop(void) {
  for (uint32_t place = 0; place < 58; place += 3) {
    turn_with_quick_stop_option(2);
    for (uint32_t i = 0; i < 60; ++i) {
      const uint16_t word = i == place ? 0x02 : i == place + 1 ? 0x010F : i % 2 == 0 ? 0x0F : 0x1F;
      burst(word, NONE, NONE);
    }
    wait_ms(STOPPED_MS);
    char text[24];
    (void)snprintf(text, sizeof text, "place %u", (unsigned)place);
    TEST_ASSERT_EQUAL_HEX32_MESSAGE(STATE_OFF, state_of(0), text);
  }
}

/* Rows: the controlword before, those of one burst, and the state in which the axis ends. */
static void test_an_edge_of_bit_7_within_one_tick_resets_the_fault(void) {
  static const struct {
    uint16_t before, word[3];
    uint32_t state;
  } rows[] = {
      {0x0F, {0x00, 0x80, NONE}, STATE_OFF},      {0x0F, {0x80, 0x00, NONE}, STATE_OFF},
      {0x80, {0x80, 0x00, 0x80}, STATE_OFF},      {0x80, {0x00, 0x80, 0x00}, STATE_OFF},
      {0x80, {0x80, 0x80, NONE}, STATE_IN_FAULT}, {0x80, {0x80, 0x00, NONE}, STATE_IN_FAULT},
      {0x0F, {0x00, 0x0F, NONE}, STATE_IN_FAULT},
  };
  for (uint32_t i = 0; i < sizeof rows / sizeof rows[0]; ++i) {
    end_in_fault_with(rows[i].before);
    burst(rows[i].word[0], rows[i].word[1], rows[i].word[2]);
    wait_ms(10);
    char row[16];
    (void)snprintf(row, sizeof row, "row %u", (unsigned)i);
    TEST_ASSERT_EQUAL_HEX32_MESSAGE(rows[i].state, state_of(0), row);
  }
}

/* Rows: what arrives in one tick while the axis turns at 0.3 rad/s, and the state in which it ends. A stopped or
 * pre-operational node takes no RPDO. */
static void test_nmt_commands_and_controlwords_of_one_tick_count_in_their_order(void) {
  static const struct {
    uint16_t frame[4];
    uint32_t state;
  } rows[] = {
      {{STOP, START, NONE}, STATE_IN_FAULT},
      {{STOP, START, 0x0F, NONE}, STATE_IN_FAULT},
      {{STOP, START, 0x8F, 0x0F}, STATE_IN_FAULT},
      {{0x02, STOP, START, NONE}, STATE_IN_FAULT},
      {{STOP, 0x02, START, NONE}, STATE_IN_FAULT},
      {{0x00, STOP, START, 0x0F}, STATE_IN_FAULT},
      {{0x02, PRE_OPERATIONAL, NONE}, STATE_OFF},
      {{0x02, PRE_OPERATIONAL, START, 0x0F}, STATE_OFF},
      {{PRE_OPERATIONAL, START, 0x02, 0x0F}, STATE_OFF},
      {{0x02, 0x0F, PRE_OPERATIONAL, START}, STATE_OFF},
      {{PRE_OPERATIONAL, 0x02, START, NONE}, STATE_ENABLED},
  };
  for (uint32_t i = 0; i < sizeof rows / sizeof rows[0]; ++i) {
    turn_with_quick_stop_option(2);
    give_in_one_tick(rows[i].frame, 4);
    wait_ms(STOPPED_MS);
    char row[16];
    (void)snprintf(row, sizeof row, "row %u", (unsigned)i);
    TEST_ASSERT_EQUAL_HEX32_MESSAGE(rows[i].state, state_of(0), row);
    const bool goes_on = rows[i].state == STATE_ENABLED;
    CHECK_NEAR(row, goes_on ? 0.3 : 0.0, machine.axis[0].rate_rad_s, 0.003);
    if (rows[i].state == STATE_IN_FAULT) {
      TEST_ASSERT_EQUAL_MESSAGE(NODE_STOPPED, get(0x1003, 1) >> 16 & 0xFF, row);
    }
  }
}

/* RPDO1 takes effect with SYNC, and none comes before the node leaves operational: what waited is forgotten, but not
 * the stop in it. */
static void test_a_stop_that_waits_for_sync_survives_a_change_of_the_nmt_state(void) {
  static const uint16_t rows[][4] = {
      {0x02, PRE_OPERATIONAL, START, NONE},
      {0x02, PRE_OPERATIONAL, NONE},
      {0x02, PRE_OPERATIONAL, START, 0x0F},
      {0x0F, 0x02, PRE_OPERATIONAL, START},
  };
  for (uint32_t i = 0; i < sizeof rows / sizeof rows[0]; ++i) {
    turn_with_quick_stop_option(2);
    SET(0x1400, 1, 0x80000000u | RPDO1);
    SET(0x1400, 2, 1);
    SET(0x1400, 1, RPDO1);
    give_in_one_tick(rows[i], 4);
    wait_ms(5);
    give(SYNC, 0, (const uint8_t[]){0});
    wait_ms(STOPPED_MS);
    char row[16];
    (void)snprintf(row, sizeof row, "row %u", (unsigned)i);
    TEST_ASSERT_EQUAL_HEX32_MESSAGE(STATE_OFF, state_of(0), row);
    CHECK_NEAR(row, 0.0, machine.axis[0].rate_rad_s, 0.002);
  }
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_a_stop_is_not_undone_by_a_later_word_of_the_same_tick);
  RUN_TEST(test_enable_operation_after_a_quick_stop_that_stays_enables_again);
  RUN_TEST(test_halt_is_a_level);
  RUN_TEST(test_each_edge_of_bit_4_starts_a_move_with_its_own_target);
  RUN_TEST(test_a_stop_by_sdo_is_not_undone_by_an_rpdo);
  RUN_TEST(test_a_controlword_by_sdo_does_not_overtake_one_by_pdo);
  RUN_TEST(test_a_stop_behind_a_flood_of_commands_is_obeyed_within_40_ms);
  RUN_TEST(test_a_dropped_command_and_a_lost_frame_in_one_tick_are_an_overrun);
  RUN_TEST(test_a_weaker_stop_of_the_same_tick_does_not_undo_a_stop);
  RUN_TEST(test_a_stop_in_a_frame_that_is_too_short_has_its_place_in_the_order);
  RUN_TEST(test_an_edge_of_bit_7_beside_a_stop_resets_the_fault);
  RUN_TEST(test_a_weaker_stop_in_a_dropped_frame_does_not_undo_a_stop);
  RUN_TEST(test_an_edge_of_bit_7_within_one_tick_resets_the_fault);
  RUN_TEST(test_nmt_commands_and_controlwords_of_one_tick_count_in_their_order);
  RUN_TEST(test_a_stop_that_waits_for_sync_survives_a_change_of_the_nmt_state);
  return UNITY_END();
}
