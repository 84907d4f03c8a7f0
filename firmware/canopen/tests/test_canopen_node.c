/* SPDX-License-Identifier: Apache-2.0 */
#include "canopen/bench.h"
#include "canopen/node_objects.h"

void setUp(void) { bench_start(); }
void tearDown(void) {}

#define NODE (&bench.device.node)

enum { RESET_MS = 20 };

static void test_node_boots_with_one_message_and_is_pre_operational(void) {
  const can_sender sender = {bench_send, NULL};
  bench.sent = 0;
  bench.bus_full = true;
  NODE->sdo_client = 0;
  TEST_ASSERT_TRUE(test_device_init(&bench.device, BENCH_NODE, sender));
  TEST_ASSERT_EQUAL(SDO_CHANNELS, NODE->sdo_client); /* no channel has a request */
  bench_wait_ms(10);
  TEST_ASSERT_EQUAL(NMT_INITIALISING, NODE->state);
  bench.bus_full = false;
  bench_wait_ms(1);
  TEST_ASSERT_EQUAL(1, bench_count(0x705));
  TEST_ASSERT_EQUAL(0, bench.log[0].data[0]);
  TEST_ASSERT_EQUAL(NMT_PRE_OPERATIONAL, NODE->state);
}

/* Until LSS gives it one, its identifiers are those of node 1, and it sends nothing. */
static void test_a_node_without_id_has_the_identifiers_of_node_1_and_is_silent(void) {
  const can_sender sender = {bench_send, NULL};
  bench.sent = 0;
  TEST_ASSERT_TRUE(test_device_init(&bench.device, BUS_UNCONFIGURED, sender));
  bench_wait_ms(200);
  TEST_ASSERT_EQUAL(0, bench.sent);
  TEST_ASSERT_EQUAL(1, NODE->config.node_id);
  TEST_ASSERT_EQUAL_HEX32(0x81, NODE->objects.emergency.cob_id);
  TEST_ASSERT_EQUAL_HEX32(0x601, NODE->objects.sdo[0].request_cob_id);
}

static void test_a_configuration_is_taken_within_its_limits_and_refused_outside(void) {
  static canopen_node node;
  static can_frame queues[2][256];
  static const struct {
    uint8_t node_id;
    uint16_t kbit_s;
    uint32_t capacity;
    bool sends, good;
  } rows[] = {
      {1, 1000, 64, true, true},   {127, 125, 64, true, true},  {BUS_UNCONFIGURED, 1000, 128, true, true},
      {1, 0, 64, true, true},      {0, 1000, 64, true, false},  {128, 1000, 64, true, false},
      {1, 800, 64, true, false},   {1, 1, 64, true, false},     {1, 1000, 32, true, false},
      {1, 1000, 100, true, false}, {1, 1000, 64, false, false},
  };
  for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
    canopen_config config = NODE->config;
    config.parts = &NODE->parts[NODE->dictionary.count - config.part_count];
    config.process_data = queues[0];
    config.services = queues[1];
    config.node_id = rows[i].node_id;
    config.kbit_s = rows[i].kbit_s;
    config.queue_capacity = rows[i].capacity;
    config.sender.send = rows[i].sends ? bench_send : NULL;
    TEST_ASSERT_EQUAL(rows[i].good, canopen_node_init(&node, &config));
    if (rows[i].good) {
      TEST_ASSERT_EQUAL(rows[i].kbit_s == 0 ? BUS_DEFAULT_KBIT_S : rows[i].kbit_s, canopen_node_settings(&node).kbit_s);
    }
  }
  static od_part parts[CANOPEN_PARTS];
  canopen_config config = NODE->config;
  config.parts = parts;
  config.process_data = queues[0];
  config.services = queues[1];
  config.queue_capacity = 64;
  config.part_count = CANOPEN_PARTS - 2; /* two of them belong to the node */
  TEST_ASSERT_TRUE(canopen_node_init(&node, &config));
  config.part_count = CANOPEN_PARTS - 1;
  TEST_ASSERT_FALSE(canopen_node_init(&node, &config));
}

static void test_nmt_commands_move_the_node_when_addressed_to_it(void) {
  bench_nmt(1, 6);
  TEST_ASSERT_EQUAL(NMT_PRE_OPERATIONAL, NODE->state);
  bench_nmt(1, 0);
  TEST_ASSERT_EQUAL(NMT_OPERATIONAL, NODE->state);
  bench_nmt(128, BENCH_NODE);
  TEST_ASSERT_EQUAL(NMT_PRE_OPERATIONAL, NODE->state);
  bench_nmt(2, BENCH_NODE);
  TEST_ASSERT_EQUAL(NMT_STOPPED, NODE->state);
  bench_nmt(77, BENCH_NODE);
  TEST_ASSERT_EQUAL(NMT_STOPPED, NODE->state);
  const uint8_t too_long[3] = {1, BENCH_NODE, 0};
  bench_give(0, 3, too_long);
  bench_wait_ms(1);
  TEST_ASSERT_EQUAL(NMT_STOPPED, NODE->state);
}

/* State before, command and addressed node; state after, and what the node has to do. */
static void test_each_nmt_command_has_its_state_and_its_request(void) {
  static const struct {
    nmt_state before;
    uint8_t command, node_id;
    nmt_state after;
    nmt_request request;
  } rows[] = {
      {NMT_PRE_OPERATIONAL, 1, BENCH_NODE, NMT_OPERATIONAL, NMT_NOTHING},
      {NMT_OPERATIONAL, 2, BENCH_NODE, NMT_STOPPED, NMT_NOTHING},
      {NMT_STOPPED, 128, 0, NMT_PRE_OPERATIONAL, NMT_NOTHING},
      {NMT_OPERATIONAL, 129, BENCH_NODE, NMT_INITIALISING, NMT_RESET_NODE},
      {NMT_STOPPED, 130, 0, NMT_INITIALISING, NMT_RESET_COMMUNICATION},
      {NMT_OPERATIONAL, 130, BENCH_NODE + 1, NMT_OPERATIONAL, NMT_NOTHING},
      {NMT_OPERATIONAL, 3, BENCH_NODE, NMT_OPERATIONAL, NMT_NOTHING},
      {NMT_INITIALISING, 1, BENCH_NODE, NMT_INITIALISING, NMT_NOTHING},
      {NMT_INITIALISING, 129, BENCH_NODE, NMT_INITIALISING, NMT_NOTHING},
  };
  for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
    nmt_state state = rows[i].before;
    const can_frame frame = {.id = 0, .length = 2, .data = {rows[i].command, rows[i].node_id}};
    TEST_ASSERT_EQUAL(rows[i].request, nmt_receive(&state, BENCH_NODE, &frame));
    TEST_ASSERT_EQUAL(rows[i].after, state);
  }
}

static void test_reset_communication_brings_the_defaults_and_a_boot_up(void) {
  TEST_ASSERT_EQUAL_HEX32(0, bench_write(0x1015, 0, 7, 2));
  TEST_ASSERT_EQUAL_HEX32(0, bench_write(0x2F00, 5, 77, 1));
  strcpy(NODE->objects.hardware_version, "B2");
  bench.sent = 0;
  bench_nmt(130, BENCH_NODE);
  TEST_ASSERT_EQUAL(NMT_INITIALISING, NODE->state);
  TEST_ASSERT_EQUAL(0, bench.sent);
  bench_wait_ms(RESET_MS);
  TEST_ASSERT_EQUAL(0, bench.log[0].data[0]);
  TEST_ASSERT_EQUAL(0, NODE->objects.emergency.inhibit_100us);
  TEST_ASSERT_EQUAL(4711, NODE->objects.serial_number);
  TEST_ASSERT_EQUAL_STRING("B2", NODE->objects.hardware_version);
  TEST_ASSERT_EQUAL(77, bench.device.values.u8);
  TEST_ASSERT_EQUAL_HEX32(0x10001, bench.device.resets);
  bench_nmt(129, BENCH_NODE);
  bench_wait_ms(RESET_MS);
  TEST_ASSERT_EQUAL_HEX32(0x20001, bench.device.resets);
}

/* Identify a node with the revision 1: the last of six requests has an answer, in the ms after it. */
static void test_lss_is_answered_during_a_reset(void) {
  const uint32_t numbers[6] = {0, 0x54534456, 1, 1, 4711, 4711};
  bench_nmt(130, BENCH_NODE);
  bench.sent = 0;
  for (uint32_t step = 0; step < 6; step++) {
    const uint32_t number = numbers[step];
    const uint8_t request[8] = {(uint8_t)(0x46 + step), (uint8_t)number, (uint8_t)(number >> 8),
                                (uint8_t)(number >> 16), (uint8_t)(number >> 24)};
    bench_give(0x7E5, 8, request);
  }
  bench_wait_ms(1);
  TEST_ASSERT_EQUAL(NMT_INITIALISING, NODE->state);
  TEST_ASSERT_EQUAL(1, bench_count(0x7E4));
  TEST_ASSERT_EQUAL_HEX8(0x4F, bench_last(0x7E4)->data[0]);
}

static void test_heartbeat_comes_on_time_with_the_state(void) {
  TEST_ASSERT_EQUAL_HEX32(0, bench_write(0x1017, 0, 10, 2));
  bench.sent = 0;
  bench_wait_ms(100);
  TEST_ASSERT_EQUAL(10, bench_count(0x705));
  TEST_ASSERT_EQUAL(1, bench_last(0x705)->length);
  TEST_ASSERT_EQUAL(127, bench_last(0x705)->data[0]);
  bench_operational();
  bench_wait_ms(10);
  TEST_ASSERT_EQUAL(5, bench_last(0x705)->data[0]);
}

static void test_lost_master_is_reported_and_stops_pdos(void) {
  const uint8_t alive[1] = {5};
  TEST_ASSERT_EQUAL_HEX32(0, bench_write(0x1016, 1, 0x00010032, 4));
  bench_operational();
  bench_wait_ms(200); /* never heard: not monitored */
  TEST_ASSERT_EQUAL(NMT_OPERATIONAL, NODE->state);
  bench_give(0x701, 1, alive);
  bench_wait_ms(49);
  TEST_ASSERT_EQUAL(NMT_OPERATIONAL, NODE->state);
  bench_wait_ms(3);
  TEST_ASSERT_EQUAL(NMT_PRE_OPERATIONAL, NODE->state);
  TEST_ASSERT_EQUAL(1, bench.device.heartbeats_lost);
  TEST_ASSERT_EQUAL_HEX8(0x30, bench_last(0x85)->data[0]);
  TEST_ASSERT_EQUAL_HEX8(0x81, bench_last(0x85)->data[1]);
  TEST_ASSERT_EQUAL_HEX8(0x11, bench_last(0x85)->data[2]);
  TEST_ASSERT_EQUAL(1, bench_last(0x85)->data[3]);
  bench_give(0x701, 1, alive);
  bench_wait_ms(2);
  TEST_ASSERT_EQUAL_HEX8(0, bench_last(0x85)->data[1]);
  TEST_ASSERT_EQUAL(0, NODE->objects.emergency.error_register);
}

static void test_error_behaviour_can_be_none_or_stopped(void) {
  const uint8_t alive[1] = {5};
  TEST_ASSERT_EQUAL_HEX32(0, bench_write(0x1016, 1, 0x00010005, 4));
  for (uint8_t behaviour = 1; behaviour <= 2; behaviour++) {
    bench_nmt(128, 0);
    TEST_ASSERT_EQUAL_HEX32(0, bench_write(0x1029, 1, behaviour, 1));
    bench_operational();
    bench_give(0x701, 1, alive);
    bench_wait_ms(10);
    TEST_ASSERT_EQUAL(behaviour == 1 ? NMT_OPERATIONAL : NMT_STOPPED, NODE->state);
  }
}

static void test_one_node_is_monitored_by_one_consumer_only(void) {
  TEST_ASSERT_EQUAL_HEX32(0, bench_write(0x1016, 1, 0x00010032, 4));
  TEST_ASSERT_EQUAL_HEX32(0x06040043, bench_write(0x1016, 2, 0x00010064, 4));
  TEST_ASSERT_EQUAL_HEX32(0, bench_write(0x1016, 1, 0x00010064, 4));
  TEST_ASSERT_EQUAL_HEX32(0, bench_write(0x1016, 3, 0x00070064, 4));
  TEST_ASSERT_EQUAL_HEX32(0x06040043, bench_write(0x1016, 4, 0x00070032, 4)); /* whichever has it */
}

static bool is_busy;
static uint32_t taken;

static bool send_if_free(void *context, const can_frame *frame) {
  (void)context;
  (void)frame;
  taken += is_busy ? 0u : 1u;
  return !is_busy;
}

/* No transmit buffer is free for three ms. */
static void test_an_emergency_that_the_controller_does_not_take_waits(void) {
  emergency_producer producer;
  emergency_objects objects = {.cob_id = 0x85, .inhibit_100us = 20};
  emergency_reset(&producer, &objects);
  const emergency_error hot = {.code = 0x4310, .register_bits = ERROR_TEMPERATURE, .source = 1};
  TEST_ASSERT_TRUE(emergency_raise(&producer, &objects, &hot));
  const can_sender sender = {send_if_free, NULL};
  is_busy = true;
  taken = 0;
  for (int ms = 0; ms < 3; ++ms) {
    emergency_tick(&producer, &objects, &sender);
    TEST_ASSERT_EQUAL(1, producer.waiting_count);
    TEST_ASSERT_EQUAL(0, producer.inhibit_ms);
  }
  is_busy = false;
  emergency_tick(&producer, &objects, &sender);
  TEST_ASSERT_EQUAL(1, taken);
  TEST_ASSERT_EQUAL(0, producer.waiting_count);
  TEST_ASSERT_EQUAL(2, producer.inhibit_ms);
}

static void test_emergency_is_reported_once_kept_in_the_history_and_cleared(void) {
  const emergency_error hot = {.code = 0x4310, .register_bits = ERROR_TEMPERATURE, .source = 1, .detail = 9};
  for (uint32_t i = 0; i < 5; i++) {
    TEST_ASSERT_EQUAL(i == 0, canopen_node_raise(NODE, &hot));
    bench_wait_ms(1);
  }
  TEST_ASSERT_EQUAL(1, bench_count(0x85));
  TEST_ASSERT_EQUAL_HEX8(0x09, bench_last(0x85)->data[2]);
  TEST_ASSERT_EQUAL(9, bench_last(0x85)->data[3]);
  TEST_ASSERT_EQUAL(1, bench_last(0x85)->data[4]);
  TEST_ASSERT_EQUAL_HEX32(0x09, bench_get(0x1001, 0));
  TEST_ASSERT_EQUAL_HEX32(1, bench_get(0x1003, 0));
  TEST_ASSERT_EQUAL_HEX32(0x01094310, bench_get(0x1003, 1));
  TEST_ASSERT_TRUE(canopen_node_clear(NODE, 1, 0x4310));
  TEST_ASSERT_FALSE(canopen_node_clear(NODE, 1, 0x4310));
  bench_wait_ms(2);
  TEST_ASSERT_EQUAL_HEX8(0, bench_last(0x85)->data[1]);
  TEST_ASSERT_EQUAL_HEX32(0, bench_get(0x1001, 0));
  TEST_ASSERT_EQUAL_HEX32(0, bench_write(0x1003, 0, 0, 1));
  TEST_ASSERT_EQUAL_HEX32(0, bench_get(0x1003, 0));
}

/* A second temperature is too high, and so is a current: one error, reported twice, with the bits of both. */
static void test_an_error_that_is_raised_again_is_reported_again_and_cleared_once(void) {
  const emergency_error hot = {.code = 0x4310, .register_bits = ERROR_TEMPERATURE, .source = 1};
  const emergency_error hotter = {.code = 0x4310, .register_bits = ERROR_CURRENT, .source = 1, .detail = 9};
  TEST_ASSERT_TRUE(canopen_node_raise_again(NODE, &hot));
  TEST_ASSERT_EQUAL_HEX8(ERROR_GENERIC | ERROR_TEMPERATURE, NODE->objects.emergency.error_register);
  TEST_ASSERT_TRUE(canopen_node_raise_again(NODE, &hotter));
  const uint8_t both = ERROR_GENERIC | ERROR_TEMPERATURE | ERROR_CURRENT;
  TEST_ASSERT_EQUAL_HEX8(both, NODE->objects.emergency.error_register);
  bench_wait_ms(5);
  TEST_ASSERT_EQUAL(2, bench_count(0x85));
  TEST_ASSERT_EQUAL_HEX8_ARRAY(((const uint8_t[]){0x10, 0x43, both, 9, 1, 0, 0, 0}), bench_last(0x85)->data, 8);
  TEST_ASSERT_EQUAL(2, NODE->objects.emergency.count);
  TEST_ASSERT_TRUE(canopen_node_clear(NODE, 1, 0x4310));
  TEST_ASSERT_EQUAL_HEX8(0, NODE->objects.emergency.error_register);
  TEST_ASSERT_FALSE(canopen_node_clear(NODE, 1, 0x4310));
}

static void test_the_same_error_of_two_sources_is_over_when_both_are(void) {
  for (uint8_t source = 1; source <= 2; source++) {
    const emergency_error error = {.code = 0x8611, .register_bits = ERROR_MANUFACTURER, .source = source};
    TEST_ASSERT_TRUE(canopen_node_raise(NODE, &error));
  }
  bench_wait_ms(2);
  TEST_ASSERT_EQUAL(2, bench_count(0x85));
  TEST_ASSERT_FALSE(canopen_node_clear(NODE, EMERGENCY_SOURCE_NODE, 0x8611));
  TEST_ASSERT_TRUE(canopen_node_clear(NODE, 1, 0x8611));
  TEST_ASSERT_EQUAL_HEX32(0x81, bench_get(0x1001, 0));
  TEST_ASSERT_TRUE(canopen_node_clear(NODE, 2, 0x8611));
  TEST_ASSERT_EQUAL_HEX32(0, bench_get(0x1001, 0));
}

static void test_inhibit_time_spaces_emergencies_and_the_history_keeps_eight(void) {
  TEST_ASSERT_EQUAL_HEX32(0, bench_write(0x1015, 0, 100, 2)); /* 10 ms */
  bench.sent = 0;
  for (uint16_t i = 0; i < 10; i++) {
    const emergency_error error = {.code = (uint16_t)(0xFF00 + i), .register_bits = ERROR_MANUFACTURER};
    TEST_ASSERT_TRUE(canopen_node_raise(NODE, &error));
  }
  bench_wait_ms(25);
  TEST_ASSERT_EQUAL(3, bench_count(0x85));
  bench_wait_ms(100);
  TEST_ASSERT_EQUAL(8, bench_count(0x85));
  TEST_ASSERT_EQUAL(2, NODE->emergency.dropped);
  TEST_ASSERT_EQUAL_HEX32(8, bench_get(0x1003, 0));
  TEST_ASSERT_EQUAL_HEX32(0xFF09, bench_get(0x1003, 1));
  TEST_ASSERT_EQUAL_HEX32(0xFF02, bench_get(0x1003, 8));
}

static void test_missing_sync_is_reported_after_one_and_a_half_periods(void) {
  TEST_ASSERT_EQUAL_HEX32(0, bench_write(0x1006, 0, 10000, 4));
  for (uint32_t i = 0; i < 10; i++) {
    bench_give(0x80, 0, NULL);
    bench_wait_ms(10);
  }
  TEST_ASSERT_FALSE(emergency_is_active(&NODE->emergency, 0, EMERGENCY_SYNC_TIME_OUT));
  for (int round = 0; round < 3; round++) {
    bench_wait_ms(16);
    TEST_ASSERT_TRUE(emergency_is_active(&NODE->emergency, 0, EMERGENCY_SYNC_TIME_OUT));
    bench_give(0x80, 0, NULL);
    bench_wait_ms(1);
    TEST_ASSERT_FALSE(emergency_is_active(&NODE->emergency, 0, EMERGENCY_SYNC_TIME_OUT));
  }
}

static bool clock_is_off(void) { return emergency_is_active(&NODE->emergency, 0, EMERGENCY_SYNC_CLOCK); }

static void give_syncs(uint32_t count, uint32_t ms) {
  for (uint32_t i = 0; i < count; i++) {
    bench_give(0x80, 0, NULL);
    bench_wait_ms(ms);
  }
}

static void test_a_clock_that_differs_from_sync_by_1_percent_is_reported_while_it_does(void) {
  TEST_ASSERT_EQUAL_HEX32(0, bench_write(0x1006, 0, 100000, 4));
  give_syncs(70, 100);
  TEST_ASSERT_FALSE(clock_is_off());
  give_syncs(70, 101);
  TEST_ASSERT_TRUE(clock_is_off());
  give_syncs(70, 100);
  TEST_ASSERT_FALSE(clock_is_off());
  give_syncs(70, 99);
  TEST_ASSERT_TRUE(clock_is_off());
  TEST_ASSERT_EQUAL_HEX32(0, bench_write(0x1006, 0, 100000, 4)); /* the same again: it is judged anew */
  TEST_ASSERT_FALSE(clock_is_off());
  give_syncs(70, 99);
  TEST_ASSERT_TRUE(clock_is_off());
  TEST_ASSERT_EQUAL_HEX32(0, bench_write(0x1006, 0, 99000, 4));
  TEST_ASSERT_FALSE(clock_is_off());
  give_syncs(70, 99);
  TEST_ASSERT_FALSE(clock_is_off());
}

/* A counter that was not agreed on, and one that is missing (1019). */
static void test_sync_of_the_wrong_length_only_reports_an_error(void) {
  const uint8_t counter[1] = {1};
  for (uint8_t agreed = 0; agreed <= 1; agreed++) {
    bench_start();
    TEST_ASSERT_EQUAL_HEX32(0, bench_write(0x1019, 0, agreed == 0 ? 0 : 10, 1));
    bench_operational();
    bench.sent = 0;
    bench_give(0x80, agreed == 0 ? 1 : 0, counter);
    bench_wait_ms(1);
    TEST_ASSERT_EQUAL(0, bench_count(0x285));
    TEST_ASSERT_TRUE(emergency_is_active(&NODE->emergency, 0, EMERGENCY_SYNC_LENGTH));
  }
}

/* It is reported when the node has left the state. */
static void test_a_stopped_node_sends_no_emergency(void) {
  bench_nmt(2, BENCH_NODE);
  bench.sent = 0;
  TEST_ASSERT_TRUE(canopen_node_raise(NODE, &(emergency_error){.code = 0x5530}));
  bench_wait_ms(50);
  TEST_ASSERT_EQUAL(0, bench_count(0x85));
  bench_nmt(128, BENCH_NODE);
  bench_wait_ms(2);
  TEST_ASSERT_EQUAL(1, bench_count(0x85));
}

static void test_store_and_restore_want_their_signatures(void) {
  TEST_ASSERT_EQUAL_HEX32(0, bench_write(0x1010, 1, 0x65766173, 4));
  TEST_ASSERT_EQUAL_HEX32(0, bench_write(0x1011, 1, 0x64616F6C, 4));
  TEST_ASSERT_EQUAL(1, bench.device.saves);
  TEST_ASSERT_EQUAL(1, bench.device.loads);
  TEST_ASSERT_EQUAL_HEX32(1, bench_get(0x1010, 1));
  TEST_ASSERT_EQUAL_HEX32(1, bench_get(0x1011, 1));
  bench.device.store_broken = true;
  TEST_ASSERT_EQUAL_HEX32(0x06060000, bench_write(0x1010, 1, 0x65766173, 4));
  TEST_ASSERT_EQUAL(1, bench.device.saves);
}

static void test_foreign_frames_change_nothing_and_get_no_answer(void) {
  bench_operational();
  bench_wait_ms(20);
  const communication_objects objects = NODE->objects;
  const test_values values = bench.device.values;
  bench.sent = 0;
  for (uint32_t id = 0; id <= 0x7FF; id++) {
    const bool ours = id == 0 || id == 0x80 || id == 0x205 || id == 0x305 || id == 0x605;
    for (uint8_t length = 0; length <= 8 && !ours; length++) {
      const uint8_t bytes[8] = {0x2F, 0x00, 0x2F, 5, 99, 0, 0, 0};
      bench_give(id, length, bytes);
      bench_wait_ms(1);
    }
  }
  for (uint32_t id = 0; id <= 0x7FF; id++) {
    can_frame frame = {.id = id, .flags = CAN_FRAME_EXTENDED, .length = 8, .data = {0x2F, 0x00, 0x2F, 5, 99}};
    (void)canopen_node_receive(NODE, &frame);
    frame.flags = CAN_FRAME_REMOTE;
    (void)canopen_node_receive(NODE, &frame);
    bench_wait_ms(1);
  }
  TEST_ASSERT_EQUAL(0, bench.sent);
  TEST_ASSERT_EQUAL_MEMORY(&objects, &NODE->objects, sizeof objects);
  TEST_ASSERT_EQUAL_MEMORY(&values, &bench.device.values, sizeof values);
}

static void flood(uint32_t id) {
  const uint8_t bytes[8] = {1};
  for (uint32_t i = 0; i < 1000; i++) {
    for (uint32_t k = 0; k < 40; k++) { /* five times what the bus can deliver */
      bench_give(id, 8, bytes);
    }
    const uint32_t before = can_queue_overruns(&NODE->process_data);
    bench_wait_ms(1);
    TEST_ASSERT_EQUAL(before, can_queue_overruns(&NODE->process_data));
  }
}

static void test_flood_is_handled_piecewise_reported_and_does_not_stop_heartbeats(void) {
  TEST_ASSERT_EQUAL_HEX32(0, bench_write(0x1017, 0, 10, 2));
  bench.sent = 0;
  flood(0x205);
  TEST_ASSERT_EQUAL(100, bench_count(0x705));
  TEST_ASSERT_EQUAL_HEX8(0x10, bench_last(0x85)->data[0]);
  TEST_ASSERT_EQUAL_HEX8(0x81, bench_last(0x85)->data[1]);
  bench_wait_ms(1100);
  TEST_ASSERT_FALSE(emergency_is_active(&NODE->emergency, 0, EMERGENCY_CAN_OVERRUN));
}

static void test_frames_that_the_controller_lost_are_reported_as_an_overrun(void) {
  bench_wait_ms(5);
  TEST_ASSERT_FALSE(emergency_is_active(&NODE->emergency, 0, EMERGENCY_CAN_OVERRUN));
  canopen_node_lost_frames(NODE, 1);
  bench_wait_ms(1);
  TEST_ASSERT_TRUE(emergency_is_active(&NODE->emergency, 0, EMERGENCY_CAN_OVERRUN));
  canopen_node_lost_frames(NODE, 1); /* no new one */
  bench_wait_ms(1100);
  TEST_ASSERT_FALSE(emergency_is_active(&NODE->emergency, 0, EMERGENCY_CAN_OVERRUN));
}

/* PDOs, SDO requests and heartbeats of others pass the controller's filters, but fill no queue. */
static void test_a_flood_of_frames_for_others_loses_nothing(void) {
  const uint32_t others[] = {0x081, 0x123, 0x204, 0x57F, 0x604, 0x6DF, 0x700, 0x77F};
  for (uint32_t i = 0; i < sizeof others / sizeof others[0]; i++) {
    flood(others[i]);
  }
  TEST_ASSERT_EQUAL(0, can_queue_overruns(&NODE->process_data) + can_queue_overruns(&NODE->services));
  TEST_ASSERT_FALSE(emergency_is_active(&NODE->emergency, 0, EMERGENCY_CAN_OVERRUN));
}

static void test_bus_off_is_reported_after_the_recovery(void) {
  bench_operational();
  bench_wait_ms(20);
  canopen_node_bus_off_recovered(NODE);
  bench_wait_ms(2);
  TEST_ASSERT_EQUAL(2, bench_count(0x85));
  TEST_ASSERT_EQUAL_HEX32(0x8140, bench_get(0x1003, 1));
  TEST_ASSERT_EQUAL(NMT_PRE_OPERATIONAL, NODE->state);
}

static void test_a_reset_clears_the_error_register_and_what_waits_to_be_sent(void) {
  const emergency_error hot = {.code = 0x4310, .register_bits = ERROR_TEMPERATURE, .source = 1};
  TEST_ASSERT_EQUAL_HEX32(0, bench_get(0x1001, 0));
  TEST_ASSERT_TRUE(canopen_node_raise(NODE, &hot));
  bench_nmt(130, BENCH_NODE);
  bench.sent = 0;
  bench_wait_ms(RESET_MS + 5);
  TEST_ASSERT_EQUAL(0, bench_count(0x85));
  TEST_ASSERT_EQUAL_HEX32(0, bench_get(0x1001, 0));
}

/* The master reads a story: what came first is reported first, also when the messages must wait for each other. */
static void test_emergencies_come_in_the_order_of_their_errors(void) {
  TEST_ASSERT_EQUAL_HEX32(0, bench_write(0x1015, 0, 20, 2)); /* 2 ms */
  for (uint16_t round = 0; round < 3; round++) {
    bench.sent = 0;
    for (uint16_t i = 0; i < 5; i++) {
      const emergency_error error = {
          .code = (uint16_t)(0xFF00 + 16 * round + i), .register_bits = ERROR_MANUFACTURER, .detail = (uint8_t)i};
      TEST_ASSERT_TRUE(canopen_node_raise(NODE, &error));
    }
    bench_wait_ms(20);
    TEST_ASSERT_EQUAL(5, bench_count(0x85));
    for (uint16_t i = 0; i < 5; i++) {
      TEST_ASSERT_EQUAL_HEX8(16 * round + i, bench.log[i].data[0]);
      TEST_ASSERT_EQUAL(i, bench.log[i].data[3]);
    }
  }
}

static bool is_active(uint16_t code) { return emergency_is_active(&NODE->emergency, EMERGENCY_SOURCE_NODE, code); }

static void test_two_nodes_lost_at_once_are_both_reported_in_that_ms(void) {
  const uint8_t alive[1] = {5};
  TEST_ASSERT_EQUAL_HEX32(0, bench_write(0x1016, 1, 0x00010032, 4));
  TEST_ASSERT_EQUAL_HEX32(0, bench_write(0x1016, 2, 0x00020032, 4));
  bench_operational();
  bench_give(0x701, 1, alive);
  bench_give(0x702, 1, alive);
  bench_wait_ms(49);
  TEST_ASSERT_EQUAL(0, bench.device.heartbeats_lost);
  bench_wait_ms(1);
  TEST_ASSERT_EQUAL(1 + 2, bench.device.heartbeats_lost); /* the sum of their node ids */
}

/* As a stored set gives them: two of the four consumers monitor node 1, or one of them is off or has another node. */
static void test_two_stored_consumers_of_one_node_are_not_good(void) {
  static const struct {
    uint32_t consumer;
    bool good;
  } others[] = {{0x00010064, false}, {0x00010032, false}, {0x00010000, true}, {0x00020032, true}};
  TEST_ASSERT_TRUE(node_objects_are_good(&NODE->dictionary, &NODE->objects));
  for (uint32_t n = 0; n < 4; n++) {
    for (uint32_t k = 0; k < 4; k++) {
      for (size_t i = 0; i < sizeof others / sizeof others[0] && k != n; i++) {
        communication_objects stored = NODE->objects;
        stored.heartbeat_consumer[n] = 0x00010032;
        stored.heartbeat_consumer[k] = others[i].consumer;
        TEST_ASSERT_EQUAL(others[i].good, node_objects_are_good(&NODE->dictionary, &stored));
      }
    }
  }
}

static bool put_stored_consumer(void *context, bool whole_node, uint32_t step) {
  (void)context;
  (void)whole_node;
  (void)step;
  NODE->objects.heartbeat_consumer[0] = 0x0001000A;
  return true;
}

/* CiA 301: an initialising node has no service but its boot-up message. The bus is full, so that it initialises for
 * 50 ms; its consumer of 10 ms was stored. The master speaks before the boot-up message, and then after it. */
static void test_a_heartbeat_before_the_boot_up_message_is_not_monitored(void) {
  const uint8_t alive[1] = {5};
  NODE->config.events.reset = put_stored_consumer;
  bench.bus_full = true;
  bench_nmt(130, BENCH_NODE);
  bench_wait_ms(RESET_MS);
  bench_give(0x701, 1, alive);
  bench_wait_ms(50);
  TEST_ASSERT_EQUAL(NMT_INITIALISING, NODE->state);
  TEST_ASSERT_EQUAL(0, bench.device.heartbeats_lost);
  bench.bus_full = false;
  bench_wait_ms(50);
  TEST_ASSERT_EQUAL(NMT_PRE_OPERATIONAL, NODE->state);
  TEST_ASSERT_EQUAL(0, bench.device.heartbeats_lost);
  bench_give(0x701, 1, alive);
  bench_wait_ms(50);
  TEST_ASSERT_EQUAL(1, bench.device.heartbeats_lost);
}

static void test_a_lost_heartbeat_is_over_when_each_lost_node_is_back(void) {
  const uint8_t alive[1] = {5};
  TEST_ASSERT_EQUAL_HEX32(0, bench_write(0x1016, 1, 0x00010032, 4));
  TEST_ASSERT_EQUAL_HEX32(0, bench_write(0x1016, 2, 0x00020032, 4));
  bench_give(0x701, 1, alive);
  bench_give(0x702, 1, alive);
  bench_wait_ms(60);
  bench_give(0x701, 1, alive);
  bench_wait_ms(2);
  TEST_ASSERT_TRUE(is_active(0x8130)); /* node 2 is still away */
  bench_give(0x702, 1, alive);
  bench_wait_ms(2);
  TEST_ASSERT_FALSE(is_active(0x8130));
}

/* One of four consumers has lost its node; the others hear theirs. */
static void test_a_consumer_that_is_set_anew_forgets_its_lost_node_alone(void) {
  const uint8_t alive[1] = {5};
  for (uint8_t lost = 1; lost <= 4; lost++) {
    bench_start();
    for (uint8_t n = 1; n <= 4; n++) {
      TEST_ASSERT_EQUAL_HEX32(0, bench_write(0x1016, n, (uint32_t)n << 16 | (n == lost ? 10 : 100), 4));
      bench_give(0x700u + n, 1, alive);
    }
    bench_wait_ms(20);
    TEST_ASSERT_TRUE(is_active(0x8130));
    TEST_ASSERT_EQUAL_HEX32(0, bench_write(0x1016, lost, 0, 4));
    TEST_ASSERT_FALSE(is_active(0x8130));
    bench_wait_ms(100);
    TEST_ASSERT_EQUAL(1 + 2 + 3 + 4, bench.device.heartbeats_lost); /* now the others, too: the sum of the node ids */
  }
}

/* Consumer 1 has lost node 1; after the reset, consumer 2 loses node 2 and hears it again. */
static void test_a_node_that_was_lost_before_a_reset_is_not_missed_after_it(void) {
  const uint8_t alive[1] = {5};
  TEST_ASSERT_EQUAL_HEX32(0, bench_write(0x1016, 1, 0x0001000A, 4));
  bench_give(0x701, 1, alive);
  bench_wait_ms(20);
  TEST_ASSERT_TRUE(is_active(0x8130));
  bench_nmt(130, BENCH_NODE);
  bench_wait_ms(RESET_MS);
  TEST_ASSERT_FALSE(is_active(0x8130));
  TEST_ASSERT_EQUAL_HEX32(0, bench_write(0x1016, 2, 0x0002000A, 4));
  bench_give(0x702, 1, alive);
  bench_wait_ms(20);
  TEST_ASSERT_TRUE(is_active(0x8130));
  bench_give(0x702, 1, alive);
  bench_wait_ms(2);
  TEST_ASSERT_FALSE(is_active(0x8130));
}

/* A time of 0 switches a consumer off; 1 ms is the shortest. */
static void test_a_heartbeat_is_monitored_from_1_ms_on(void) {
  const uint8_t alive[1] = {5};
  for (uint32_t time_ms = 0; time_ms <= 1; time_ms++) {
    TEST_ASSERT_EQUAL_HEX32(0, bench_write(0x1016, 1, 0x00010000 | time_ms, 4));
    bench_give(0x701, 1, alive);
    bench_wait_ms(10);
    TEST_ASSERT_EQUAL(time_ms, bench.device.heartbeats_lost);
  }
}

/* Vendor, product, revision and serial number of 1018h, each by its own request of LSS. */
static void test_lss_selects_the_node_by_its_identity(void) {
  const uint32_t identity[4] = {0, 0x54534456, 1, 4711};
  for (uint32_t wrong = 0; wrong <= 4; wrong++) { /* the last one: none is wrong */
    bench.sent = 0;
    for (uint32_t part = 0; part < 4; part++) {
      const uint32_t number = identity[part] + (part == wrong ? 1u : 0u);
      const uint8_t request[8] = {(uint8_t)(0x40 + part), (uint8_t)number, (uint8_t)(number >> 8),
                                  (uint8_t)(number >> 16), (uint8_t)(number >> 24)};
      bench_give(0x7E5, 8, request);
      bench_wait_ms(1);
    }
    TEST_ASSERT_EQUAL(wrong == 4 ? 1 : 0, bench_count(0x7E4));
  }
  TEST_ASSERT_EQUAL_HEX8(0x44, bench_last(0x7E4)->data[0]);
}

/* Vendor and product are asked for in one ms: the second answer does not replace the first. */
static void test_lss_requests_that_come_together_are_each_answered(void) {
  const uint8_t configure[8] = {0x04, 1};
  bench_give(0x7E5, 8, configure);
  bench_wait_ms(1);
  bench.sent = 0;
  bench_give(0x7E5, 8, (const uint8_t[8]){0x5A});
  bench_give(0x7E5, 8, (const uint8_t[8]){0x5B});
  bench_wait_ms(1);
  TEST_ASSERT_EQUAL(2, bench_count(0x7E4));
  TEST_ASSERT_EQUAL_HEX8_ARRAY(((const uint8_t[]){0x5A, 0, 0, 0, 0}), bench.log[0].data, 5);
  TEST_ASSERT_EQUAL_HEX8_ARRAY(((const uint8_t[]){0x5B, 0x56, 0x44, 0x53, 0x54}), bench.log[1].data, 5);
}

/* Inhibit times are rounded up to whole ms. */
static void test_the_inhibit_time_of_emergencies_is_never_shorter_than_set(void) {
  static const struct {
    uint16_t inhibit_100us, ms;
  } times[] = {{0, 0}, {1, 1}, {9, 1}, {10, 1}, {11, 2}, {19, 2}, {20, 2}, {21, 3}, {65535, 6554}};
  const can_sender sender = {send_if_free, NULL};
  is_busy = false;
  for (size_t i = 0; i < sizeof times / sizeof times[0]; i++) {
    emergency_producer producer;
    emergency_objects objects = {.cob_id = 0x85, .inhibit_100us = times[i].inhibit_100us};
    emergency_reset(&producer, &objects);
    const emergency_error hot = {.code = 0x4310, .register_bits = ERROR_TEMPERATURE, .source = 1};
    TEST_ASSERT_TRUE(emergency_raise(&producer, &objects, &hot));
    TEST_ASSERT_TRUE(emergency_clear(&producer, &objects, 1, 0x4310));
    taken = 0;
    emergency_tick(&producer, &objects, &sender);
    TEST_ASSERT_EQUAL(1, taken);
    TEST_ASSERT_EQUAL(times[i].ms, producer.inhibit_ms);
    uint32_t waited_ms = 0;
    while (taken < 2 && waited_ms < 10000) {
      emergency_tick(&producer, &objects, &sender);
      waited_ms++;
    }
    TEST_ASSERT_EQUAL(times[i].ms > 1 ? times[i].ms : 1, waited_ms);
  }
}

/* Ticks without a SYNC until it is late; 0: not within 5,000,000. */
static uint32_t ticks_until_late(uint32_t period_us) {
  const sync_objects objects = {.cob_id = 0x80, .period_us = period_us};
  const can_frame frame = {.id = 0x80, .length = 0};
  sync_consumer consumer;
  sync_reset(&consumer);
  TEST_ASSERT_EQUAL(SYNC_GOOD, sync_receive(&consumer, &objects, &frame));
  for (uint32_t tick = 1; tick <= 5000000; tick++) {
    if (sync_tick(&consumer, &objects)) {
      TEST_ASSERT_FALSE(sync_tick(&consumer, &objects)); /* reported once */
      return tick;
    }
  }
  return 0;
}

static void test_a_sync_is_late_in_the_first_ms_after_one_and_a_half_periods(void) {
  TEST_ASSERT_EQUAL(0, ticks_until_late(0));
  TEST_ASSERT_EQUAL(3, ticks_until_late(1000));
  TEST_ASSERT_EQUAL(4, ticks_until_late(2000));
  TEST_ASSERT_EQUAL(16, ticks_until_late(10000));
  TEST_ASSERT_EQUAL(1501, ticks_until_late(1000000));
  TEST_ASSERT_EQUAL(3000001, ticks_until_late(2000000000));
  TEST_ASSERT_EQUAL(0, ticks_until_late(UINT32_MAX)); /* one and a half of it is more than the count holds */
  TEST_ASSERT_EQUAL(0, ticks_until_late(UINT32_MAX / 2 + 1000000));
}

static void test_without_a_first_sync_none_is_late(void) {
  const sync_objects objects = {.cob_id = 0x80, .period_us = 1000};
  sync_consumer consumer;
  sync_reset(&consumer);
  for (uint32_t tick = 0; tick < 1000; tick++) {
    TEST_ASSERT_FALSE(sync_tick(&consumer, &objects));
  }
}

/* Two nodes, one in memory that held the objects and counts of another. */
static void test_a_node_takes_over_no_objects_and_counts_from_before(void) {
  static canopen_node clean, used;
  static can_frame queues[4][TEST_DEVICE_QUEUE];
  canopen_config config = NODE->config;
  memset(&clean, 0, sizeof clean);
  memset(&used, 0, sizeof used);
  memset(&used.objects, 0x55, sizeof used.objects);
  used.controller_overruns = used.overruns_reported = 7;
  used.overrun_quiet_ms = 7;
  used.silent_ms = 7;
  used.sdo_client = 0;
  used.producer.elapsed_ms = 7;
  config.parts = &NODE->parts[NODE->dictionary.count - config.part_count]; /* the first two belong to the node */
  config.process_data = queues[0];
  config.services = queues[1];
  TEST_ASSERT_TRUE(canopen_node_init(&clean, &config));
  config.process_data = queues[2];
  config.services = queues[3];
  TEST_ASSERT_TRUE(canopen_node_init(&used, &config));
  TEST_ASSERT_EQUAL_MEMORY(&clean.objects, &used.objects, sizeof clean.objects);
  TEST_ASSERT_EQUAL(0, used.objects.serial_number);
  TEST_ASSERT_EQUAL_STRING("", used.objects.hardware_version);
  TEST_ASSERT_EQUAL(0, used.controller_overruns);
  TEST_ASSERT_EQUAL(0, used.overruns_reported);
  TEST_ASSERT_EQUAL(0, used.overrun_quiet_ms);
  TEST_ASSERT_EQUAL(0, used.silent_ms);
  TEST_ASSERT_EQUAL(SDO_CHANNELS, used.sdo_client);
  TEST_ASSERT_EQUAL(0, used.producer.elapsed_ms);
  for (int ms = 0; ms < 3; ms++) {
    canopen_node_tick(&clean);
    canopen_node_tick(&used);
    TEST_ASSERT_EQUAL(clean.state, used.state);
  }
  TEST_ASSERT_EQUAL(NMT_PRE_OPERATIONAL, used.state);
  TEST_ASSERT_EQUAL(0, used.emergency.waiting_count);
}

static void test_the_silence_of_the_master_is_counted_from_its_last_frame_in_each_ms(void) {
  bench_nmt(128, BENCH_NODE);
  const uint32_t begun_ms = canopen_node_silent_ms(NODE);
  TEST_ASSERT_EQUAL(1, begun_ms); /* the tick that handled the frame */
  for (uint32_t ms = 1; ms <= 50; ms++) {
    bench_wait_ms(1);
    TEST_ASSERT_EQUAL(begun_ms + ms, canopen_node_silent_ms(NODE));
  }
  NODE->silent_ms = UINT32_MAX - 1; /* 49 days */
  bench_wait_ms(3);
  TEST_ASSERT_EQUAL_HEX32(UINT32_MAX, canopen_node_silent_ms(NODE));
}

/* Node 127 is the last one; a heartbeat has one byte. */
static void test_only_a_heartbeat_of_one_byte_counts(void) {
  const uint8_t alive[2] = {5, 5};
  TEST_ASSERT_EQUAL_HEX32(0, bench_write(0x1016, 4, 0x007F0032, 4));
  for (uint8_t length = 0; length <= 2; length += 2) { /* not monitored yet */
    bench_give(0x77F, length, alive);
    bench_wait_ms(60);
    TEST_ASSERT_EQUAL(0, bench.device.heartbeats_lost);
  }
  bench_give(0x77F, 1, alive);
  bench_wait_ms(30);
  bench_give(0x77F, 2, alive); /* no new one */
  bench_wait_ms(30);
  TEST_ASSERT_EQUAL(127, bench.device.heartbeats_lost);
  bench_wait_ms(200);
  TEST_ASSERT_EQUAL(127, bench.device.heartbeats_lost); /* lost once */
  for (uint32_t again = 2; again <= 3; again++) {
    bench_give(0x77F, 1, alive);
    bench_wait_ms(60);
    TEST_ASSERT_EQUAL(127 * again, bench.device.heartbeats_lost);
  }
}

/* CiA 301: monitoring starts with the first heartbeat. A master that boots has forgotten what it has ordered. */
static void test_a_boot_up_starts_no_monitoring_and_is_the_loss_of_a_monitored_node(void) {
  const uint8_t booted[1] = {0};
  const uint8_t alive[1] = {5};
  TEST_ASSERT_EQUAL_HEX32(0, bench_write(0x1016, 1, 0x00010032, 4));
  bench_operational();
  bench_give(0x701, 1, booted);
  bench_wait_ms(200);
  TEST_ASSERT_EQUAL(0, bench.device.heartbeats_lost);
  bench_give(0x701, 1, alive);
  bench_wait_ms(20);
  bench_give(0x701, 1, booted);
  bench_wait_ms(2);
  TEST_ASSERT_EQUAL(1, bench.device.heartbeats_lost);
  TEST_ASSERT_TRUE(is_active(0x8130));
  TEST_ASSERT_EQUAL(NMT_PRE_OPERATIONAL, NODE->state);
  bench_give(0x701, 1, booted);
  bench_wait_ms(200);
  TEST_ASSERT_EQUAL(1, bench.device.heartbeats_lost); /* lost once */
  TEST_ASSERT_TRUE(is_active(0x8130));
  TEST_ASSERT_TRUE(canopen_node_silent_ms(NODE) > 220); /* it has not spoken */
  bench_give(0x701, 1, alive);
  bench_wait_ms(2);
  TEST_ASSERT_FALSE(is_active(0x8130));
}

/* State heard, and what is new about it. */
static void test_a_consumer_tells_what_each_heartbeat_means(void) {
  static const struct {
    uint8_t remote_state;
    heartbeat_news news;
  } rows[] = {{0, HEARTBEAT_BOOTED}, {127, HEARTBEAT_HEARD}, {5, HEARTBEAT_HEARD},   {0x80, HEARTBEAT_RESET},
              {0, HEARTBEAT_BOOTED}, {4, HEARTBEAT_BACK},    {0x85, HEARTBEAT_HEARD}};
  heartbeat_consumer consumer;
  heartbeat_consumer_reset(&consumer);
  for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
    TEST_ASSERT_EQUAL(rows[i].news, heartbeat_consumer_hear(&consumer, rows[i].remote_state));
  }
}

static void test_error_passive_is_reported_while_it_lasts(void) {
  for (int round = 0; round < 2; round++) {
    canopen_node_error_passive(NODE, true);
    TEST_ASSERT_TRUE(is_active(0x8120));
    TEST_ASSERT_EQUAL_HEX32(0x11, bench_get(0x1001, 0)); /* generic, communication */
    canopen_node_error_passive(NODE, false);
    TEST_ASSERT_FALSE(is_active(0x8120));
    TEST_ASSERT_EQUAL_HEX32(0, bench_get(0x1001, 0));
  }
}

/* 1029:1: 0 pre-operational, 1 no change, 2 stopped. It concerns an operational node only. */
static void test_after_bus_off_only_an_operational_node_obeys_its_error_behaviour(void) {
  static const struct {
    uint8_t behaviour, command;
    nmt_state after;
  } rows[] = {{0, 1, NMT_PRE_OPERATIONAL}, {1, 1, NMT_OPERATIONAL},       {2, 1, NMT_STOPPED},
              {0, 2, NMT_STOPPED},         {2, 128, NMT_PRE_OPERATIONAL}, {1, 2, NMT_STOPPED}};
  for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
    bench_nmt(128, BENCH_NODE);
    TEST_ASSERT_EQUAL_HEX32(0, bench_write(0x1029, 1, rows[i].behaviour, 1));
    bench_nmt(rows[i].command, BENCH_NODE);
    canopen_node_bus_off_recovered(NODE);
    TEST_ASSERT_EQUAL(rows[i].after, NODE->state);
    TEST_ASSERT_FALSE(is_active(0x8140));
  }
}

/* CiA 301: reported again with each new overrun, over after a quiet second. */
static void test_an_overrun_is_over_one_second_after_the_last_lost_frame(void) {
  for (uint32_t total = 1; total <= 5; total += 2) {
    canopen_node_lost_frames(NODE, total);
    bench_wait_ms(600);
    TEST_ASSERT_TRUE(is_active(0x8110));
    canopen_node_lost_frames(NODE, total + 1);
    bench_wait_ms(1001); /* the tick that sees the lost frame, and 1000 without one */
    TEST_ASSERT_TRUE(is_active(0x8110));
    bench_wait_ms(1);
    TEST_ASSERT_FALSE(is_active(0x8110));
  }
}

static void test_sync_of_the_wrong_length_is_over_with_the_next_good_one_and_ignored_when_stopped(void) {
  const uint8_t byte[1] = {1};
  for (int round = 0; round < 2; round++) {
    bench_operational();
    bench_give(0x80, 1, byte);
    bench_wait_ms(1);
    TEST_ASSERT_TRUE(is_active(0x8240));
    bench.sent = 0;
    bench_give(0x80, 0, NULL);
    bench_wait_ms(1);
    TEST_ASSERT_FALSE(is_active(0x8240));
    TEST_ASSERT_EQUAL(1, bench_count(0x285));
    bench_nmt(2, BENCH_NODE);
    bench_give(0x80, 1, byte);
    bench_wait_ms(1);
    TEST_ASSERT_FALSE(is_active(0x8240));
  }
}

static void test_a_request_for_a_tpdo_that_does_not_exist_changes_nothing(void) {
  static canopen_node before;
  bench_operational();
  memcpy(&before, NODE, sizeof before);
  canopen_node_request_tpdo(NODE, TPDO_COUNT);
  TEST_ASSERT_EQUAL_MEMORY(&before, NODE, sizeof before);
}

static void test_a_heartbeat_that_the_bus_refuses_is_sent_as_soon_as_it_takes_one(void) {
  TEST_ASSERT_EQUAL_HEX32(0, bench_write(0x1017, 0, 10, 2));
  bench_wait_ms(5);
  bench.bus_full = true;
  bench_wait_ms(20);
  bench.bus_full = false;
  bench.sent = 0;
  bench_wait_ms(1);
  TEST_ASSERT_EQUAL(1, bench_count(0x705));
  bench_wait_ms(9);
  TEST_ASSERT_EQUAL(1, bench_count(0x705)); /* the period begins with the frame that was sent */
  bench_wait_ms(1);
  TEST_ASSERT_EQUAL(2, bench_count(0x705));
}

/* 10 ms of silence, then one frame. */
static void test_which_frames_end_the_silence_of_the_master(void) {
  static const struct {
    nmt_state state;
    uint32_t id;
    uint8_t length;
    uint8_t bytes[8];
    bool heard;
  } rows[] = {
      {NMT_PRE_OPERATIONAL, 0x000, 2, {128, BENCH_NODE}, true},
      {NMT_PRE_OPERATIONAL, 0x000, 2, {128, 0}, true},
      {NMT_PRE_OPERATIONAL, 0x000, 2, {128, BENCH_NODE + 1}, false},
      {NMT_PRE_OPERATIONAL, 0x605, 8, {0x40, 0x00, 0x10}, true},
      {NMT_PRE_OPERATIONAL, 0x605, 7, {0x40, 0x00, 0x10}, false},
      {NMT_OPERATIONAL, 0x605, 8, {0x40, 0x00, 0x10}, true},
      {NMT_STOPPED, 0x605, 8, {0x40, 0x00, 0x10}, false},
      {NMT_PRE_OPERATIONAL, 0x205, 3, {0}, false},
      {NMT_OPERATIONAL, 0x205, 3, {0}, true},
      {NMT_PRE_OPERATIONAL, 0x080, 0, {0}, false},
      {NMT_OPERATIONAL, 0x080, 0, {0}, true}, /* PDO 2 is synchronous */
      {NMT_OPERATIONAL, 0x080, 1, {0}, false},
      {NMT_OPERATIONAL, 0x701, 1, {5}, false}, /* no consumer is set */
  };
  for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
    const uint8_t command = rows[i].state == NMT_OPERATIONAL ? 1 : rows[i].state == NMT_STOPPED ? 2 : 128;
    bench_nmt(command, BENCH_NODE);
    bench_wait_ms(10);
    const uint32_t silent_ms = canopen_node_silent_ms(NODE);
    bench.sent = 0;
    bench_give(rows[i].id, rows[i].length, rows[i].bytes);
    bench_wait_ms(1);
    char row[16];
    (void)snprintf(row, sizeof row, "row %u", (unsigned)i);
    TEST_ASSERT_EQUAL_MESSAGE(11, silent_ms, row);
    TEST_ASSERT_EQUAL_MESSAGE(rows[i].heard, canopen_node_silent_ms(NODE) < 12, row);
    TEST_ASSERT_EQUAL_MESSAGE(rows[i].id == 0x605 && rows[i].heard, bench_count(0x585), row);
  }
}

static void test_a_monitored_master_is_not_silent_until_its_heartbeat_is_lost(void) {
  const uint8_t alive[1] = {5};
  for (uint8_t consumer = 1; consumer <= 4; consumer++) { /* one of the four monitors it */
    bench_start();
    TEST_ASSERT_EQUAL_HEX32(0, bench_write(0x1016, consumer, 0x00010032, 4));
    bench_wait_ms(9);
    TEST_ASSERT_EQUAL(9, canopen_node_silent_ms(NODE)); /* since the tick that took the request; not heard yet */
    bench_give(0x701, 1, alive);
    bench_wait_ms(40);
    TEST_ASSERT_EQUAL(0, canopen_node_silent_ms(NODE));
    bench_wait_ms(20);
    TEST_ASSERT_EQUAL(59, canopen_node_silent_ms(NODE)); /* since the tick that took its heartbeat */
  }
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_node_boots_with_one_message_and_is_pre_operational);
  RUN_TEST(test_a_node_without_id_has_the_identifiers_of_node_1_and_is_silent);
  RUN_TEST(test_a_configuration_is_taken_within_its_limits_and_refused_outside);
  RUN_TEST(test_nmt_commands_move_the_node_when_addressed_to_it);
  RUN_TEST(test_each_nmt_command_has_its_state_and_its_request);
  RUN_TEST(test_reset_communication_brings_the_defaults_and_a_boot_up);
  RUN_TEST(test_lss_is_answered_during_a_reset);
  RUN_TEST(test_heartbeat_comes_on_time_with_the_state);
  RUN_TEST(test_lost_master_is_reported_and_stops_pdos);
  RUN_TEST(test_error_behaviour_can_be_none_or_stopped);
  RUN_TEST(test_one_node_is_monitored_by_one_consumer_only);
  RUN_TEST(test_an_emergency_that_the_controller_does_not_take_waits);
  RUN_TEST(test_emergency_is_reported_once_kept_in_the_history_and_cleared);
  RUN_TEST(test_an_error_that_is_raised_again_is_reported_again_and_cleared_once);
  RUN_TEST(test_the_same_error_of_two_sources_is_over_when_both_are);
  RUN_TEST(test_inhibit_time_spaces_emergencies_and_the_history_keeps_eight);
  RUN_TEST(test_missing_sync_is_reported_after_one_and_a_half_periods);
  RUN_TEST(test_a_clock_that_differs_from_sync_by_1_percent_is_reported_while_it_does);
  RUN_TEST(test_sync_of_the_wrong_length_only_reports_an_error);
  RUN_TEST(test_a_stopped_node_sends_no_emergency);
  RUN_TEST(test_store_and_restore_want_their_signatures);
  RUN_TEST(test_foreign_frames_change_nothing_and_get_no_answer);
  RUN_TEST(test_flood_is_handled_piecewise_reported_and_does_not_stop_heartbeats);
  RUN_TEST(test_frames_that_the_controller_lost_are_reported_as_an_overrun);
  RUN_TEST(test_a_flood_of_frames_for_others_loses_nothing);
  RUN_TEST(test_bus_off_is_reported_after_the_recovery);
  RUN_TEST(test_a_reset_clears_the_error_register_and_what_waits_to_be_sent);
  RUN_TEST(test_emergencies_come_in_the_order_of_their_errors);
  RUN_TEST(test_two_nodes_lost_at_once_are_both_reported_in_that_ms);
  RUN_TEST(test_two_stored_consumers_of_one_node_are_not_good);
  RUN_TEST(test_a_heartbeat_before_the_boot_up_message_is_not_monitored);
  RUN_TEST(test_a_lost_heartbeat_is_over_when_each_lost_node_is_back);
  RUN_TEST(test_a_consumer_that_is_set_anew_forgets_its_lost_node_alone);
  RUN_TEST(test_a_node_that_was_lost_before_a_reset_is_not_missed_after_it);
  RUN_TEST(test_a_heartbeat_is_monitored_from_1_ms_on);
  RUN_TEST(test_lss_selects_the_node_by_its_identity);
  RUN_TEST(test_lss_requests_that_come_together_are_each_answered);
  RUN_TEST(test_the_inhibit_time_of_emergencies_is_never_shorter_than_set);
  RUN_TEST(test_a_sync_is_late_in_the_first_ms_after_one_and_a_half_periods);
  RUN_TEST(test_without_a_first_sync_none_is_late);
  RUN_TEST(test_a_node_takes_over_no_objects_and_counts_from_before);
  RUN_TEST(test_the_silence_of_the_master_is_counted_from_its_last_frame_in_each_ms);
  RUN_TEST(test_only_a_heartbeat_of_one_byte_counts);
  RUN_TEST(test_a_boot_up_starts_no_monitoring_and_is_the_loss_of_a_monitored_node);
  RUN_TEST(test_a_consumer_tells_what_each_heartbeat_means);
  RUN_TEST(test_error_passive_is_reported_while_it_lasts);
  RUN_TEST(test_after_bus_off_only_an_operational_node_obeys_its_error_behaviour);
  RUN_TEST(test_an_overrun_is_over_one_second_after_the_last_lost_frame);
  RUN_TEST(test_sync_of_the_wrong_length_is_over_with_the_next_good_one_and_ignored_when_stopped);
  RUN_TEST(test_a_request_for_a_tpdo_that_does_not_exist_changes_nothing);
  RUN_TEST(test_a_heartbeat_that_the_bus_refuses_is_sent_as_soon_as_it_takes_one);
  RUN_TEST(test_which_frames_end_the_silence_of_the_master);
  RUN_TEST(test_a_monitored_master_is_not_silent_until_its_heartbeat_is_lost);
  return UNITY_END();
}
