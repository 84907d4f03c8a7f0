/* SPDX-License-Identifier: Apache-2.0 */
/* A bench for one test device: frames in, frames out, and time.
 *
 * Sent frames go into a log; with `bus_full` the bus refuses them. Include it once, in a test with Unity. */
#ifndef TRACKSERVO_TESTS_CANOPEN_BENCH_H
#define TRACKSERVO_TESTS_CANOPEN_BENCH_H

#include <string.h>

#include "canopen/test_device.h"
#include "unity.h"

enum { BENCH_LOG = 8192, BENCH_NODE = 5 };

typedef struct {
  test_device device;
  can_frame log[BENCH_LOG];
  uint32_t sent;
  uint32_t refused; /* frames offered while the bus was full */
  bool bus_full;
  uint32_t room; /* frames that still fit */
} bench_state;

static bench_state bench;

static inline bool bench_send(void *context, const can_frame *frame) {
  (void)context;
  if (bench.bus_full || bench.room == 0) {
    bench.refused++;
    return false;
  }
  TEST_ASSERT_TRUE(frame->length <= CAN_FRAME_BYTES);
  bench.log[bench.sent % BENCH_LOG] = *frame;
  bench.sent++;
  bench.room--;
  return true;
}

static inline void bench_wait_ms(uint32_t duration_ms) {
  for (uint32_t i = 0; i < duration_ms; i++) {
    test_device_tick(&bench.device);
  }
}

/* A device that has booted and is pre-operational, heartbeat off, log empty. */
static inline void bench_start(void) {
  memset(&bench, 0, sizeof bench);
  bench.room = UINT32_MAX;
  const can_sender sender = {bench_send, NULL};
  TEST_ASSERT_TRUE(test_device_init(&bench.device, BENCH_NODE, sender));
  bench_wait_ms(1);
  bench.device.node.objects.heartbeat_producer_ms = 0;
  bench.sent = 0;
}

static inline void bench_give(uint32_t id, uint8_t length, const uint8_t *bytes) {
  can_frame frame = {.id = id, .length = length};
  if (length > 0) {
    memcpy(frame.data, bytes, length <= CAN_FRAME_BYTES ? length : CAN_FRAME_BYTES);
  }
  (void)canopen_node_receive(&bench.device.node, &frame);
}

static inline void bench_nmt(uint8_t command, uint8_t node) {
  const uint8_t bytes[2] = {command, node};
  bench_give(0, 2, bytes);
  bench_wait_ms(1);
}

static inline void bench_operational(void) {
  bench_nmt(1, BENCH_NODE);
  TEST_ASSERT_EQUAL(NMT_OPERATIONAL, bench.device.node.state);
}

/* Frames in the log with this identifier. */
static inline uint32_t bench_count(uint32_t id) {
  uint32_t count = 0;
  for (uint32_t i = 0; i < bench.sent && i < BENCH_LOG; i++) {
    count += bench.log[i].id == id ? 1u : 0u;
  }
  return count;
}

static inline const can_frame *bench_last(uint32_t id) {
  const can_frame *last = NULL;
  for (uint32_t i = 0; i < bench.sent && i < BENCH_LOG; i++) {
    last = bench.log[i].id == id ? &bench.log[i] : last;
  }
  TEST_ASSERT_NOT_NULL_MESSAGE(last, "no such frame was sent");
  return last;
}

/* Request and answer of the SDO server; the answer is all zeros when there was none. */
static inline void bench_sdo(const uint8_t request[8], uint8_t answer[8]) {
  bench.sent = 0;
  bench_give(0x600 + BENCH_NODE, 8, request);
  bench_wait_ms(1);
  memset(answer, 0, 8);
  if (bench_count(0x580 + BENCH_NODE) > 0) {
    memcpy(answer, bench_last(0x580 + BENCH_NODE)->data, 8);
  }
}

static inline uint32_t bench_u32(const uint8_t *bytes) {
  return (uint32_t)bytes[0] | (uint32_t)bytes[1] << 8 | (uint32_t)bytes[2] << 16 | (uint32_t)bytes[3] << 24;
}

/* Expedited download of 1 to 4 bytes; the abort code, or 0. */
static inline uint32_t bench_write(uint16_t index, uint8_t sub, uint32_t value, uint8_t length) {
  uint8_t request[8] = {(uint8_t)(0x23 | (4 - length) << 2), (uint8_t)index, (uint8_t)(index >> 8), sub};
  uint8_t answer[8];
  for (uint32_t i = 0; i < length; i++) {
    request[4 + i] = (uint8_t)(value >> (8 * i));
  }
  bench_sdo(request, answer);
  if (answer[0] == 0x80) {
    return bench_u32(&answer[4]);
  }
  TEST_ASSERT_EQUAL_HEX8(0x60, answer[0]);
  return 0;
}

/* Expedited upload; the value, with the abort code (or 0) in `abort`. */
static inline uint32_t bench_read(uint16_t index, uint8_t sub, uint32_t *abort) {
  const uint8_t request[8] = {0x40, (uint8_t)index, (uint8_t)(index >> 8), sub};
  uint8_t answer[8];
  bench_sdo(request, answer);
  *abort = answer[0] == 0x80 ? bench_u32(&answer[4]) : 0;
  return bench_u32(&answer[4]);
}

static inline uint32_t bench_get(uint16_t index, uint8_t sub) {
  uint32_t abort = 0;
  const uint32_t value = bench_read(index, sub, &abort);
  TEST_ASSERT_EQUAL_HEX32(0, abort);
  return value;
}

static inline uint32_t bench_bits(float value) {
  uint32_t bits;
  memcpy(&bits, &value, sizeof bits);
  return bits;
}

#endif
