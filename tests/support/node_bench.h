/* SPDX-License-Identifier: Apache-2.0 */
/* A bench for the whole servo node: a rigid machine behind it, frames in, frames out, and time.
 *
 * Sent frames go into a log. Include it once, in a test with Unity. */
#ifndef TRACKSERVO_TESTS_SUPPORT_NODE_BENCH_H
#define TRACKSERVO_TESTS_SUPPORT_NODE_BENCH_H

#include <string.h>

#include "rigid_machine.h"
#include "unity.h"

enum { NODE_ID = 5, NODE_LOG = 1024, PITCH = 0x800, SDO_SILENT = 1 };

/* Statusword without the bits that are not part of the state. */
enum {
  STATE_MASK = 0x6F,
  STATE_NOT_READY = 0x00,
  STATE_DISABLED = 0x40,
  STATE_READY = 0x21,
  STATE_SWITCHED_ON = 0x23,
  STATE_ENABLED = 0x27,
  STATE_QUICK_STOP = 0x07,
  STATE_FAULT = 0x08
};

static rigid_machine machine;
static servo_node node;
static can_frame sent[NODE_LOG];
static uint32_t sent_count;

static inline bool node_bench_send(void *context, const can_frame *frame) {
  (void)context;
  TEST_ASSERT_TRUE(frame->length <= CAN_FRAME_BYTES && frame->id <= 0x7FF);
  sent[sent_count++ % NODE_LOG] = *frame;
  return true;
}

/* --- time ------------------------------------------------------------------------------------------------------- */

static inline void wait_ms(uint32_t duration_ms) {
  for (uint32_t i = 0; i < duration_ms; ++i) {
    servo_node_tick(&node);
    servo_node_serve(&node);
    servo_node_background(&node);
    rigid_machine_turn(&machine, &node.board);
  }
}

/* Booted, pre-operational, at rest, log empty. */
static inline void node_bench_start(void) {
  rigid_machine_init(&machine);
  TEST_ASSERT_TRUE(rigid_machine_start_node(&machine, &node, NODE_ID, (can_sender){node_bench_send, NULL}, NULL));
  sent_count = 0;
  wait_ms(2);
}

/* --- frames ------------------------------------------------------------------------------------------------------ */

static inline void give(uint32_t id, uint8_t length, const uint8_t *bytes) {
  can_frame frame = {.id = id, .length = length};
  memcpy(frame.data, bytes, length);
  TEST_ASSERT_TRUE(servo_node_receive(&node, &frame));
}

static inline void nmt(uint8_t command) {
  give(0, 2, (const uint8_t[]){command, NODE_ID});
  wait_ms(1);
}

/* The last frame with this identifier since the log was emptied, or NULL. */
static inline const can_frame *last_sent(uint32_t id) {
  const can_frame *last = NULL;
  for (uint32_t i = sent_count > NODE_LOG ? sent_count - NODE_LOG : 0; i < sent_count; ++i) {
    last = sent[i % NODE_LOG].id == id ? &sent[i % NODE_LOG] : last;
  }
  return last;
}

static inline uint32_t u32_of(const uint8_t *bytes) {
  return (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 | (uint32_t)bytes[3] << 24;
}

/* --- objects, by SDO ---------------------------------------------------------------------------------------------- */

static inline const uint8_t *ask(const uint8_t request[8]) {
  sent_count = 0;
  give(0x600 + NODE_ID, 8, request);
  wait_ms(1);
  const can_frame *answer = last_sent(0x580 + NODE_ID);
  for (int ms = 0; ms < 200 && answer == NULL; ++ms) { /* 2070:1 waits for the check of the gains */
    wait_ms(1);
    answer = last_sent(0x580 + NODE_ID);
  }
  TEST_ASSERT_NOT_NULL_MESSAGE(answer, "the SDO server is silent");
  return answer->data;
}

/* With the size of the object; the abort code, or 0. */
static inline uint32_t set(uint32_t index, uint8_t sub, uint32_t value) {
  const uint8_t *answer = ask((const uint8_t[]){0x22, (uint8_t)index, (uint8_t)(index >> 8), sub, (uint8_t)value,
                                                (uint8_t)(value >> 8), (uint8_t)(value >> 16), (uint8_t)(value >> 24)});
  return answer[0] == 0x80 ? u32_of(&answer[4]) : 0;
}

static inline uint32_t set_float(uint32_t index, uint8_t sub, float value) {
  uint32_t bits;
  memcpy(&bits, &value, sizeof bits);
  return set(index, sub, bits);
}

static inline uint32_t get(uint32_t index, uint8_t sub) {
  const uint8_t *answer = ask((const uint8_t[]){0x40, (uint8_t)index, (uint8_t)(index >> 8), sub, 0, 0, 0, 0});
  TEST_ASSERT_EQUAL_HEX8_MESSAGE(0x43, answer[0] & 0xF3, "upload refused");
  return u32_of(&answer[4]);
}

static inline float get_float(uint32_t index, uint8_t sub) {
  const uint32_t bits = get(index, sub);
  float value;
  memcpy(&value, &bits, sizeof value);
  return value;
}

#define SET(index, sub, value) TEST_ASSERT_EQUAL_HEX32(0, set(index, sub, value))
#define SET_FLOAT(index, sub, value) TEST_ASSERT_EQUAL_HEX32(0, set_float(index, sub, value))

/* --- the drive; `shift`: 0 or PITCH ------------------------------------------------------------------------------ */

static inline uint32_t state_of(uint32_t shift) { return get(0x6041 + shift, 0) & STATE_MASK; }

/* A fault shows in the low bits only. */
static inline bool is_in_fault(uint32_t shift) { return (get(0x6041 + shift, 0) & 0x4F) == STATE_FAULT; }

static inline void command(uint32_t shift, uint16_t controlword) {
  SET(0x6040 + shift, 0, controlword);
  wait_ms(1);
}

static inline void enable(uint32_t shift, int8_t mode) {
  SET(0x6060 + shift, 0, (uint8_t)mode);
  command(shift, 0x06);
  command(shift, 0x07);
  command(shift, 0x0F);
  TEST_ASSERT_EQUAL_HEX32(STATE_ENABLED, state_of(shift));
}

#endif
