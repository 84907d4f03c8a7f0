/* SPDX-License-Identifier: Apache-2.0 */
#include "canopen/bench.h"
#include "canopen/crc_xmodem.h"
#include "canopen/sdo_protocol.h"

void setUp(void) { bench_start(); }
void tearDown(void) {}

#define SERVER (&bench.device.node.sdo[0])

static uint32_t abort_of(const uint8_t *answer) { return answer[0] == 0x80 ? bench_u32(&answer[4]) : 0; }

static void test_crc_has_its_check_value(void) {
  TEST_ASSERT_EQUAL_HEX16(0x31C3, crc_xmodem(0, (const uint8_t *)"123456789", 9));
  TEST_ASSERT_EQUAL_HEX16(0x31C3, crc_xmodem(crc_xmodem(0, (const uint8_t *)"1234", 4), (const uint8_t *)"56789", 5));
}

static void test_expedited_write_is_read_back(void) {
  TEST_ASSERT_EQUAL_HEX32(0, bench_write(0x2F00, 7, 0x12345678, 4));
  TEST_ASSERT_EQUAL_HEX32(0x12345678, bench.device.values.u32);
  TEST_ASSERT_EQUAL_HEX32(0x12345678, bench_get(0x2F00, 7));
  TEST_ASSERT_EQUAL_HEX32(0, bench_write(0x2F00, 5, 77, 1));
  TEST_ASSERT_EQUAL(77, bench_get(0x2F00, 5));
}

static void test_each_refusal_has_its_abort_code_and_changes_nothing(void) {
  static const struct {
    uint16_t index;
    uint8_t sub;
    uint8_t length;
    uint32_t value;
    uint32_t abort;
  } rows[] = {
      {0x2FFF, 0, 1, 0, 0x06020000},          {0x2F00, 99, 1, 0, 0x06090011},
      {0x2F00, 12, 2, 0, 0x06010002},         {0x1000, 0, 4, 0, 0x06010002},
      {0x2F02, 0, 1, 0, 0x06010002},          {0x2F00, 7, 2, 0, 0x06070013},
      {0x2F00, 6, 4, 0, 0x06070012},          {0x2F00, 5, 1, 201, 0x06090031},
      {0x2F00, 5, 1, 9, 0x06090032},          {0x2F00, 1, 1, 2, 0x06090031},
      {0x2F00, 9, 4, 0x7FC00000, 0x06090030}, {0x2F00, 9, 4, 0x7F800000, 0x06090031},
      {0x2F00, 9, 4, 0xFF800000, 0x06090032}, {0x2F10, 0, 1, 13, 0x08000022},
      {0x2F10, 0, 1, 66, 0x06060000},         {0x1010, 1, 4, 0, 0x08000020},
      {0x1011, 1, 4, 0x65766173, 0x08000020}, {0x1003, 0, 1, 1, 0x06090030},
      {0x1005, 0, 4, 0x40000080, 0x06090030}, {0x1014, 0, 4, 0x20000085, 0x06090030},
      {0x1019, 0, 1, 1, 0x06090030},          {0x1014, 0, 4, 0x86, 0x08000022},
      {0x1400, 1, 4, 0x00000581, 0x06090030}, {0x1400, 1, 4, 0x204, 0x08000022},
      {0x1400, 2, 1, 252, 0x06090030},        {0x1600, 0, 1, 0, 0x08000022},
      {0x1800, 3, 2, 50, 0x08000022},         {0x1800, 6, 1, 4, 0x08000022},
  };
  for (uint32_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
    const communication_objects objects = bench.device.node.objects;
    const test_values values = bench.device.values;
    TEST_ASSERT_EQUAL_HEX32(rows[i].abort, bench_write(rows[i].index, rows[i].sub, rows[i].value, rows[i].length));
    TEST_ASSERT_EQUAL_MEMORY(&objects, &bench.device.node.objects, sizeof objects);
    TEST_ASSERT_EQUAL_MEMORY(&values, &bench.device.values, sizeof values);
  }
  uint32_t abort = 0;
  (void)bench_read(0x2F00, 11, &abort);
  TEST_ASSERT_EQUAL_HEX32(0x06010001, abort);
  (void)bench_read(0x1003, 1, &abort);
  TEST_ASSERT_EQUAL_HEX32(0x08000024, abort);
}

static void test_expedited_write_without_a_length_takes_that_of_the_type(void) {
  const uint8_t request[8] = {0x22, 0x00, 0x2F, 6, 0x34, 0x12, 0x99, 0x99};
  uint8_t answer[8];
  bench_sdo(request, answer);
  TEST_ASSERT_EQUAL_HEX8(0x60, answer[0]);
  TEST_ASSERT_EQUAL_HEX16(0x1234, bench.device.values.u16);
}

static void test_segmented_upload_brings_a_text(void) {
  const uint8_t start[8] = {0x40, 0x00, 0x2F, 10};
  const uint8_t first[8] = {0x60};
  const uint8_t second[8] = {0x70};
  uint8_t answer[8];
  bench_sdo(start, answer);
  TEST_ASSERT_EQUAL_HEX8(0x41, answer[0]);
  TEST_ASSERT_EQUAL(11, bench_u32(&answer[4]));
  bench_sdo(first, answer);
  TEST_ASSERT_EQUAL_HEX8(0x00, answer[0]);
  TEST_ASSERT_EQUAL_MEMORY("hello w", &answer[1], 7);
  bench_sdo(second, answer);
  TEST_ASSERT_EQUAL_HEX8(0x10 | 3 << 1 | 1, answer[0]);
  TEST_ASSERT_EQUAL_MEMORY("orld", &answer[1], 4);
  TEST_ASSERT_EQUAL(SDO_IDLE, SERVER->state);
}

/* 30 bytes: four segments of 7, and one of 2. */
static void test_each_segment_of_an_upload_goes_on_where_the_last_one_ended(void) {
  const uint8_t start[8] = {0x40, 0x02, 0x2F, 0};
  uint8_t answer[8];
  for (uint8_t i = 0; i < 30; i++) {
    bench.device.stream[i] = (uint8_t)(100 + i);
  }
  bench.device.stream_size = 30;
  bench_sdo(start, answer);
  TEST_ASSERT_EQUAL(30, bench_u32(&answer[4]));
  for (uint8_t n = 0; n < 5; n++) {
    const uint8_t toggle = n % 2 == 0 ? 0x00 : 0x10;
    const uint8_t segment[8] = {(uint8_t)(0x60 | toggle)};
    bench_sdo(segment, answer);
    TEST_ASSERT_EQUAL_HEX8(toggle | (n == 4 ? 5 << 1 | 1 : 0), answer[0]);
    TEST_ASSERT_EQUAL_MEMORY(&bench.device.stream[7 * n], &answer[1], n == 4 ? 2 : 7);
  }
  TEST_ASSERT_EQUAL(0, bench.device.streams_open);
}

/* The toggle bit alternates within a transfer, and each one begins with 0: also after a transfer of one segment. */
static void test_each_transfer_begins_with_toggle_0(void) {
  const uint8_t start[8] = {0x21, 0x00, 0x2F, 6, 2};
  const uint8_t only_segment[8] = {0x0B, 0x34, 0x12};
  uint8_t answer[8];
  for (int transfer = 0; transfer < 3; transfer++) {
    bench_sdo(start, answer);
    TEST_ASSERT_EQUAL_HEX8(0x60, answer[0]);
    bench_sdo(only_segment, answer);
    TEST_ASSERT_EQUAL_HEX8(0x20, answer[0]);
  }
  TEST_ASSERT_EQUAL_HEX16(0x1234, bench.device.values.u16);
}

static void test_segment_with_the_wrong_toggle_is_refused(void) {
  const uint8_t upload[8] = {0x40, 0x00, 0x2F, 10};
  const uint8_t download[8] = {0x21, 0x00, 0x2F, 8, 8};
  const uint8_t upload_segment[8] = {0x70};
  const uint8_t download_segment[8] = {0x10};
  uint8_t answer[8];
  bench_sdo(upload, answer);
  bench_sdo(upload_segment, answer);
  TEST_ASSERT_EQUAL_HEX32(0x05030000, abort_of(answer));
  bench_sdo(download, answer); /* the segment could have come from another client: this one waits */
  TEST_ASSERT_EQUAL_HEX8(0, answer[0]);
  bench_wait_ms(SDO_QUIET_MS);
  TEST_ASSERT_EQUAL_HEX8(0x60, bench_last(0x585)->data[0]);
  bench_sdo(download_segment, answer);
  TEST_ASSERT_EQUAL_HEX32(0x05030000, abort_of(answer));
  TEST_ASSERT_EQUAL_HEX8(0x00, answer[1]);
  TEST_ASSERT_EQUAL_HEX8(0x2F, answer[2]);
  TEST_ASSERT_EQUAL_HEX8(8, answer[3]);
}

static void test_segmented_download_must_bring_what_it_announced(void) {
  const uint8_t start[8] = {0x21, 0x00, 0x2F, 8, 8};
  const uint8_t all[8] = {0x01, 1, 2, 3, 4, 5, 6, 7};
  const uint8_t wrong_size[8] = {0x21, 0x00, 0x2F, 8, 9};
  const uint8_t too_few[8] = {0x21, 0x00, 0x2F, 8, 7};
  uint8_t answer[8];
  bench_sdo(start, answer);
  TEST_ASSERT_EQUAL_HEX8(0x60, answer[0]);
  bench_sdo(all, answer);
  TEST_ASSERT_EQUAL_HEX32(0x06070013, abort_of(answer));
  TEST_ASSERT_EQUAL_HEX64(0x0123456789ABCDEF, bench.device.values.u64);
  bench_sdo(wrong_size, answer);
  TEST_ASSERT_EQUAL_HEX32(0x06070012, abort_of(answer));
  bench_wait_ms(SDO_QUIET_MS);
  bench_sdo(too_few, answer);
  TEST_ASSERT_EQUAL_HEX32(0x06070013, abort_of(answer));
}

/* A text of 2 letters into the room of 16. */
static void test_a_text_may_be_shorter_than_its_room(void) {
  const uint8_t start[8] = {0x21, 0x00, 0x2F, 10, 2};
  const uint8_t letters[8] = {0x0B, 'h', 'i'};
  uint8_t answer[8];
  bench_sdo(start, answer);
  TEST_ASSERT_EQUAL_HEX8(0x60, answer[0]);
  bench_sdo(letters, answer);
  TEST_ASSERT_EQUAL_HEX8(0x20, answer[0]);
  TEST_ASSERT_EQUAL_STRING("hi", bench.device.values.text);
}

static void test_a_download_announced_with_the_largest_size_is_refused_at_once(void) {
  const uint8_t segmented[8] = {0x21, 0x00, 0x2F, 8, 0xFF, 0xFF, 0xFF, 0xFF};
  const uint8_t by_block[8] = {0xC2, 0x00, 0x2F, 8, 0xFF, 0xFF, 0xFF, 0xFF};
  const uint8_t without_size[8] = {0x20, 0x00, 0x2F, 8, 0xFF, 0xFF, 0xFF, 0xFF};
  uint8_t answer[8];
  bench_sdo(segmented, answer);
  TEST_ASSERT_EQUAL_HEX32(0x06070012, abort_of(answer));
  bench_wait_ms(SDO_QUIET_MS);
  bench_sdo(by_block, answer);
  TEST_ASSERT_EQUAL_HEX32(0x06070012, abort_of(answer));
  bench_wait_ms(SDO_QUIET_MS);
  bench_sdo(without_size, answer);
  TEST_ASSERT_EQUAL_HEX8(0x60, answer[0]);
}

/* The text has a room of 16 bytes, the server one of 64. Nothing beyond either is written, whatever was announced. */
static void test_a_segment_beyond_the_room_is_refused_and_changes_nothing(void) {
  static const struct {
    uint8_t start[8];
    uint32_t good; /* segments of 7 bytes that still fit */
  } rows[] = {{{0x20, 0x00, 0x2F, 10}, 9}, {{0x21, 0x00, 0x2F, 10, 8}, 1}, {{0x21, 0x01, 0x2F, 0, 20}, 2}};
  for (uint32_t row = 0; row < sizeof rows / sizeof rows[0]; row++) {
    uint8_t answer[8];
    bench_sdo(rows[row].start, answer);
    TEST_ASSERT_EQUAL_HEX8(0x60, answer[0]);
    for (uint32_t n = 0; n <= rows[row].good; n++) {
      const uint8_t segment[8] = {n % 2 == 0 ? 0x00 : 0x10, 1, 2, 3, 4, 5, 6, 7};
      bench_sdo(segment, answer);
      TEST_ASSERT_EQUAL_HEX32(n < rows[row].good ? 0 : 0x06070012, abort_of(answer));
    }
    TEST_ASSERT_EQUAL(SDO_IDLE, SERVER->state);
    TEST_ASSERT_EQUAL_STRING("hello world", bench.device.values.text);
    TEST_ASSERT_EQUAL(0, bench.device.streams_open);
  }
}

static void test_silent_client_is_timed_out_and_reported(void) {
  const uint8_t start[8] = {0x21, 0x01, 0x2F, 0, 100};
  uint8_t answer[8];
  bench_sdo(start, answer);
  TEST_ASSERT_EQUAL(1, bench.device.streams_open);
  bench_wait_ms(SDO_TIME_OUT_MS - 2);
  TEST_ASSERT_EQUAL(SDO_DOWNLOADING, SERVER->state);
  bench_wait_ms(3);
  TEST_ASSERT_EQUAL(SDO_IDLE, SERVER->state);
  TEST_ASSERT_EQUAL_HEX32(0x05040000, abort_of(bench_last(0x585)->data));
  TEST_ASSERT_EQUAL(0, bench.device.streams_open);
}

static void test_new_request_replaces_a_transfer_that_was_left(void) {
  const uint8_t start[8] = {0x21, 0x01, 0x2F, 0, 100};
  uint8_t answer[8];
  bench_sdo(start, answer);
  TEST_ASSERT_EQUAL_HEX32(0x1234, bench_get(0x2F00, 12) & 0xFFFFu);
  TEST_ASSERT_EQUAL(0, bench.device.streams_open);
}

/* --- Two clients on one channel
 * ------------------------------------------------------------------------------------ */

static const uint8_t upload_text[8] = {0x40, 0x00, 0x2F, 10};
static const uint8_t upload_u64[8] = {0x40, 0x00, 0x2F, 8};
static const uint8_t upload_segment[8] = {0x60};

static void test_a_second_clients_transfer_waits_until_the_first_cannot_go_on(void) {
  uint8_t answer[8];
  bench_sdo(upload_text, answer);
  TEST_ASSERT_EQUAL_HEX8(0x41, answer[0]);
  bench_sdo(upload_u64, answer);
  TEST_ASSERT_EQUAL_HEX8(0, answer[0]);
  bench_wait_ms(SDO_QUIET_MS - 2);
  TEST_ASSERT_EQUAL(0, bench_count(0x585));
  bench_wait_ms(3); /* the first has disconnected */
  TEST_ASSERT_EQUAL_HEX8(0x41, bench_last(0x585)->data[0]);
  TEST_ASSERT_EQUAL_HEX8(8, bench_last(0x585)->data[3]);
}

static void test_a_first_client_that_goes_on_ends_both_transfers(void) {
  uint8_t answer[8];
  bench_sdo(upload_text, answer);
  bench_sdo(upload_u64, answer);
  bench_sdo(upload_segment, answer);
  TEST_ASSERT_EQUAL_HEX32(0x05040001, abort_of(answer));
  bench_wait_ms(3 * SDO_QUIET_MS);
  TEST_ASSERT_EQUAL(1, bench_count(0x585));
  bench_sdo(upload_text, answer);
  TEST_ASSERT_EQUAL_HEX8(0x41, answer[0]);
}

static void test_two_clients_that_wait_are_both_refused(void) {
  uint8_t answer[8];
  bench_sdo(upload_text, answer);
  bench_sdo(upload_u64, answer);
  bench_sdo(upload_text, answer);
  TEST_ASSERT_EQUAL_HEX32(0x08000020, abort_of(answer));
  TEST_ASSERT_EQUAL_HEX8(10, answer[3]);
  bench_wait_ms(3 * SDO_QUIET_MS);
  TEST_ASSERT_EQUAL(1, bench_count(0x585));
}

static void test_an_expedited_request_never_waits(void) {
  uint8_t answer[8];
  bench_sdo(upload_text, answer);
  TEST_ASSERT_EQUAL_HEX32(0, bench_write(0x2F00, 7, 4711, 4));
  TEST_ASSERT_EQUAL_HEX32(4711, bench_get(0x2F00, 7));
  bench_sdo(upload_segment, answer); /* of the transfer that this one ended */
  TEST_ASSERT_EQUAL_HEX32(0x05040001, abort_of(answer));
}

static void test_an_abort_of_another_client_makes_the_next_transfer_wait(void) {
  const uint8_t without_object[8] = {0x80};
  const uint8_t own[8] = {0x80, 0x00, 0x2F, 10};
  uint8_t answer[8];
  bench_sdo(upload_text, answer);
  bench_sdo(own, answer);
  bench_sdo(upload_text, answer);
  TEST_ASSERT_EQUAL_HEX8(0x41, answer[0]);
  bench_sdo(without_object, answer);
  bench_sdo(upload_text, answer);
  TEST_ASSERT_EQUAL_HEX8(0, answer[0]);
  bench_wait_ms(SDO_QUIET_MS);
  TEST_ASSERT_EQUAL_HEX8(0x41, bench_last(0x585)->data[0]);
}

/* A client whose download was refused can have taken the other one's confirmation for its own, and may send a segment
 * yet. A block segment without a number can be the other client's request. */
static void test_a_refused_download_makes_the_next_transfer_wait(void) {
  static const uint8_t refused[8] = {0x21, 0x00, 0x2F, 8, 9};
  static const uint8_t by_block[8] = {0xC6, 0x01, 0x2F, 0, 100};
  static const uint8_t no_sequence[8] = {0x00};
  uint8_t answer[8];
  for (int row = 0; row < 2; row++) {
    if (row == 0) {
      bench_sdo(refused, answer);
      TEST_ASSERT_EQUAL_HEX32(0x06070012, abort_of(answer));
    } else {
      bench_sdo(by_block, answer);
      bench_sdo(no_sequence, answer);
      TEST_ASSERT_EQUAL_HEX32(0x05040003, abort_of(answer));
    }
    bench_sdo(upload_text, answer);
    TEST_ASSERT_EQUAL_HEX8(0, answer[0]);
    bench_wait_ms(SDO_QUIET_MS);
    TEST_ASSERT_EQUAL_HEX8(0x41, bench_last(0x585)->data[0]);
    bench_wait_ms(SDO_QUIET_MS);
  }
}

/* 2F00:10 has been written by the second client, which waited for the first one. After both, a request that is none
 * comes: no client that it could have come from waits for an answer. */
static void test_an_unknown_request_after_all_transfers_makes_nobody_wait(void) {
  static const uint8_t download[8] = {0x21, 0x00, 0x2F, 10, 2};
  static const uint8_t letters[8] = {0x0B, 'h', 'i'};
  static const uint8_t unknown[8] = {0xE0};
  uint8_t answer[8];
  bench_sdo(upload_text, answer);
  bench_sdo(download, answer);
  TEST_ASSERT_EQUAL_HEX8(0, answer[0]);
  bench_wait_ms(SDO_QUIET_MS);
  TEST_ASSERT_EQUAL_HEX8(0x60, bench_last(0x585)->data[0]);
  bench_sdo(letters, answer);
  TEST_ASSERT_EQUAL_HEX8(0x20, answer[0]);
  bench_wait_ms(SDO_QUIET_MS);
  bench_sdo(unknown, answer);
  TEST_ASSERT_EQUAL_HEX32(0x05040001, abort_of(answer));
  bench_sdo(upload_u64, answer);
  TEST_ASSERT_EQUAL_HEX8(0x41, answer[0]);
}

static void test_a_client_that_has_been_silent_is_taken_for_gone(void) {
  const uint8_t block_download[8] = {0xC6, 0x01, 0x2F, 0, 100};
  uint8_t answer[8];
  bench_sdo(upload_text, answer);
  bench_wait_ms(SDO_QUIET_MS);
  bench_sdo(block_download, answer);
  TEST_ASSERT_EQUAL_HEX8_ARRAY(((const uint8_t[]){0xA4, 0x01, 0x2F, 0, SDO_BLOCK_SEGMENTS, 0, 0, 0}), answer, 8);
  bench_wait_ms(SDO_QUIET_MS);
  bench_sdo(upload_text, answer);
  TEST_ASSERT_EQUAL_HEX8(0x41, answer[0]);
  TEST_ASSERT_EQUAL(0, bench.device.streams_open);
}

static void test_no_initiate_request_is_taken_for_a_block_segment(void) {
  static const uint8_t initiates[] = {0x20, 0x21, 0x22, 0x23, 0x27, 0x2B, 0x2F, 0x40, 0xA0, 0xA4, 0xC0, 0xC2, 0xC6};
  const uint8_t block_download[8] = {0xC6, 0x01, 0x2F, 0, 100};
  uint8_t answer[8];
  for (uint32_t i = 0; i < sizeof initiates; i++) {
    for (uint32_t received = 0; received < SDO_BLOCK_SEGMENTS; received++) {
      sdo_server_reset(SERVER);
      bench_sdo(block_download, answer);
      TEST_ASSERT_EQUAL(SDO_BLOCK_SEGMENTS, answer[4]);
      SERVER->sequence = (uint8_t)received;
      const uint8_t request[8] = {initiates[i], 0x00, 0x2F, 7, 1};
      bench_sdo(request, answer);
      TEST_ASSERT_EQUAL_HEX32(0x05040003, abort_of(answer));
      TEST_ASSERT_EQUAL(0, bench.device.streams_open);
    }
  }
}

static void test_a_request_that_meets_an_answer_under_way_comes_after_it(void) {
  const uint8_t slow[8] = {0x2F, 0x11, 0x2F, 0, 9};
  const uint8_t write[8] = {0x23, 0x00, 0x2F, 7, 0x39};
  bench_give(0x605, 8, slow);
  bench_give(0x605, 8, write);
  bench_wait_ms(8);
  TEST_ASSERT_EQUAL(2, bench_count(0x585));
  TEST_ASSERT_EQUAL_HEX8(0x11, bench.log[0].data[1]);
  TEST_ASSERT_EQUAL_HEX8(7, bench_last(0x585)->data[3]);
  TEST_ASSERT_EQUAL_HEX32(0x39, bench.device.values.u32);
  bench.sent = 0;
  bench.bus_full = true;
  const uint8_t read[8] = {0x40, 0x00, 0x2F, 7};
  const uint8_t again[8] = {0x23, 0x00, 0x2F, 7, 0x3A};
  bench_give(0x605, 8, read);
  bench_give(0x605, 8, write);
  bench_wait_ms(3);
  bench.bus_full = false;
  canopen_node_answer(&bench.device.node); /* the first answer is sent, the write still waits */
  bench_give(0x605, 8, again);
  bench_wait_ms(5);
  TEST_ASSERT_EQUAL(3, bench_count(0x585));
  TEST_ASSERT_EQUAL_HEX8(0x43, bench.log[0].data[0]);
  TEST_ASSERT_EQUAL_HEX32(0x3A, bench.device.values.u32);
}

/* The answer to the first client has just left, and the second one's request has waited for it: a third client's
 * transfer waits until the first one cannot go on. */
static void test_a_third_clients_transfer_waits_for_both_that_came_before(void) {
  const uint8_t write[8] = {0x23, 0x00, 0x2F, 7, 0x39};
  bench.bus_full = true;
  bench_give(0x605, 8, upload_text);
  bench_wait_ms(1);
  bench_give(0x605, 8, write);
  bench_wait_ms(1);
  bench.bus_full = false;
  canopen_node_answer(&bench.device.node);
  bench_give(0x605, 8, upload_u64);
  bench_wait_ms(SDO_QUIET_MS - 2);
  TEST_ASSERT_EQUAL(2, bench_count(0x585));
  TEST_ASSERT_EQUAL_HEX8(10, bench.log[0].data[3]);
  TEST_ASSERT_EQUAL_HEX8(0x60, bench.log[1].data[0]);
  bench_wait_ms(4);
  TEST_ASSERT_EQUAL(3, bench_count(0x585));
  TEST_ASSERT_EQUAL_HEX8(8, bench_last(0x585)->data[3]);
}

/* --- Two channels
 * ---------------------------------------------------------------------------------------------------- */

enum { REQUEST_2 = 0x6A0, ANSWER_2 = 0x6A1 };

static void open_second_channel(void) {
  TEST_ASSERT_EQUAL_HEX32(0, bench_write(0x1201, 1, REQUEST_2, 4));
  TEST_ASSERT_EQUAL_HEX32(0, bench_write(0x1201, 2, ANSWER_2, 4));
}

static void test_two_transfers_on_two_channels_do_not_touch(void) {
  uint8_t answer[8];
  open_second_channel();
  bench_sdo(upload_text, answer);
  bench.sent = 0;
  bench_give(REQUEST_2, 8, upload_u64);
  bench_wait_ms(1);
  TEST_ASSERT_EQUAL(0, bench_count(0x585));
  TEST_ASSERT_EQUAL_HEX8(8, bench_last(ANSWER_2)->data[3]);
  bench_sdo(upload_segment, answer);
  TEST_ASSERT_EQUAL_MEMORY("hello w", &answer[1], 7);
}

static void test_the_second_channel_obeys_the_rules_of_its_object(void) {
  const uint8_t text[8] = {0x40, 0x00, 0x2F, 10};
  bench_give(REQUEST_2, 8, text);
  bench_wait_ms(1);
  TEST_ASSERT_EQUAL(0, bench_count(ANSWER_2));
  TEST_ASSERT_EQUAL_HEX32(0x06090030, bench_write(0x1201, 1, 0x606, 4));
  TEST_ASSERT_EQUAL_HEX32(0x06090030, bench_write(0x1201, 1, 0x40000000 | REQUEST_2, 4));
  TEST_ASSERT_EQUAL_HEX32(0x06090030, bench_write(0x1201, 2, 0x20000000 | ANSWER_2, 4));
  TEST_ASSERT_EQUAL_HEX32(0x06040043, bench_write(0x1201, 1, 0x080, 4)); /* SYNC */
  TEST_ASSERT_EQUAL_HEX32(0x06040043, bench_write(0x1201, 1, 0x205, 4)); /* RPDO 1 */
  open_second_channel();
  TEST_ASSERT_EQUAL_HEX32(0x08000022, bench_write(0x1201, 1, REQUEST_2 + 2, 4));
  TEST_ASSERT_EQUAL_HEX32(0x06040043, bench_write(0x1005, 0, REQUEST_2, 4));
  TEST_ASSERT_EQUAL_HEX32(0, bench_write(0x1400, 1, 0x80000000, 4));
  TEST_ASSERT_EQUAL_HEX32(0x06040043, bench_write(0x1400, 1, REQUEST_2, 4));
  TEST_ASSERT_EQUAL_HEX32(0, bench_write(0x1201, 2, 0x80000000, 4));
  TEST_ASSERT_EQUAL_HEX32(0x06040043, bench_write(0x1201, 2, REQUEST_2, 4));
  bench.sent = 0;
  bench_give(REQUEST_2, 8, text);
  bench_wait_ms(1);
  TEST_ASSERT_EQUAL(0, bench_count(0x585) + bench_count(ANSWER_2));
}

/* The owner of 2F11 is asked four times for each write: two of them never have two turns in one ms. The request of
 * either channel comes first. */
static void test_long_commands_of_two_channels_take_one_turn_per_ms(void) {
  const uint8_t slow[8] = {0x2F, 0x11, 0x2F, 0, 9};
  for (int second_first = 0; second_first <= 1; second_first++) {
    bench_start();
    open_second_channel();
    bench.sent = 0;
    bench_give(second_first ? REQUEST_2 : 0x605, 8, slow);
    bench_give(second_first ? 0x605 : REQUEST_2, 8, slow);
    bench_wait_ms(1);
    TEST_ASSERT_EQUAL(1, bench.device.calls); /* the other request waits */
    bench_wait_ms(1);
    TEST_ASSERT_EQUAL(3, bench.device.calls); /* the first goes on, the other begins */
    for (uint8_t calls = 4; calls <= 8; calls++) {
      bench_wait_ms(1);
      TEST_ASSERT_EQUAL(calls, bench.device.calls);
    }
    TEST_ASSERT_EQUAL(1, bench_count(0x585));
    TEST_ASSERT_EQUAL(1, bench_count(ANSWER_2));
  }
}

/* Ten requests come in one ms: one may cost the deferred task 120 us, so that four are answered in each. */
static void test_no_more_than_four_requests_are_answered_in_one_ms(void) {
  const uint8_t read[8] = {0x40, 0x00, 0x2F, 7};
  for (int i = 0; i < 10; i++) {
    bench_give(0x605, 8, read);
  }
  for (uint32_t ms = 1; ms <= 4; ms++) {
    bench_wait_ms(1);
    TEST_ASSERT_EQUAL(ms <= 2 ? 4 * ms : 10, bench_count(0x585));
  }
}

/* In the same ms, the first channel switches the second one off and a request comes on it. */
static void test_a_channel_that_is_switched_off_ends_its_transfer_and_answers_nothing(void) {
  const uint8_t download[8] = {0x21, 0x01, 0x2F, 0, 100};
  const uint8_t off[8] = {0x23, 0x01, 0x12, 1, 0xA0, 0x06, 0x00, 0x80};
  const uint8_t read[8] = {0x40, 0x00, 0x2F, 7};
  open_second_channel();
  bench_give(REQUEST_2, 8, download);
  bench_wait_ms(1);
  TEST_ASSERT_EQUAL(1, bench.device.streams_open);
  bench.sent = 0;
  bench_give(0x605, 8, off);
  bench_give(REQUEST_2, 8, read);
  bench_wait_ms(5);
  TEST_ASSERT_EQUAL(1, bench.sent);
  TEST_ASSERT_EQUAL_HEX8_ARRAY(((const uint8_t[]){0x60, 0x01, 0x12, 1, 0, 0, 0, 0}), bench_last(0x585)->data, 8);
  TEST_ASSERT_EQUAL(0, bench.device.streams_open);
}

/* The bus takes three frames per ms: a long upload on one channel must leave the other its share. */
static void test_a_long_upload_leaves_the_other_channel_its_answers(void) {
  static const uint8_t begin[8] = {0xA4, 0x02, 0x2F, 0, 127};
  static const uint8_t go[8] = {0xA3};
  static const uint8_t read[8] = {0x40, 0x00, 0x2F, 7};
  uint8_t answer[8];
  open_second_channel();
  bench.device.stream_size = 800;
  bench_sdo(begin, answer);
  bench.sent = 0;
  bench_give(0x605, 8, go);
  bench.room = 3;
  bench_give(REQUEST_2, 8, read);
  bench_wait_ms(1);
  bench.room = 3;
  bench_wait_ms(1);
  TEST_ASSERT_EQUAL(1, bench_count(ANSWER_2));
  bench.room = UINT32_MAX;
}

static void test_slow_owner_keeps_the_answer_waiting_and_the_node_alive(void) {
  const uint8_t request[8] = {0x2F, 0x11, 0x2F, 0, 9};
  bench.device.node.objects.heartbeat_producer_ms = 1;
  bench_give(0x605, 8, request);
  bench_wait_ms(3);
  TEST_ASSERT_EQUAL(0, bench_count(0x585));
  bench_wait_ms(2);
  TEST_ASSERT_EQUAL(1, bench_count(0x585));
  TEST_ASSERT_EQUAL_HEX8(0x60, bench_last(0x585)->data[0]);
  TEST_ASSERT_EQUAL(9, bench.device.values.slow);
  TEST_ASSERT_EQUAL(5, bench_count(0x705));
}

/* --- Block transfer: `lose` names a segment of the first sub-block that does not arrive, 0 for none. ------------- */

static uint32_t block_download(const uint8_t *data, uint32_t size, uint8_t lose, uint16_t crc_error) {
  const uint8_t start[8] = {0xC6, 0x01, 0x2F, 0, (uint8_t)size, (uint8_t)(size >> 8), (uint8_t)(size >> 16), 0};
  uint8_t answer[8];
  bench_sdo(start, answer);
  if (answer[0] == 0x80) {
    return abort_of(answer);
  }
  TEST_ASSERT_EQUAL_HEX8(0xA4, answer[0]);
  uint8_t block = answer[4];
  uint32_t done = 0;
  while (done < size) {
    uint8_t sequence = 0;
    uint32_t at = done;
    bench.sent = 0;
    while (sequence < block && at < size) {
      const uint32_t length = size - at < 7 ? size - at : 7;
      uint8_t segment[8] = {++sequence};
      segment[0] = (uint8_t)(sequence | (at + length == size ? 0x80 : 0));
      memcpy(&segment[1], &data[at], length);
      at += length;
      if (sequence != lose) {
        bench_give(0x605, 8, segment);
      }
      bench_wait_ms(1);
    }
    lose = 0;
    const uint8_t *ack = bench_last(0x585)->data;
    if (ack[0] == 0x80) {
      return abort_of(ack);
    }
    TEST_ASSERT_EQUAL_HEX8(0xA2, ack[0]);
    done += ack[1] * 7u;
    block = ack[2];
  }
  const uint16_t crc = (uint16_t)(crc_xmodem(0, data, size) ^ crc_error);
  const uint32_t unused = (7 - size % 7) % 7;
  const uint8_t end[8] = {(uint8_t)(0xC1 | unused << 2), (uint8_t)crc, (uint8_t)(crc >> 8)};
  bench_sdo(end, answer);
  return abort_of(answer);
}

static uint8_t pattern[TEST_DEVICE_STREAM];

static void fill_pattern(uint32_t seed) {
  for (uint32_t i = 0; i < sizeof pattern; i++) {
    seed = seed * 1664525u + 1013904223u;
    pattern[i] = (uint8_t)(seed >> 24);
  }
}

static void test_block_download_of_any_length_arrives_bit_exact(void) {
  static const uint32_t sizes[] = {1, 6, 7, 8, 13, 14, 223, 224, 225, 448, 1000, 32768};
  for (uint32_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
    fill_pattern(i);
    TEST_ASSERT_EQUAL_HEX32(0, block_download(pattern, sizes[i], 0, 0));
    TEST_ASSERT_EQUAL(sizes[i], bench.device.stream_size);
    TEST_ASSERT_EQUAL_MEMORY(pattern, bench.device.stream, sizes[i]);
  }
}

static void test_lost_segment_is_sent_again(void) {
  for (uint8_t lose = 1; lose <= SDO_BLOCK_SEGMENTS - 1; lose++) {
    fill_pattern(lose);
    TEST_ASSERT_EQUAL_HEX32(0, block_download(pattern, 500, lose, 0));
    TEST_ASSERT_EQUAL_MEMORY(pattern, bench.device.stream, 500);
  }
}

static void test_wrong_crc_and_wrong_size_change_nothing(void) {
  fill_pattern(1);
  TEST_ASSERT_EQUAL_HEX32(0, block_download(pattern, 100, 0, 0));
  uint8_t other[100] = {0};
  TEST_ASSERT_EQUAL_HEX32(0x05040004, block_download(other, 100, 0, 1));
  TEST_ASSERT_EQUAL_MEMORY(pattern, bench.device.stream, 100);
  TEST_ASSERT_EQUAL_HEX32(0x06070012, block_download(other, TEST_DEVICE_STREAM + 1, 0, 0));
  TEST_ASSERT_EQUAL(100, bench.device.stream_size);
  TEST_ASSERT_EQUAL(0, bench.device.streams_open);
}

/* An object of 4 bytes gets 7. The first reason is told: neither the CRC nor that the transfer has ended. */
static void test_a_block_that_is_longer_than_its_object_is_refused_as_too_long(void) {
  for (uint8_t with_crc = 0; with_crc < 2; with_crc++) {
    for (uint8_t with_size = 0; with_size < 2; with_size++) {
      const uint8_t start[8] = {(uint8_t)(0xC0 | with_crc << 2 | with_size << 1), 0x00, 0x2F, 7, 4 * with_size};
      const uint8_t segment[8] = {0x81, 1, 2, 3, 4, 5, 6, 7};
      const uint8_t end[8] = {0xC1, 0x12, 0x34};
      uint8_t answer[8];
      const uint32_t before = bench.device.values.u32;
      bench_sdo(start, answer);
      TEST_ASSERT_EQUAL_HEX8(0xA0, answer[0] & 0xFB);
      bench_sdo(segment, answer);
      TEST_ASSERT_EQUAL_HEX8(0xA2, answer[0]);
      bench_sdo(end, answer);
      TEST_ASSERT_EQUAL_HEX32(with_size != 0 || with_crc == 0 ? 0x06070012 : 0x05040004, abort_of(answer));
      TEST_ASSERT_EQUAL_HEX32(before, bench.device.values.u32);
      bench_wait_ms(SDO_QUIET_MS);
    }
  }
}

/* Reads 2F02 by block upload with sub-blocks of `block`; every `lose`-th segment is not confirmed once. */
static uint32_t block_upload(uint8_t *data, uint8_t block, uint8_t lose) {
  const uint8_t start[8] = {0xA4, 0x02, 0x2F, 0, block};
  const uint8_t go[8] = {0xA3};
  const uint8_t done[8] = {0xA1};
  uint8_t answer[8];
  bench_sdo(start, answer);
  TEST_ASSERT_EQUAL_HEX8(0xC6, answer[0]);
  const uint32_t size = bench_u32(&answer[4]);
  uint32_t got = 0;
  bench.sent = 0;
  bench_give(0x605, 8, go);
  for (bool last = false; !last;) {
    bench_wait_ms(20);
    const uint32_t sent = bench.sent;
    const bool hole = lose != 0 && sent > lose;
    const uint32_t kept = hole ? lose : sent;
    TEST_ASSERT_TRUE(sent <= block && sent > 0);
    for (uint32_t i = 0; i < kept; i++) {
      TEST_ASSERT_EQUAL(i + 1, bench.log[i].data[0] & 0x7F);
      memcpy(&data[got], &bench.log[i].data[1], 7);
      got += 7;
      last = (bench.log[i].data[0] & 0x80) != 0;
    }
    lose = 0;
    const uint8_t ack[8] = {0xA2, (uint8_t)kept, block};
    bench.sent = 0;
    bench_give(0x605, 8, ack);
  }
  bench_wait_ms(1);
  const uint8_t *end = bench_last(0x585)->data;
  TEST_ASSERT_EQUAL_HEX8(0xC1, end[0] & 0xE3);
  TEST_ASSERT_EQUAL(size, got - (end[0] >> 2 & 7));
  TEST_ASSERT_EQUAL_HEX16(crc_xmodem(0, data, size), end[1] | end[2] << 8);
  bench_give(0x605, 8, done);
  bench_wait_ms(1);
  TEST_ASSERT_EQUAL(SDO_IDLE, SERVER->state);
  TEST_ASSERT_EQUAL(0, bench.device.streams_open);
  return size;
}

static void test_block_upload_of_any_length_arrives_bit_exact(void) {
  static const uint32_t sizes[] = {0, 1, 7, 8, 889, 890, 32768};
  static uint8_t data[TEST_DEVICE_STREAM + 7];
  for (uint32_t i = 0; i < sizeof sizes / sizeof sizes[0]; i++) {
    fill_pattern(i);
    memcpy(bench.device.stream, pattern, sizeof pattern);
    bench.device.stream_size = sizes[i];
    for (uint8_t lose = 0; lose < 20; lose += 5) {
      TEST_ASSERT_EQUAL(sizes[i], block_upload(data, lose % 2 == 0 ? 127 : 10, lose));
      TEST_ASSERT_EQUAL(0, memcmp(pattern, data, sizes[i]));
    }
  }
}

/* A client that gives no CRC (bit 2 of its request) gets none: the field is 0. */
static void test_a_block_upload_without_a_crc_has_none(void) {
  const uint8_t start[8] = {0xA0, 0x02, 0x2F, 0, 127};
  const uint8_t go[8] = {0xA3};
  const uint8_t ack[8] = {0xA2, 2, 127};
  uint8_t answer[8];
  fill_pattern(3);
  TEST_ASSERT_EQUAL_HEX32(0, block_download(pattern, 14, 0, 0));
  bench_sdo(start, answer);
  TEST_ASSERT_EQUAL_HEX8(0xC2, answer[0] & 0xFB); /* with or without a CRC of the server */
  bench_give(0x605, 8, go);
  bench_wait_ms(20);
  bench.sent = 0;
  bench_sdo(ack, answer);
  TEST_ASSERT_EQUAL_HEX8(0xC1, answer[0] & 0xE3);
  TEST_ASSERT_EQUAL_HEX8(0, answer[1]);
  TEST_ASSERT_EQUAL_HEX8(0, answer[2]);
}

static void test_full_bus_delays_an_upload_and_loses_nothing(void) {
  static uint8_t data[TEST_DEVICE_STREAM + 7];
  const uint8_t start[8] = {0xA4, 0x02, 0x2F, 0, 127};
  const uint8_t go[8] = {0xA3};
  uint8_t answer[8];
  fill_pattern(3);
  memcpy(bench.device.stream, pattern, 800);
  bench.device.stream_size = 800;
  bench_sdo(start, answer);
  bench.sent = 0;
  bench_give(0x605, 8, go);
  for (uint32_t i = 0; i < 200; i++) {
    bench.bus_full = i % 3 != 0;
    bench_wait_ms(1);
  }
  TEST_ASSERT_EQUAL(115, bench_count(0x585));
  for (uint32_t i = 0; i < 115; i++) {
    memcpy(&data[7 * i], &bench.log[i].data[1], 7);
  }
  TEST_ASSERT_EQUAL_MEMORY(pattern, data, 800);
}

/* The bus takes no segment, and the client has given up: it asks for something else. */
static void test_an_upload_that_waits_for_the_bus_gives_way_to_a_new_request(void) {
  const uint8_t start[8] = {0xA4, 0x02, 0x2F, 0, 127};
  const uint8_t go[8] = {0xA3};
  const uint8_t read[8] = {0x40, 0x00, 0x2F, 7};
  uint8_t answer[8];
  bench.device.stream_size = 800;
  bench_sdo(start, answer);
  bench.bus_full = true;
  bench_give(0x605, 8, go);
  bench_wait_ms(3);
  bench_give(0x605, 8, read);
  bench_wait_ms(3);
  bench.bus_full = false;
  bench.sent = 0;
  bench_wait_ms(20);
  TEST_ASSERT_EQUAL(1, bench_count(0x585));
  TEST_ASSERT_EQUAL_HEX8_ARRAY(((const uint8_t[]){0x43, 0x00, 0x2F, 7, 0xEF, 0xBE, 0xAD, 0xDE}),
                               bench_last(0x585)->data, 8);
  TEST_ASSERT_EQUAL(0, bench.device.streams_open);
}

/* --- Every first byte, every length, every state ------------------------------------------------------------------ */

static void enter_state(sdo_state state) {
  static const uint8_t download[8] = {0x21, 0x01, 0x2F, 0, 100};
  static const uint8_t upload[8] = {0x40, 0x00, 0x2F, 10};
  static const uint8_t block_start[8] = {0xC6, 0x01, 0x2F, 0, 7};
  static const uint8_t block_segment[8] = {0x81, 1, 2, 3, 4, 5, 6, 7};
  static const uint8_t block_read[8] = {0xA4, 0x02, 0x2F, 0, 4};
  static const uint8_t block_go[8] = {0xA3};
  static const uint8_t block_ack[8] = {0xA2, 4, 4};
  static const uint8_t slow[8] = {0x2F, 0x11, 0x2F, 0, 9};
  sdo_server_reset(SERVER);
  bench.device.stream_size = state == SDO_BLOCK_UPLOAD_END ? 28 : 280;
  bench.device.calls = 0;
  switch (state) {
    case SDO_IDLE:
      break;
    case SDO_DOWNLOADING:
      sdo_server_receive(SERVER, download);
      break;
    case SDO_UPLOADING:
      sdo_server_receive(SERVER, upload);
      break;
    case SDO_BLOCK_DOWNLOADING:
    case SDO_BLOCK_DOWNLOAD_END:
      sdo_server_receive(SERVER, block_start);
      if (state == SDO_BLOCK_DOWNLOAD_END) {
        sdo_server_receive(SERVER, block_segment);
      }
      break;
    case SDO_BLOCK_UPLOAD_START:
    case SDO_BLOCK_UPLOADING:
    case SDO_BLOCK_UPLOAD_ACK:
    case SDO_BLOCK_UPLOAD_END:
      sdo_server_receive(SERVER, block_read);
      if (state != SDO_BLOCK_UPLOAD_START) {
        sdo_server_receive(SERVER, block_go);
      }
      for (uint32_t i = 0; i < 4 && (state == SDO_BLOCK_UPLOAD_ACK || state == SDO_BLOCK_UPLOAD_END); i++) {
        TEST_ASSERT_NOT_NULL(sdo_server_outgoing(SERVER));
        sdo_server_sent(SERVER);
      }
      if (state == SDO_BLOCK_UPLOAD_END) {
        sdo_server_receive(SERVER, block_ack);
      }
      break;
    case SDO_COMMITTING:
      sdo_server_receive(SERVER, slow);
      break;
  }
  TEST_ASSERT_EQUAL(state, SERVER->state);
  if (SERVER->reply_waiting) {
    sdo_server_sent(SERVER);
  }
}

/* One request in one state: an object changes only with an answer of success. */
static void try_request(sdo_state state, const uint8_t *bytes, uint8_t length) {
  enter_state(state);
  const communication_objects objects = bench.device.node.objects;
  const test_values values = bench.device.values;
  const uint32_t stream_size = bench.device.stream_size;
  bench.sent = 0;
  bench_give(0x605, length, bytes);
  canopen_node_answer(&bench.device.node);
  const bool changed = memcmp(&objects, &bench.device.node.objects, sizeof objects) != 0 ||
                       memcmp(&values, &bench.device.values, sizeof values) != 0 ||
                       stream_size != bench.device.stream_size;
  if (length != 8) {
    /* Ignored: an upload continues by itself, everything else is unchanged. */
    TEST_ASSERT_FALSE(changed);
    TEST_ASSERT_EQUAL(state == SDO_BLOCK_UPLOADING ? SDO_BLOCK_UPLOAD_ACK : state, SERVER->state);
  }
  if (changed) {
    const uint8_t answer = bench_last(0x585)->data[0];
    TEST_ASSERT_TRUE(answer == 0x60 || answer == 0xA1 || (answer & 0xEF) == 0x20);
  }
}

static void test_every_first_byte_and_length_in_every_state_is_harmless(void) {
  static const uint8_t payloads[][7] = {{0x00, 0x2F, 7, 1, 2, 3, 4},
                                        {0x00, 0x2F, 9, 0, 0, 0xC0, 0x7F},
                                        {0x01, 0x2F, 0, 0, 1, 0, 0},
                                        {0x02, 0x2F, 0, 127, 0, 0, 0},
                                        {0, 0, 0, 0, 0, 0, 0},
                                        {255, 255, 255, 255, 255, 255, 255},
                                        {0x10, 0x10, 1, 's', 'a', 'v', 'e'},
                                        {0x00, 0x2F, 10, 0xFF, 0xFF, 0xFF, 0x7F},
                                        {4, 4, 0, 0, 0, 0, 0}};
  uint32_t tried = 0;
  for (sdo_state state = SDO_IDLE; state <= SDO_COMMITTING; state++) {
    for (uint32_t first = 0; first <= 255; first++) {
      for (uint32_t p = 0; p < sizeof payloads / sizeof payloads[0]; p++) {
        uint8_t bytes[8] = {(uint8_t)first};
        memcpy(&bytes[1], payloads[p], 7);
        for (uint8_t length = 0; length <= 8; length++) {
          try_request(state, bytes, length);
          tried++;
        }
      }
    }
  }
  TEST_ASSERT_EQUAL(10 * 256 * 9 * 9, tried);
}

static void test_stopped_node_answers_no_sdo(void) {
  uint8_t answer[8];
  const uint8_t request[8] = {0x40, 0x00, 0x10, 0};
  bench_nmt(2, 0);
  bench_sdo(request, answer);
  TEST_ASSERT_EQUAL_HEX8(0, answer[0]);
}

static void test_a_command_is_executed_once_after_it_was_accepted(void) {
  TEST_ASSERT_EQUAL_HEX32(0, bench_write(0x2F12, 0, 5, 1));
  TEST_ASSERT_EQUAL(1, bench.device.commands);
  TEST_ASSERT_EQUAL(1, bench.device.carried_out);
  TEST_ASSERT_EQUAL(5, bench.device.values.command);
  TEST_ASSERT_EQUAL_HEX32(0x06060000, bench_write(0x2F12, 0, 66, 1)); /* not accepted */
  TEST_ASSERT_EQUAL_HEX32(0x06090031, bench_write(0x2F12, 0, 100, 1));
  TEST_ASSERT_EQUAL(1, bench.device.commands);
}

static void test_a_command_that_fails_gives_its_abort_code_and_stores_nothing(void) {
  TEST_ASSERT_EQUAL_HEX32(0x08000022, bench_write(0x2F12, 0, 13, 1));
  TEST_ASSERT_EQUAL(1, bench.device.commands);
  TEST_ASSERT_EQUAL(0, bench.device.carried_out);
  TEST_ASSERT_EQUAL(0, bench.device.values.command);
}

/* 100 bytes in segments of 7: the client sends the next one when it has the confirmation, with the toggle bit. */
static void test_each_segment_of_a_download_is_confirmed_with_its_toggle(void) {
  const uint8_t start[8] = {0x21, 0x01, 0x2F, 0, 100};
  uint8_t answer[8];
  bench_sdo(start, answer);
  TEST_ASSERT_EQUAL_HEX8(0x60, answer[0]);
  for (uint32_t n = 0; n < 15; n++) {
    const uint8_t toggle = n % 2 == 0 ? 0x00 : 0x10;
    const uint8_t last = n == 14 ? 5 << 1 | 1 : 0; /* 2 bytes */
    uint8_t segment[8] = {(uint8_t)(toggle | last)};
    for (uint32_t i = 0; i < 7; i++) {
      segment[1 + i] = (uint8_t)(7 * n + i);
    }
    bench_sdo(segment, answer);
    const uint8_t confirmation[8] = {(uint8_t)(0x20 | toggle)};
    TEST_ASSERT_EQUAL_HEX8_ARRAY(confirmation, answer, 8);
  }
  TEST_ASSERT_EQUAL(100, bench.device.stream_size);
  for (uint32_t i = 0; i < 100; i++) {
    TEST_ASSERT_EQUAL(i, bench.device.stream[i]);
  }
}

/* 40,000 bytes fit, and the client has not said how many it sends: 5714 segments of 7 bytes are taken, the next one is
 * more than the owner of the stream takes. */
static void test_a_download_of_unknown_size_is_refused_at_the_segment_that_its_owner_refuses(void) {
  const uint8_t start[8] = {0x20, 0x01, 0x2F, 0};
  uint8_t answer[8];
  bench_sdo(start, answer);
  TEST_ASSERT_EQUAL_HEX8(0x60, answer[0]);
  for (uint32_t n = 0; n < 5714; n++) {
    const uint8_t segment[8] = {n % 2 == 0 ? 0x00 : 0x10};
    bench_sdo(segment, answer);
    TEST_ASSERT_EQUAL_HEX8(0x20 | segment[0], answer[0]);
  }
  const uint8_t too_much[8] = {0x00};
  bench_sdo(too_much, answer);
  TEST_ASSERT_EQUAL_HEX32(0x06070012, abort_of(answer));
  TEST_ASSERT_EQUAL(0, bench.device.stream_size);
  TEST_ASSERT_EQUAL(0, bench.device.streams_open);
}

/* 10 bytes are announced; the segment that says to be the last one makes 7 of them. */
static void test_a_stream_that_ends_before_its_announced_size_is_refused(void) {
  const uint8_t start[8] = {0x21, 0x01, 0x2F, 0, 10};
  const uint8_t last[8] = {0x01, 1, 2, 3, 4, 5, 6, 7};
  uint8_t answer[8];
  bench_sdo(start, answer);
  TEST_ASSERT_EQUAL_HEX8(0x60, answer[0]);
  bench_sdo(last, answer);
  TEST_ASSERT_EQUAL_HEX32(0x06070013, abort_of(answer));
  TEST_ASSERT_EQUAL(0, bench.device.stream_size);
  TEST_ASSERT_EQUAL(0, bench.device.streams_open);
}

/* A segment may have no data: there is nothing that the owner of the stream could refuse. */
static void test_a_segment_without_data_is_confirmed_and_writes_nothing(void) {
  const uint8_t start[8] = {0x20, 0x01, 0x2F, 0};
  const uint8_t empty[8] = {7 << 1};
  const uint8_t one_byte[8] = {0x10 | 6 << 1, 1};
  uint8_t answer[8];
  bench.device.stream_broken = true;
  bench_sdo(start, answer);
  TEST_ASSERT_EQUAL_HEX8(0x60, answer[0]);
  bench_sdo(empty, answer);
  TEST_ASSERT_EQUAL_HEX8(0x20, answer[0]);
  bench_sdo(one_byte, answer);
  TEST_ASSERT_EQUAL_HEX32(0x06060000, abort_of(answer));
}

static void test_a_second_clients_block_download_waits_like_any_other_transfer(void) {
  const uint8_t by_block[8] = {0xC6, 0x01, 0x2F, 0, 100};
  uint8_t answer[8];
  bench_sdo(upload_text, answer);
  bench_sdo(by_block, answer);
  TEST_ASSERT_EQUAL_HEX8(0, answer[0]);
  bench_wait_ms(SDO_QUIET_MS);
  TEST_ASSERT_EQUAL_HEX8(0xA4, bench_last(0x585)->data[0]);
}

/* The client that waits has had no answer yet; the abort of the other one must not leave it without. */
static void test_a_client_that_waits_is_refused_when_the_other_aborts(void) {
  const uint8_t abort_text[8] = {0x80, 0x00, 0x2F, 10};
  uint8_t answer[8];
  bench_sdo(upload_text, answer);
  bench_sdo(upload_u64, answer);
  bench_sdo(abort_text, answer);
  TEST_ASSERT_EQUAL_HEX32(0x08000020, abort_of(answer));
  TEST_ASSERT_EQUAL_HEX8(8, answer[3]);
}

static void test_an_answer_under_way_becomes_an_abort_when_another_client_aborts(void) {
  const uint8_t read[8] = {0x40, 0x00, 0x2F, 7};
  const uint8_t other[8] = {0x80, 0x00, 0x2F, 10};
  bench.bus_full = true;
  bench_give(0x605, 8, read);
  bench_wait_ms(1);
  bench_give(0x605, 8, other);
  bench_wait_ms(1);
  bench.bus_full = false;
  bench.sent = 0;
  bench_wait_ms(1);
  TEST_ASSERT_EQUAL(1, bench_count(0x585));
  TEST_ASSERT_EQUAL_HEX32(0x08000020, abort_of(bench_last(0x585)->data));
}

static void test_the_abort_of_another_client_ends_the_transfer_and_its_stream(void) {
  const uint8_t start[8] = {0x21, 0x01, 0x2F, 0, 100};
  const uint8_t other[8] = {0x80, 0x00, 0x2F, 10};
  uint8_t answer[8];
  bench_sdo(start, answer);
  TEST_ASSERT_EQUAL(1, bench.device.streams_open);
  bench_sdo(other, answer);
  TEST_ASSERT_EQUAL(0, bench.device.streams_open);
}

static void test_a_stop_ends_the_transfers_of_both_channels(void) {
  const uint8_t start[8] = {0x21, 0x01, 0x2F, 0, 100};
  uint8_t answer[8];
  open_second_channel();
  bench_sdo(start, answer);
  bench_give(REQUEST_2, 8, start);
  bench_wait_ms(1);
  TEST_ASSERT_EQUAL(2, bench.device.streams_open);
  bench_nmt(2, BENCH_NODE);
  TEST_ASSERT_EQUAL(0, bench.device.streams_open);
}

static void test_a_silent_client_of_the_second_channel_is_timed_out_too(void) {
  const uint8_t start[8] = {0x21, 0x01, 0x2F, 0, 100};
  open_second_channel();
  bench_give(REQUEST_2, 8, start);
  bench_wait_ms(1);
  TEST_ASSERT_EQUAL(1, bench.device.streams_open);
  bench_wait_ms(SDO_TIME_OUT_MS + 1);
  TEST_ASSERT_EQUAL(0, bench.device.streams_open);
  TEST_ASSERT_EQUAL_HEX32(0x05040000, abort_of(bench_last(ANSWER_2)->data));
}

/* The segment that an abandoned transfer has left must not become the first one of the next. */
static void test_a_block_download_after_an_abandoned_one_starts_empty(void) {
  const uint8_t start[8] = {0xC6, 0x01, 0x2F, 0, 100};
  const uint8_t segment[8] = {0x01, 0xEE, 0xEE, 0xEE, 0xEE, 0xEE, 0xEE, 0xEE};
  const uint8_t abort_own[8] = {0x80, 0x01, 0x2F, 0};
  uint8_t answer[8];
  fill_pattern(3);
  bench_sdo(start, answer);
  bench_give(0x605, 8, segment);
  bench_sdo(abort_own, answer);
  TEST_ASSERT_EQUAL_HEX32(0, block_download(pattern, 50, 0, 0));
  TEST_ASSERT_EQUAL(50, bench.device.stream_size);
  TEST_ASSERT_EQUAL_MEMORY(pattern, bench.device.stream, 50);
}

/* In the first request and in a confirmation. */
static void test_blocks_of_no_segment_and_of_more_than_127_are_refused(void) {
  static const uint8_t sizes[] = {0, 128, 255};
  const uint8_t good[8] = {0xA4, 0x02, 0x2F, 0, 4};
  const uint8_t go[8] = {0xA3};
  bench.device.stream_size = 280;
  for (uint32_t i = 0; i < sizeof sizes; i++) {
    const uint8_t start[8] = {0xA4, 0x02, 0x2F, 0, sizes[i]};
    const uint8_t confirmation[8] = {0xA2, 4, sizes[i]};
    uint8_t answer[8];
    bench_sdo(start, answer);
    TEST_ASSERT_EQUAL_HEX32(0x05040002, abort_of(answer));
    TEST_ASSERT_EQUAL(0, bench.device.streams_open);
    bench_wait_ms(SDO_QUIET_MS);
    bench_sdo(good, answer);
    TEST_ASSERT_EQUAL_HEX8(0xC6, answer[0]);
    bench_sdo(go, answer);
    bench_wait_ms(20);
    bench_sdo(confirmation, answer);
    TEST_ASSERT_EQUAL_HEX32(0x05040002, abort_of(answer));
    TEST_ASSERT_EQUAL(0, bench.device.streams_open);
    bench_wait_ms(SDO_QUIET_MS);
  }
}

/* The only segment of a capture cannot be read: the client gets one abort, and the next one its answer at once. */
static void test_a_block_upload_whose_stream_fails_ends_with_its_abort_code(void) {
  const uint8_t start[8] = {0xA4, 0x02, 0x2F, 0, 4};
  const uint8_t go[8] = {0xA3};
  const uint8_t text[8] = {0x40, 0x00, 0x2F, 10};
  uint8_t answer[8];
  bench.device.stream_size = 7;
  bench_sdo(start, answer);
  TEST_ASSERT_EQUAL_HEX8(0xC6, answer[0]);
  bench.device.stream_broken = true;
  bench.sent = 0;
  bench_give(0x605, 8, go);
  bench_wait_ms(5);
  TEST_ASSERT_EQUAL(1, bench_count(0x585));
  TEST_ASSERT_EQUAL_HEX32(0x06060000, abort_of(bench_last(0x585)->data));
  TEST_ASSERT_EQUAL(0, bench.device.streams_open);
  bench_sdo(text, answer);
  TEST_ASSERT_EQUAL_HEX8(0x41, answer[0]);
}

/* 4 bytes at once, into a stream whose owner takes none. */
static void test_an_expedited_write_that_the_stream_refuses_gets_its_abort_code(void) {
  bench.device.stream_broken = true;
  TEST_ASSERT_EQUAL_HEX32(0x06060000, bench_write(0x2F01, 0, 0x12345678, 4));
  TEST_ASSERT_EQUAL(0, bench.device.streams_open);
  TEST_ASSERT_EQUAL(0, bench.device.stream_size);
}

static void test_an_expedited_read_that_the_stream_refuses_gets_its_abort_code(void) {
  uint32_t abort = 0;
  bench.device.stream_size = 4;
  bench.device.stream_broken = true;
  (void)bench_read(0x2F02, 0, &abort);
  TEST_ASSERT_EQUAL_HEX32(0x06060000, abort);
  TEST_ASSERT_EQUAL(0, bench.device.streams_open);
}

/* The axis still obeys its last controlword: another one is answered when it is in force, the same one at once. */
static void test_a_write_that_must_wait_is_answered_when_it_is_done(void) {
  const uint8_t enable[8] = {0x2B, 0x40, 0x60, 0, 0x0F};
  uint8_t answer[8];
  TEST_ASSERT_EQUAL_HEX32(0, bench_write(0x6040, 0, 0x07, 2));
  bench.device.busy = true;
  TEST_ASSERT_EQUAL_HEX32(0, bench_write(0x6040, 0, 0x07, 2));
  bench_sdo(enable, answer);
  bench_wait_ms(5);
  TEST_ASSERT_EQUAL(0, bench_count(0x585));
  TEST_ASSERT_EQUAL_HEX16(0x07, bench.device.axis[0].controlword);
  bench.device.busy = false;
  bench_wait_ms(2);
  TEST_ASSERT_EQUAL_HEX8(0x60, bench_last(0x585)->data[0]);
  TEST_ASSERT_EQUAL_HEX16(0x0F, bench.device.axis[0].controlword);
}

static void test_an_answer_that_was_not_sent_is_forgotten_with_a_stop(void) {
  bench.bus_full = true;
  bench_give(0x605, 8, upload_text);
  bench_wait_ms(1);
  bench_nmt(2, BENCH_NODE);
  bench.bus_full = false;
  bench_nmt(128, BENCH_NODE);
  bench_wait_ms(5);
  TEST_ASSERT_EQUAL(0, bench_count(0x585));
}

/* All segments are confirmed: the client may only end the transfer. */
static void test_a_finished_block_upload_takes_nothing_but_its_end(void) {
  static const uint8_t parts[] = {0xA2, 0xA3};
  for (uint32_t i = 0; i < sizeof parts; i++) {
    const uint8_t request[8] = {parts[i], 4, 4};
    enter_state(SDO_BLOCK_UPLOAD_END);
    TEST_ASSERT_EQUAL(1, bench.device.streams_open);
    uint8_t answer[8];
    bench_sdo(request, answer);
    TEST_ASSERT_EQUAL_HEX32(0x05040001, abort_of(answer));
    TEST_ASSERT_EQUAL(0, bench.device.streams_open);
  }
}

static void test_parts_of_a_block_upload_that_is_not_under_way_are_refused(void) {
  static const uint8_t parts[] = {0xA1, 0xA2, 0xA3};
  for (uint32_t i = 0; i < sizeof parts; i++) {
    const uint8_t request[8] = {parts[i], 1, 20};
    uint8_t answer[8];
    bench_sdo(request, answer);
    TEST_ASSERT_EQUAL_HEX32(0x05040001, abort_of(answer));
  }
}

/* The transfer itself, without a server that asks for nothing wrong: no byte is read or written beyond what is open. */
static void test_a_transfer_that_is_not_open_moves_no_byte(void) {
  od_object text;
  TEST_ASSERT_EQUAL(OD_OK, od_find(SERVER->dictionary, 0x2F00, 10, &text));
  uint8_t bytes[8] = {1, 2, 3, 4, 5, 6, 7, 8};
  sdo_transfer transfer = {0};
  TEST_ASSERT_EQUAL_HEX32(OD_GENERAL, sdo_transfer_read(&transfer, 0, bytes, 0));
  TEST_ASSERT_EQUAL_HEX32(OD_GENERAL, sdo_transfer_append(&transfer, bytes, 1));
  TEST_ASSERT_EQUAL_HEX32(OD_GENERAL, sdo_transfer_commit(&transfer));
  TEST_ASSERT_EQUAL(OD_OK, sdo_transfer_open_read(&transfer, &text));
  TEST_ASSERT_EQUAL_HEX32(OD_GENERAL, sdo_transfer_append(&transfer, bytes, 1));
  TEST_ASSERT_EQUAL_HEX32(OD_GENERAL, sdo_transfer_commit(&transfer));
  TEST_ASSERT_EQUAL_HEX32(OD_GENERAL, sdo_transfer_read(&transfer, 12, bytes, 0));
  TEST_ASSERT_EQUAL_HEX32(OD_GENERAL, sdo_transfer_read(&transfer, 8, bytes, 4));
  TEST_ASSERT_EQUAL_HEX8(1, bytes[0]);
  TEST_ASSERT_EQUAL(OD_OK, sdo_transfer_read(&transfer, 8, bytes, 3));
  TEST_ASSERT_EQUAL_MEMORY("rld", bytes, 3);
  sdo_transfer_close(&transfer);
  TEST_ASSERT_EQUAL_HEX32(OD_GENERAL, sdo_transfer_read(&transfer, 0, bytes, 1));
  TEST_ASSERT_EQUAL_STRING("hello world", bench.device.values.text);
}

static uint32_t stream_ends;

static od_abort refuse_the_end(void *owner, const od_object *object, bool writing, bool complete, uint32_t total) {
  (void)owner;
  (void)object;
  TEST_ASSERT_TRUE(writing && complete);
  TEST_ASSERT_EQUAL(1, total);
  stream_ends++;
  return OD_HARDWARE;
}

/* The owner refuses the whole of what it took in pieces: it has been told of the end, and is not told again. */
static void test_a_write_that_is_refused_at_its_end_has_ended(void) {
  od_object stream;
  TEST_ASSERT_EQUAL(OD_OK, od_find(SERVER->dictionary, 0x2F01, 0, &stream));
  od_hooks hooks = *stream.part->hooks;
  hooks.stream_end = refuse_the_end;
  od_part part = *stream.part;
  part.hooks = &hooks;
  stream.part = &part;
  const uint8_t byte = 7;
  sdo_transfer transfer = {0};
  stream_ends = 0;
  TEST_ASSERT_EQUAL_HEX32(OD_OK, sdo_transfer_open_write(&transfer, &stream, 1));
  TEST_ASSERT_EQUAL_HEX32(OD_OK, sdo_transfer_append(&transfer, &byte, 1));
  TEST_ASSERT_EQUAL_HEX32(OD_HARDWARE, sdo_transfer_commit(&transfer));
  sdo_transfer_close(&transfer);
  TEST_ASSERT_EQUAL_HEX32(OD_GENERAL, sdo_transfer_commit(&transfer));
  TEST_ASSERT_EQUAL(1, stream_ends);
}

/* The bus takes nothing for 20 ms: the client has sent its request in time and gets its answer, and then has the whole
 * time again. */
static void test_the_time_of_a_client_starts_again_with_its_request_and_with_the_answer(void) {
  uint8_t answer[8];
  bench_sdo(upload_text, answer);
  bench_wait_ms(SDO_TIME_OUT_MS - 10);
  bench.bus_full = true;
  bench_give(0x605, 8, upload_segment);
  bench_wait_ms(20);
  bench.bus_full = false;
  bench.sent = 0;
  bench_wait_ms(1);
  TEST_ASSERT_EQUAL_HEX8(0x00, bench_last(0x585)->data[0]);
  TEST_ASSERT_EQUAL_MEMORY("hello w", &bench_last(0x585)->data[1], 7);
  bench_wait_ms(SDO_TIME_OUT_MS - 10);
  bench_sdo((const uint8_t[8]){0x70}, answer);
  TEST_ASSERT_EQUAL_HEX8(0x10 | 3 << 1 | 1, answer[0]);
  TEST_ASSERT_EQUAL_MEMORY("orld", &answer[1], 4);
}

static void test_a_stream_that_is_written_only_is_not_read(void) {
  od_object stream;
  TEST_ASSERT_EQUAL(OD_OK, od_find(SERVER->dictionary, 0x2F01, 0, &stream));
  od_entry entry = *stream.entry;
  entry.access = OD_WO;
  stream.entry = &entry;
  sdo_transfer transfer = {0};
  TEST_ASSERT_EQUAL_HEX32(OD_WRITE_ONLY, sdo_transfer_open_read(&transfer, &stream));
  entry.access = OD_RO;
  TEST_ASSERT_EQUAL_HEX32(OD_READ_ONLY, sdo_transfer_open_write(&transfer, &stream, 1));
  entry.access = OD_CONST;
  TEST_ASSERT_EQUAL_HEX32(OD_READ_ONLY, sdo_transfer_open_write(&transfer, &stream, 1));
  TEST_ASSERT_EQUAL(0, bench.device.streams_open);
}

/* One hook is missing at a time; without an end hook, the transfer is as good. */
static void test_a_stream_without_the_hooks_for_it_is_not_supported(void) {
  od_object stream;
  TEST_ASSERT_EQUAL(OD_OK, od_find(SERVER->dictionary, 0x2F01, 0, &stream));
  const od_hooks whole = *stream.part->hooks;
  od_hooks hooks = whole;
  od_part part = *stream.part;
  part.hooks = NULL;
  stream.part = &part;
  sdo_transfer transfer = {0};
  TEST_ASSERT_EQUAL_HEX32(OD_UNSUPPORTED, sdo_transfer_open_read(&transfer, &stream));
  TEST_ASSERT_EQUAL_HEX32(OD_UNSUPPORTED, sdo_transfer_open_write(&transfer, &stream, 1));
  part.hooks = &hooks;
  hooks.stream_begin = NULL;
  TEST_ASSERT_EQUAL_HEX32(OD_UNSUPPORTED, sdo_transfer_open_read(&transfer, &stream));
  hooks = whole;
  hooks.stream_read = NULL;
  TEST_ASSERT_EQUAL_HEX32(OD_UNSUPPORTED, sdo_transfer_open_read(&transfer, &stream));
  hooks = whole;
  hooks.stream_write = NULL;
  TEST_ASSERT_EQUAL_HEX32(OD_UNSUPPORTED, sdo_transfer_open_write(&transfer, &stream, 1));
  TEST_ASSERT_EQUAL(0, bench.device.streams_open);
  hooks = whole;
  hooks.stream_end = NULL;
  const uint8_t byte = 7;
  TEST_ASSERT_EQUAL_HEX32(OD_OK, sdo_transfer_open_write(&transfer, &stream, 1));
  TEST_ASSERT_EQUAL_HEX32(OD_OK, sdo_transfer_append(&transfer, &byte, 1));
  TEST_ASSERT_EQUAL_HEX32(OD_OK, sdo_transfer_commit(&transfer));
}

static void test_numbers_have_their_low_byte_first(void) {
  const uint8_t bytes[] = {0x21, 0x43, 0x65, 0x87};
  TEST_ASSERT_EQUAL_HEX32(0x87654321, sdo_get_u32(bytes));
  uint8_t written[4];
  sdo_put_u32(written, 0x87654321);
  TEST_ASSERT_EQUAL_MEMORY(bytes, written, sizeof bytes);
}

static void test_an_unknown_request_is_refused_with_its_own_object(void) {
  const uint8_t unknown[8] = {0xE0, 0x34, 0x12, 7};
  uint8_t answer[8];
  bench_sdo(upload_text, answer); /* in segments: 2F00:10 */
  bench_sdo(unknown, answer);
  TEST_ASSERT_EQUAL_HEX8_ARRAY(((const uint8_t[]){0x80, 0x00, 0x2F, 10, 0x01, 0x00, 0x04, 0x05}), answer, 8);
  bench_sdo(unknown, answer); /* now idle */
  TEST_ASSERT_EQUAL_HEX8_ARRAY(((const uint8_t[]){0x80, 0x34, 0x12, 7, 0x01, 0x00, 0x04, 0x05}), answer, 8);
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_crc_has_its_check_value);
  RUN_TEST(test_expedited_write_is_read_back);
  RUN_TEST(test_each_refusal_has_its_abort_code_and_changes_nothing);
  RUN_TEST(test_expedited_write_without_a_length_takes_that_of_the_type);
  RUN_TEST(test_segmented_upload_brings_a_text);
  RUN_TEST(test_each_segment_of_an_upload_goes_on_where_the_last_one_ended);
  RUN_TEST(test_each_transfer_begins_with_toggle_0);
  RUN_TEST(test_segment_with_the_wrong_toggle_is_refused);
  RUN_TEST(test_segmented_download_must_bring_what_it_announced);
  RUN_TEST(test_a_text_may_be_shorter_than_its_room);
  RUN_TEST(test_a_download_announced_with_the_largest_size_is_refused_at_once);
  RUN_TEST(test_a_segment_beyond_the_room_is_refused_and_changes_nothing);
  RUN_TEST(test_silent_client_is_timed_out_and_reported);
  RUN_TEST(test_new_request_replaces_a_transfer_that_was_left);
  RUN_TEST(test_a_second_clients_transfer_waits_until_the_first_cannot_go_on);
  RUN_TEST(test_a_first_client_that_goes_on_ends_both_transfers);
  RUN_TEST(test_two_clients_that_wait_are_both_refused);
  RUN_TEST(test_an_expedited_request_never_waits);
  RUN_TEST(test_an_abort_of_another_client_makes_the_next_transfer_wait);
  RUN_TEST(test_a_refused_download_makes_the_next_transfer_wait);
  RUN_TEST(test_an_unknown_request_after_all_transfers_makes_nobody_wait);
  RUN_TEST(test_a_client_that_has_been_silent_is_taken_for_gone);
  RUN_TEST(test_no_initiate_request_is_taken_for_a_block_segment);
  RUN_TEST(test_a_request_that_meets_an_answer_under_way_comes_after_it);
  RUN_TEST(test_a_third_clients_transfer_waits_for_both_that_came_before);
  RUN_TEST(test_two_transfers_on_two_channels_do_not_touch);
  RUN_TEST(test_the_second_channel_obeys_the_rules_of_its_object);
  RUN_TEST(test_long_commands_of_two_channels_take_one_turn_per_ms);
  RUN_TEST(test_no_more_than_four_requests_are_answered_in_one_ms);
  RUN_TEST(test_a_channel_that_is_switched_off_ends_its_transfer_and_answers_nothing);
  RUN_TEST(test_a_long_upload_leaves_the_other_channel_its_answers);
  RUN_TEST(test_slow_owner_keeps_the_answer_waiting_and_the_node_alive);
  RUN_TEST(test_block_download_of_any_length_arrives_bit_exact);
  RUN_TEST(test_lost_segment_is_sent_again);
  RUN_TEST(test_wrong_crc_and_wrong_size_change_nothing);
  RUN_TEST(test_a_block_that_is_longer_than_its_object_is_refused_as_too_long);
  RUN_TEST(test_block_upload_of_any_length_arrives_bit_exact);
  RUN_TEST(test_a_block_upload_without_a_crc_has_none);
  RUN_TEST(test_full_bus_delays_an_upload_and_loses_nothing);
  RUN_TEST(test_an_upload_that_waits_for_the_bus_gives_way_to_a_new_request);
  RUN_TEST(test_every_first_byte_and_length_in_every_state_is_harmless);
  RUN_TEST(test_stopped_node_answers_no_sdo);
  RUN_TEST(test_a_command_is_executed_once_after_it_was_accepted);
  RUN_TEST(test_a_command_that_fails_gives_its_abort_code_and_stores_nothing);
  RUN_TEST(test_each_segment_of_a_download_is_confirmed_with_its_toggle);
  RUN_TEST(test_a_download_of_unknown_size_is_refused_at_the_segment_that_its_owner_refuses);
  RUN_TEST(test_a_stream_that_ends_before_its_announced_size_is_refused);
  RUN_TEST(test_a_segment_without_data_is_confirmed_and_writes_nothing);
  RUN_TEST(test_a_second_clients_block_download_waits_like_any_other_transfer);
  RUN_TEST(test_a_client_that_waits_is_refused_when_the_other_aborts);
  RUN_TEST(test_an_answer_under_way_becomes_an_abort_when_another_client_aborts);
  RUN_TEST(test_the_abort_of_another_client_ends_the_transfer_and_its_stream);
  RUN_TEST(test_a_stop_ends_the_transfers_of_both_channels);
  RUN_TEST(test_a_silent_client_of_the_second_channel_is_timed_out_too);
  RUN_TEST(test_a_block_download_after_an_abandoned_one_starts_empty);
  RUN_TEST(test_blocks_of_no_segment_and_of_more_than_127_are_refused);
  RUN_TEST(test_a_block_upload_whose_stream_fails_ends_with_its_abort_code);
  RUN_TEST(test_an_expedited_write_that_the_stream_refuses_gets_its_abort_code);
  RUN_TEST(test_an_expedited_read_that_the_stream_refuses_gets_its_abort_code);
  RUN_TEST(test_a_write_that_must_wait_is_answered_when_it_is_done);
  RUN_TEST(test_an_answer_that_was_not_sent_is_forgotten_with_a_stop);
  RUN_TEST(test_a_finished_block_upload_takes_nothing_but_its_end);
  RUN_TEST(test_parts_of_a_block_upload_that_is_not_under_way_are_refused);
  RUN_TEST(test_a_transfer_that_is_not_open_moves_no_byte);
  RUN_TEST(test_a_write_that_is_refused_at_its_end_has_ended);
  RUN_TEST(test_the_time_of_a_client_starts_again_with_its_request_and_with_the_answer);
  RUN_TEST(test_a_stream_that_is_written_only_is_not_read);
  RUN_TEST(test_a_stream_without_the_hooks_for_it_is_not_supported);
  RUN_TEST(test_numbers_have_their_low_byte_first);
  RUN_TEST(test_an_unknown_request_is_refused_with_its_own_object);
  return UNITY_END();
}
