/* SPDX-License-Identifier: Apache-2.0 */
/* The SDO server over all short conversations: whatever a client sends, in whatever order, the server answers as the
 * standard allows, keeps its transfers in order, and changes no other object.
 *
 * Bound: all pairs of first bytes (65,536) on each of five objects, and all conversations of five requests out of
 * sixteen (1,048,576) on a stream and on a text. An emulated machine runs a share of them (random_cases). */
#include <stdio.h>
#include <string.h>

#include "canopen/test_device.h"
#include "support/random.h"
#include "unity.h"

enum { STREAM_BYTES = 9, REQUESTS = 5, WORDS = 16 };

static test_device device;
static canopen_node fresh_node;
static test_values fresh_values;
static uint32_t wrong;

#define SERVER (&device.node.sdo[0])

/* Cheaper than an assertion of Unity, of which there are millions. */
static void expect(bool good) { wrong += good ? 0 : 1; }

static bool no_frame(void *context, const can_frame *frame) {
  (void)context;
  (void)frame;
  return true;
}

void setUp(void) {
  TEST_ASSERT_TRUE(test_device_init(&device, 5, (can_sender){no_frame, NULL}));
  fresh_node = device.node;
  fresh_values = device.values;
  wrong = 0;
}

void tearDown(void) {}

static void start_over(void) {
  memcpy(&device.node, &fresh_node, sizeof fresh_node);
  device.values = fresh_values;
  device.stream_size = STREAM_BYTES;
  device.streams_open = 0;
  device.calls = 0;
}

/* First bytes of the server's answers, CiA 301 clause 7.2.4.3, by their fixed bits. */
static bool is_an_answer(const uint8_t *bytes) {
  const uint8_t specifier = bytes[0] >> 5;
  switch (specifier) {
    case 0: /* upload segment; within a block upload, a segment */
    case 1: /* download segment */
    case 2: /* upload */
    case 3: /* download */
    case 5: /* block download */
    case 6: /* block upload */
      return true;
    case 4: /* abort, with a code; or the last segment of a block upload */
      return bytes[0] != 0x80 || (bytes[7] >= 0x05 && bytes[7] <= 0x08);
    default:
      return false;
  }
}

static bool is_open_as_its_state_says(void) {
  const bool needs = SERVER->state != SDO_IDLE;
  const bool stream = SERVER->transfer.open && SERVER->transfer.object.entry->type == OD_DOMAIN;
  return SERVER->transfer.open == needs && device.streams_open == (stream ? 1u : 0u);
}

static void say(const uint8_t request[SDO_BYTES]) {
  const bool held = SERVER->request_held; /* a waiting client gets an answer */
  sdo_server_receive(SERVER, request);
  expect(is_open_as_its_state_says());
  expect(request[0] != 0x80 || SERVER->state == SDO_BLOCK_DOWNLOADING || held || !SERVER->reply_waiting);
  for (uint32_t i = 0; i < 3; ++i) {
    const uint8_t *answer = sdo_server_outgoing(SERVER);
    if (answer == NULL) {
      break;
    }
    expect(is_an_answer(answer));
    expect(answer[0] != 0x80 || SERVER->state == SDO_IDLE);
    sdo_server_sent(SERVER);
  }
  expect(is_open_as_its_state_says());
}

/* All except the addressed value, which may have changed within its limits. */
static void expect_only_changed(uint16_t index, uint8_t sub) {
  test_values values = device.values;
  if (index == 0x2F00 && sub == 7) {
    values.u32 = fresh_values.u32;
  } else if (index == 0x2F00 && sub == 10) {
    memcpy(values.text, fresh_values.text, sizeof values.text);
  } else if (index == 0x2F00 && sub == 5) {
    expect(values.u8 >= 10 && values.u8 <= 200);
    values.u8 = fresh_values.u8;
  } else if (index == 0x2F11) {
    values.slow = fresh_values.slow;
  }
  expect(memcmp(&values, &fresh_values, sizeof values) == 0);
  expect(memcmp(&device.node.objects, &fresh_node.objects, sizeof fresh_node.objects) == 0);
}

static void end_by_time_out(void) {
  for (uint32_t ms = 0; ms <= SDO_TIME_OUT_MS && SERVER->state != SDO_IDLE; ++ms) {
    if (SERVER->state == SDO_BLOCK_UPLOADING) { /* nobody takes the segments */
      SERVER->silent_ms++;
    }
    sdo_server_tick(SERVER);
  }
  expect(SERVER->state == SDO_IDLE && !SERVER->transfer.open && device.streams_open == 0);
}

static void test_all_pairs_of_first_bytes_on_every_kind_of_object(void) {
  static const struct {
    uint16_t index;
    uint8_t sub;
  } objects[] = {{0x2F00, 7}, {0x2F00, 5}, {0x2F00, 10}, {0x2F01, 0}, {0x2F11, 0}};
  const uint32_t pairs = (uint32_t)random_cases(65536);
  for (uint32_t o = 0; o < sizeof objects / sizeof objects[0]; ++o) {
    for (uint32_t n = 0; n < pairs; ++n) {
      uint8_t request[SDO_BYTES] = {0, (uint8_t)objects[o].index, (uint8_t)(objects[o].index >> 8), objects[o].sub, 2};
      start_over();
      request[0] = (uint8_t)(n >> 8);
      say(request);
      request[0] = (uint8_t)n;
      say(request);
      expect_only_changed(objects[o].index, objects[o].sub);
      if (n % 16 == 0) {
        end_by_time_out();
      }
    }
  }
  printf("pairs of first bytes: %u conversations, %u wrong\n", (unsigned)(5 * pairs), (unsigned)wrong);
  TEST_ASSERT_EQUAL(0, wrong);
}

/* Every request of the protocol: initiates, segments with both toggles, last and not, block segments 1, 2 and the last
 * one, ends, confirmations of nothing, one and two segments, starts, an abort. */
static const uint8_t words[WORDS][2] = {{0x21, 9}, {0x20, 0}, {0x00, 1},    {0x10, 1}, {0x0B, 1}, {0x1B, 1},
                                        {0x40, 0}, {0x60, 0}, {0x70, 0},    {0xC2, 9}, {0x81, 1}, {0xD5, 0},
                                        {0xA0, 2}, {0xA3, 0}, {0xA2, 0x02}, {0x80, 0}};

static void converse(uint16_t index, uint8_t sub) {
  const uint32_t conversations = (uint32_t)random_cases(1048576);
  for (uint32_t n = 0; n < conversations; ++n) {
    start_over();
    for (uint32_t i = 0; i < REQUESTS; ++i) {
      const uint8_t *word = words[n >> (4 * i) & 15u];
      const bool initiates =
          word[0] == 0x21 || word[0] == 0x20 || word[0] == 0x40 || word[0] == 0xC2 || word[0] == 0xA0;
      uint8_t request[SDO_BYTES] = {word[0], word[1], 2, 'a', 'b', 'c', 'd', 'e'};
      if (initiates) {
        const uint8_t multiplexed[SDO_BYTES] = {word[0], (uint8_t)index, (uint8_t)(index >> 8), sub, word[1]};
        memcpy(request, multiplexed, sizeof request);
      }
      say(request);
    }
    expect_only_changed(index, sub);
    expect(device.stream_size <= TEST_DEVICE_STREAM);
  }
  printf("conversations of %d requests on %04X: %u, %u wrong\n", REQUESTS, index, (unsigned)conversations,
         (unsigned)wrong);
}

static void test_all_conversations_of_five_requests(void) {
  converse(0x2F01, 0);
  converse(0x2F00, 10);
  TEST_ASSERT_EQUAL(0, wrong);
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_all_pairs_of_first_bytes_on_every_kind_of_object);
  RUN_TEST(test_all_conversations_of_five_requests);
  return UNITY_END();
}
