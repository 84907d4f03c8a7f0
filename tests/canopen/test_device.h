/* SPDX-License-Identifier: Apache-2.0 */
/* A CANopen device for the tests: every data type, both kinds of refusal, streams, and two little axes.
 *
 * Not part of any product. The unit tests drive it directly, canopen_test_node puts it on a bus for python-canopen,
 * and the fuzzer of the SDO server feeds it. */
#ifndef TRACKSERVO_TESTS_CANOPEN_TEST_DEVICE_H
#define TRACKSERVO_TESTS_CANOPEN_TEST_DEVICE_H

#include "canopen/canopen_node.h"

enum { TEST_DEVICE_STREAM = 40000, TEST_DEVICE_QUEUE = 128, TEST_DEVICE_AXES = 2 };

typedef struct {
  float kp;
  float ki;
  uint16_t controlword;
  uint16_t statusword;
  int8_t mode;
  int8_t mode_display;
  int32_t velocity;
  int32_t target_velocity;
} test_axis;

typedef struct {
  uint8_t boolean;
  int8_t i8;
  int16_t i16;
  int32_t i32;
  uint8_t u8;
  uint16_t u16;
  uint32_t u32;
  uint64_t u64;
  float f32;
  char text[16];
  uint32_t secret;
  uint8_t moody;   /* 13 is refused with 0800 0022, 66 with 0606 0000 */
  uint8_t slow;    /* done at the fourth call */
  uint8_t command; /* 13 is accepted and fails with 0800 0022, 66 is refused with 0606 0000 */
  uint16_t error;  /* written: this EMCY is raised; 0: the last one is cleared */
} test_values;

typedef struct {
  canopen_node node;
  can_frame process_data[TEST_DEVICE_QUEUE];
  can_frame services[TEST_DEVICE_QUEUE];
  test_values values;
  test_axis axis[TEST_DEVICE_AXES];
  uint8_t stream[TEST_DEVICE_STREAM]; /* 2F01, also read by 2F02 */
  uint32_t stream_size;
  uint8_t staged[TEST_DEVICE_STREAM]; /* being written, taken over when complete */
  uint8_t calls;                      /* number of calls of the slow one */
  uint32_t commands;                  /* number of commands that were executed  */
  uint32_t carried_out;               /* ... and stored */
  uint16_t raised;
  uint32_t saves;
  uint32_t loads;
  bool store_broken;
  bool busy;          /* another controlword must wait for the one before it */
  bool stream_broken; /* no byte of it can be read or written */
  uint32_t heartbeats_lost;
  uint32_t resets;
  uint32_t streams_open;
} test_device;

extern const od_table test_device_identity; /* 1000, 1008 to 100A, 1018 and the PDOs */

/* Everything at its defaults; frames leave through `sender`. */
bool test_device_init(test_device *device, uint8_t node_id, can_sender sender);

/* One ms of the node, and of the axes: the statusword echoes the controlword, the speed its target. */
void test_device_tick(test_device *device);

#endif
