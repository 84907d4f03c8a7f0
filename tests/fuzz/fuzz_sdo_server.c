/* SPDX-License-Identifier: Apache-2.0 */
/* libFuzzer harness of the SDO server: any requests in any order, over objects of every type, two streams, values that
 * are refused and one that is taken late.
 *
 * Input: for each step a control byte. Bit 7: time passes, 16 ms times the other bits. Otherwise 8 bytes of a request
 * follow; bit 6: its multiplexer is the number of an object instead; bits 0 to 3: number of answers sent after it. */
#include <string.h>

#include "canopen/test_device.h"
#include "input_bytes.h"
#include "require.h"

int LLVMFuzzerInitialize(int *argc, char ***argv);
int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size);

enum { MAX_MS = 2000 }; /* of an input, so that there are many inputs */

static test_device device;
static canopen_node fresh_node;
static test_values fresh_values;

static bool no_frame(void *context, const can_frame *frame) {
  (void)context;
  (void)frame;
  return true;
}

/* An answer of the server must follow the standard, and stay until it is sent. */
static void send_answers(uint32_t most) {
  for (uint32_t i = 0; i < most; ++i) {
    const uint8_t *answer = sdo_server_outgoing(&device.node.sdo[0]);
    if (answer == NULL) {
      return;
    }
    uint8_t copy[SDO_BYTES];
    memcpy(copy, answer, SDO_BYTES);
    const uint8_t *again = sdo_server_outgoing(&device.node.sdo[0]);
    require(again != NULL && memcmp(again, copy, SDO_BYTES) == 0);
    sdo_server_sent(&device.node.sdo[0]);
  }
}

static void request(uint8_t control, input_bytes *input) {
  uint8_t bytes[SDO_BYTES];
  for (uint32_t i = 0; i < SDO_BYTES; ++i) {
    bytes[i] = input_u8(input);
  }
  if ((control & 0x40) != 0) {
    const od_object object = nth_object(&device.node.dictionary, (uint32_t)(bytes[1] | bytes[2] << 8));
    const uint16_t index = od_index(&object);
    bytes[1] = (uint8_t)index;
    bytes[2] = (uint8_t)(index >> 8);
    bytes[3] = object.entry->sub;
  }
  sdo_server_receive(&device.node.sdo[0], bytes);
  send_answers(control & 0x0Fu);
}

int LLVMFuzzerInitialize(int *argc, char ***argv) {
  (void)argc;
  (void)argv;
  require(test_device_init(&device, 5, (can_sender){no_frame, NULL}));
  fresh_node = device.node;
  fresh_values = device.values;
  for (uint32_t i = 0; i < TEST_DEVICE_STREAM; ++i) {
    device.stream[i] = (uint8_t)(i * 7u);
  }
  return 0;
}

int LLVMFuzzerTestOneInput(const uint8_t *data, size_t size) {
  memcpy(&device.node, &fresh_node, sizeof fresh_node);
  device.values = fresh_values;
  device.stream_size = 300;
  device.streams_open = 0;
  device.calls = 0;
  input_bytes input = {data, size};
  uint32_t left_ms = MAX_MS;
  while (!input_is_empty(&input)) {
    const uint8_t control = input_u8(&input);
    if ((control & 0x80) == 0) {
      request(control, &input);
    }
    for (uint32_t i = 0; i < ((control & 0x80) != 0 ? (control & 0x7Fu) * 16u : 0u) && left_ms > 0; ++i) {
      sdo_server_tick(&device.node.sdo[0]);
      left_ms--;
    }
    require(device.streams_open <= 1 && device.stream_size <= TEST_DEVICE_STREAM);
  }
  for (uint32_t i = 0; i < 2 * SDO_TIME_OUT_MS && device.node.sdo[0].state != SDO_IDLE; ++i) {
    send_answers(1);
    sdo_server_tick(&device.node.sdo[0]);
  }
  require(device.node.sdo[0].state == SDO_IDLE); /* every started transfer ends, at the latest by its time-out */
  require_values_within_limits(&device.node.dictionary);
  return 0;
}
