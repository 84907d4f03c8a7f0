/* SPDX-License-Identifier: Apache-2.0 */
#include "canopen/bench.h"
#include "canopen/node_objects.h"

void setUp(void) { bench_start(); }
void tearDown(void) {}

enum { RPDO1 = 0x205, RPDO2 = 0x305, RPDO3 = 0x405, TPDO1 = 0x185, TPDO2 = 0x285, TPDO3 = 0x385, SYNC = 0x80 };

#define DEVICE (&bench.device)

static void write_ok(uint16_t index, uint8_t sub, uint32_t value, uint8_t length) {
  TEST_ASSERT_EQUAL_HEX32(0, bench_write(index, sub, value, length));
}

static void test_rpdo_acts_at_once_and_only_when_operational(void) {
  const uint8_t bytes[3] = {0x06, 0x00, 9};
  bench_give(RPDO1, 3, bytes);
  bench_wait_ms(1);
  TEST_ASSERT_EQUAL(0, DEVICE->axis[0].controlword);
  bench_operational();
  bench_give(RPDO1, 3, bytes);
  bench_wait_ms(1);
  TEST_ASSERT_EQUAL(6, DEVICE->axis[0].controlword);
  TEST_ASSERT_EQUAL(9, DEVICE->axis[0].mode);
}

static void test_synchronous_rpdo_waits_for_sync(void) {
  const uint8_t bytes[8] = {0x10, 0x27, 0, 0, 0x20, 0x4E, 0, 0};
  bench_operational();
  bench_give(RPDO2, 8, bytes);
  bench_wait_ms(5);
  TEST_ASSERT_EQUAL(0, DEVICE->axis[0].target_velocity);
  bench_give(SYNC, 0, NULL);
  bench_wait_ms(1);
  TEST_ASSERT_EQUAL(10000, DEVICE->axis[0].target_velocity);
  TEST_ASSERT_EQUAL(20000, DEVICE->axis[1].target_velocity);
  DEVICE->axis[0].target_velocity = 0;
  TEST_ASSERT_EQUAL(RPDO_IGNORED, rpdo_sync(&DEVICE->node.rpdos[1])); /* no frame waits */
  TEST_ASSERT_EQUAL(0, DEVICE->axis[0].target_velocity);
}

static void test_one_value_out_of_range_refuses_the_whole_frame(void) {
  const uint8_t bytes[3] = {0x06, 0x00, 11};
  bench_operational();
  bench_give(RPDO1, 3, bytes);
  bench_wait_ms(1);
  TEST_ASSERT_EQUAL(0, DEVICE->axis[0].controlword);
  TEST_ASSERT_EQUAL(3, DEVICE->axis[0].mode);
  TEST_ASSERT_EQUAL(1, DEVICE->node.rpdos[0].refused);
}

/* Objects as index, subindex and bits; afterwards the node is operational. */
static void map_into_rpdo1(const uint32_t *objects, uint8_t count) {
  write_ok(0x1400, 1, 0x80000000u | RPDO1, 4);
  write_ok(0x1600, 0, 0, 1);
  for (uint8_t i = 0; i < count; ++i) {
    write_ok(0x1600, (uint8_t)(i + 1), objects[i], 4);
  }
  write_ok(0x1600, 0, count, 1);
  write_ok(0x1400, 1, RPDO1, 4);
  bench_operational();
}

static void map_command_into_rpdo1(void) {
  static const uint32_t objects[] = {0x60400010, 0x2F120008, 0x60600008};
  map_into_rpdo1(objects, 3);
}

static void give_command(uint8_t controlword, uint8_t command, uint8_t mode) {
  const uint8_t bytes[4] = {controlword, 0, command, mode};
  bench_give(RPDO1, 4, bytes);
  bench_wait_ms(1);
}

static void test_a_command_in_an_rpdo_is_executed_once_for_each_frame(void) {
  map_command_into_rpdo1();
  give_command(6, 5, 9);
  TEST_ASSERT_EQUAL(1, DEVICE->commands);
  TEST_ASSERT_EQUAL(5, DEVICE->values.command);
  bench_wait_ms(5);
  TEST_ASSERT_EQUAL(1, DEVICE->commands);
  give_command(6, 5, 9); /* the value that is there already */
  TEST_ASSERT_EQUAL(2, DEVICE->commands);
  TEST_ASSERT_EQUAL(2, DEVICE->carried_out);
  TEST_ASSERT_EQUAL(0, DEVICE->node.rpdos[0].refused);
}

static void test_an_rpdo_with_a_value_that_is_refused_executes_nothing(void) {
  map_command_into_rpdo1();
  give_command(6, 5, 11); /* no such mode */
  give_command(6, 66, 9);
  TEST_ASSERT_EQUAL(0, DEVICE->commands);
  TEST_ASSERT_EQUAL(0, DEVICE->axis[0].controlword);
  TEST_ASSERT_EQUAL(2, DEVICE->node.rpdos[0].refused);
}

/* Its range permits every value of its type; its owner does not. No other object of the frame has anything to check. */
static void test_a_value_that_only_its_owner_refuses_is_refused_in_an_rpdo_too(void) {
  static const uint32_t objects[] = {0x2F100008};
  map_into_rpdo1(objects, 1);
  for (uint8_t value = 12; value <= 14; value++) {
    bench_give(RPDO1, 1, &value);
    bench_wait_ms(1);
    TEST_ASSERT_EQUAL(value == 13 ? 12 : value, DEVICE->values.moody);
  }
  TEST_ASSERT_EQUAL(1, DEVICE->node.rpdos[0].refused);
}

static void test_a_command_that_fails_in_an_rpdo_leaves_the_other_objects_written(void) {
  map_command_into_rpdo1();
  give_command(6, 13, 9);
  TEST_ASSERT_EQUAL(1, DEVICE->commands);
  TEST_ASSERT_EQUAL(0, DEVICE->carried_out);
  TEST_ASSERT_EQUAL(0, DEVICE->values.command);
  TEST_ASSERT_EQUAL(6, DEVICE->axis[0].controlword);
  TEST_ASSERT_EQUAL(9, DEVICE->axis[0].mode);
  TEST_ASSERT_EQUAL(1, DEVICE->node.rpdos[0].refused);
}

/* The good frame behind it comes in the same ms. */
static void test_a_wrong_rpdo_is_reported_though_a_good_one_follows_at_once(void) {
  const uint8_t bytes[3] = {0x06, 0x00, 9};
  const uint8_t no_mode[3] = {0x06, 0x00, 11};
  const struct {
    const uint8_t *bytes;
    uint8_t length;
    uint16_t code;
  } wrong[] = {{bytes, 2, 0x8210}, {no_mode, 3, 0x8200}};
  for (uint32_t i = 0; i < 2; i++) {
    bench_operational();
    const uint32_t before = bench_count(0x85);
    bench_give(RPDO1, wrong[i].length, wrong[i].bytes);
    bench_give(RPDO1, 3, bytes);
    bench_wait_ms(1);
    TEST_ASSERT_EQUAL(before + 1, bench_count(0x85));
    TEST_ASSERT_EQUAL_HEX16(wrong[i].code, bench_last(0x85)->data[0] | bench_last(0x85)->data[1] << 8);
    bench_wait_ms(20);
    TEST_ASSERT_EQUAL(before + 2, bench_count(0x85));
    TEST_ASSERT_EQUAL_HEX16(0, bench_last(0x85)->data[0] | bench_last(0x85)->data[1] << 8);
  }
}

/* One byte in each of the four RPDOs: a value out of its range, and a good one, all eight frames in the same ms. */
static void test_wrong_values_in_all_four_rpdos_are_reported_and_over_in_the_next_ms(void) {
  static const uint8_t values[] = {201, 100};
  for (uint16_t n = 0; n < 4; n++) {
    write_ok((uint16_t)(0x1400 + n), 1, 0x80000000u | (0x205u + 0x100u * n), 4);
    write_ok((uint16_t)(0x1600 + n), 0, 0, 1);
    write_ok((uint16_t)(0x1600 + n), 1, 0x2F000508, 4);
    write_ok((uint16_t)(0x1600 + n), 0, 1, 1);
    write_ok((uint16_t)(0x1400 + n), 2, 255, 1);
    write_ok((uint16_t)(0x1400 + n), 1, 0x205u + 0x100u * n, 4);
  }
  bench_operational();
  for (uint32_t i = 0; i < 2; i++) {
    for (uint32_t n = 0; n < 4; n++) {
      bench_give(0x205u + 0x100u * n, 1, &values[i]);
    }
  }
  bench_wait_ms(1);
  TEST_ASSERT_EQUAL(1, bench_count(0x85));
  const uint8_t message[8] = {0x00, 0x82, 0x11, 1, 0, 0x00, 0x2F, 5}; /* 8200, RPDO 1, 2F00:5 */
  TEST_ASSERT_EQUAL_HEX8_ARRAY(message, bench_last(0x85)->data, 8);
  bench_wait_ms(1);
  TEST_ASSERT_EQUAL(2, bench_count(0x85));
  TEST_ASSERT_EQUAL_HEX8(0, bench_last(0x85)->data[1]);
}

/* The node is ordered out of operational behind the wrong frame in the same ms. */
static void test_a_wrong_rpdo_is_reported_though_the_node_leaves_operational_at_once(void) {
  const uint8_t bytes[3] = {0x06, 0x00, 9};
  const uint8_t no_mode[3] = {0x06, 0x00, 11};
  bench_operational();
  bench_give(RPDO1, 2, bytes);
  bench_nmt(128, BENCH_NODE);
  TEST_ASSERT_TRUE(emergency_is_active(&DEVICE->node.emergency, 0, 0x8210));
  bench_operational();
  TEST_ASSERT_FALSE(emergency_is_active(&DEVICE->node.emergency, 0, 0x8210));
  bench_give(RPDO1, 3, no_mode);
  bench_nmt(2, BENCH_NODE);
  TEST_ASSERT_TRUE(emergency_is_active(&DEVICE->node.emergency, 0, 0x8200));
}

static void test_short_rpdo_is_reported_once_and_cleared_by_a_good_one(void) {
  const uint8_t bytes[8] = {0x06, 0x00, 9};
  bench_operational();
  for (uint32_t i = 0; i < 10; i++) {
    bench_give(RPDO1, 2, bytes);
    bench_wait_ms(1);
  }
  TEST_ASSERT_EQUAL(0, DEVICE->axis[0].controlword);
  TEST_ASSERT_EQUAL(1, bench_count(0x85));
  TEST_ASSERT_EQUAL_HEX8(0x10, bench_last(0x85)->data[0]);
  TEST_ASSERT_EQUAL_HEX8(0x82, bench_last(0x85)->data[1]);
  bench_give(RPDO1, 8, bytes);
  bench_wait_ms(2);
  TEST_ASSERT_EQUAL(6, DEVICE->axis[0].controlword);
  TEST_ASSERT_EQUAL(2, bench_count(0x85));
  TEST_ASSERT_EQUAL(0, DEVICE->node.objects.emergency.error_register);
  bench_give(RPDO1, 2, bytes);
  bench_wait_ms(1);
  TEST_ASSERT_TRUE(emergency_is_active(&DEVICE->node.emergency, 0, 0x8210));
  bench_nmt(128, BENCH_NODE); /* over with a new start, too */
  bench_operational();
  TEST_ASSERT_FALSE(emergency_is_active(&DEVICE->node.emergency, 0, 0x8210));
}

static void test_silent_rpdo_raises_its_emergency_after_the_event_time(void) {
  const uint8_t bytes[3] = {0x06, 0x00, 9};
  write_ok(0x1400, 5, 20, 2);
  bench_operational();
  bench_wait_ms(100);
  TEST_ASSERT_FALSE(emergency_is_active(&DEVICE->node.emergency, 0, 0x8250));
  bench_give(RPDO1, 3, bytes);
  bench_wait_ms(19);
  TEST_ASSERT_FALSE(emergency_is_active(&DEVICE->node.emergency, 0, 0x8250));
  bench_wait_ms(2);
  TEST_ASSERT_TRUE(emergency_is_active(&DEVICE->node.emergency, 0, 0x8250));
  bench_give(RPDO1, 3, bytes);
  bench_wait_ms(1);
  TEST_ASSERT_FALSE(emergency_is_active(&DEVICE->node.emergency, 0, 0x8250));
  bench_nmt(128, BENCH_NODE); /* started again, it waits for the first frame again */
  bench_operational();
  bench_wait_ms(100);
  TEST_ASSERT_FALSE(emergency_is_active(&DEVICE->node.emergency, 0, 0x8250));
}

/* The node leaves operational, or the RPDO is switched off and on. */
static void test_what_waits_for_sync_is_forgotten_with_a_new_start(void) {
  const uint8_t bytes[8] = {0x10, 0x27};
  for (int by_state = 0; by_state <= 1; by_state++) {
    bench_operational();
    bench_give(RPDO2, 8, bytes);
    bench_wait_ms(1);
    if (by_state) {
      bench_nmt(128, BENCH_NODE);
      bench_operational();
    } else {
      write_ok(0x1401, 1, 0x80000000u | RPDO2, 4);
      write_ok(0x1401, 1, RPDO2, 4);
    }
    bench_give(SYNC, 0, NULL);
    bench_wait_ms(1);
    TEST_ASSERT_EQUAL(0, DEVICE->axis[0].target_velocity);
  }
}

static void test_event_tpdo_reports_the_start_and_each_change_no_faster_than_inhibited(void) {
  bench_operational();
  bench_wait_ms(30);
  TEST_ASSERT_EQUAL(1, bench_count(TPDO1));
  for (uint16_t i = 1; i <= 100; i++) {
    DEVICE->axis[0].controlword = i;
    bench_wait_ms(1);
  }
  TEST_ASSERT_EQUAL(11, bench_count(TPDO1)); /* 10 ms inhibit time */
  bench_wait_ms(20);
  TEST_ASSERT_EQUAL(12, bench_count(TPDO1));
  TEST_ASSERT_EQUAL(100, bench_last(TPDO1)->data[0]);
  TEST_ASSERT_EQUAL(3, bench_last(TPDO1)->length);
  DEVICE->axis[0].controlword = 99; /* a smaller value is a change, too */
  bench_wait_ms(20);
  TEST_ASSERT_EQUAL(99, bench_last(TPDO1)->data[0]);
}

/* TPDO1 has a speed, which is no event, in bytes 0 to 3; then statusword and mode, which are. */
static void test_each_byte_of_an_event_sends_a_tpdo_and_no_other_byte_does(void) {
  static const uint32_t objects[] = {0x606C0020, 0x60410010, 0x60610008};
  write_ok(0x1800, 1, 0x80000000u | TPDO1, 4);
  write_ok(0x1A00, 0, 0, 1);
  for (uint8_t i = 0; i < 3; i++) {
    write_ok(0x1A00, (uint8_t)(i + 1), objects[i], 4);
  }
  write_ok(0x1A00, 0, 3, 1);
  write_ok(0x1800, 1, TPDO1, 4);
  bench_operational();
  bench_wait_ms(20);
  TEST_ASSERT_EQUAL(1, bench_count(TPDO1));
  DEVICE->axis[0].target_velocity = 0x12345678;
  bench_wait_ms(20);
  TEST_ASSERT_EQUAL(1, bench_count(TPDO1));
  DEVICE->axis[0].controlword = 0x0040;
  bench_wait_ms(20);
  TEST_ASSERT_EQUAL(2, bench_count(TPDO1));
  DEVICE->axis[0].controlword = 0x0140;
  bench_wait_ms(20);
  TEST_ASSERT_EQUAL(3, bench_count(TPDO1));
  DEVICE->axis[0].mode = 9;
  bench_wait_ms(20);
  TEST_ASSERT_EQUAL(4, bench_count(TPDO1));
  TEST_ASSERT_EQUAL_HEX8_ARRAY(((const uint8_t[]){0x78, 0x56, 0x34, 0x12, 0x40, 0x01, 9}), bench_last(TPDO1)->data, 7);
}

static void test_full_bus_delays_a_tpdo_and_sends_the_newest(void) {
  bench_operational();
  bench_wait_ms(20);
  bench.sent = 0;
  bench.bus_full = true;
  DEVICE->axis[0].controlword = 1;
  bench_wait_ms(20);
  DEVICE->axis[0].controlword = 2;
  bench_wait_ms(20);
  bench.bus_full = false;
  bench_wait_ms(20);
  TEST_ASSERT_EQUAL(1, bench_count(TPDO1));
  TEST_ASSERT_EQUAL(2, bench_last(TPDO1)->data[0]);
}

static void test_synchronous_tpdo_answers_every_nth_sync(void) {
  write_ok(0x1801, 2, 3, 1);
  bench_operational();
  for (uint32_t i = 0; i < 12; i++) {
    bench_give(SYNC, 0, NULL);
    bench_wait_ms(1);
  }
  TEST_ASSERT_EQUAL(4, bench_count(TPDO2));
}

static void test_acyclic_synchronous_tpdo_waits_for_event_and_sync(void) {
  write_ok(0x1800, 2, 0, 1);
  bench_operational();
  bench_wait_ms(20);
  TEST_ASSERT_EQUAL(0, bench_count(TPDO1));
  bench_give(SYNC, 0, NULL);
  bench_wait_ms(1);
  bench_give(SYNC, 0, NULL);
  bench_wait_ms(1);
  TEST_ASSERT_EQUAL(1, bench_count(TPDO1));
  DEVICE->axis[0].controlword = 7;
  bench_wait_ms(1);
  bench_give(SYNC, 0, NULL);
  bench_wait_ms(1);
  TEST_ASSERT_EQUAL(2, bench_count(TPDO1));
  TEST_ASSERT_EQUAL(7, bench_last(TPDO1)->data[0]);
  canopen_node_request_tpdo(&DEVICE->node, 0); /* an event, though no value has changed */
  bench_wait_ms(1);
  TEST_ASSERT_EQUAL(2, bench_count(TPDO1));
  bench_give(SYNC, 0, NULL);
  bench_wait_ms(1);
  TEST_ASSERT_EQUAL(3, bench_count(TPDO1));
}

/* TPDO2 at every second SYNC, with SYNC start value 4. */
static void start_tpdo2_at_counter_4(void) {
  write_ok(0x1801, 1, 0xC0000285, 4);
  write_ok(0x1801, 6, 4, 1);
  write_ok(0x1801, 2, 2, 1);
  write_ok(0x1801, 1, 0x40000285, 4);
}

static void test_tpdo_with_a_start_value_begins_at_that_counter(void) {
  write_ok(0x1019, 0, 10, 1);
  start_tpdo2_at_counter_4();
  for (int start = 0; start < 2; start++) { /* and again after each start of the node */
    bench_operational();
    bench.sent = 0;
    for (uint8_t counter = 1; counter <= 10; counter++) {
      bench_give(SYNC, 1, &counter);
      bench_wait_ms(1);
      TEST_ASSERT_EQUAL(counter < 4 ? 0 : (counter - 2) / 2, bench_count(TPDO2));
    }
    bench_nmt(128, BENCH_NODE);
  }
}

static void test_mapping_follows_the_sequence_of_the_standard_only(void) {
  const uint32_t u8 = 0x2F000508, f32 = 0x2F000920, dummy = 0x00050008;
  TEST_ASSERT_EQUAL_HEX32(0, bench_write(0x1602, 1, u8, 4));
  TEST_ASSERT_EQUAL_HEX32(0, bench_write(0x1602, 2, dummy, 4));
  TEST_ASSERT_EQUAL_HEX32(0, bench_write(0x1602, 3, f32, 4));
  TEST_ASSERT_EQUAL_HEX32(0, bench_write(0x1602, 0, 3, 1));
  TEST_ASSERT_EQUAL_HEX32(0x08000022, bench_write(0x1602, 1, f32, 4)); /* number is not 0 */
  TEST_ASSERT_EQUAL_HEX32(0, bench_write(0x1402, 1, 0x405, 4));
  TEST_ASSERT_EQUAL_HEX32(0x08000022, bench_write(0x1602, 0, 0, 1)); /* PDO is on */
  const uint32_t bits = bench_bits(2.5f);
  const uint8_t bytes[6] = {123, 99, (uint8_t)bits, (uint8_t)(bits >> 8), (uint8_t)(bits >> 16), (uint8_t)(bits >> 24)};
  bench_operational();
  bench_give(RPDO3, 6, bytes);
  bench_wait_ms(1);
  TEST_ASSERT_EQUAL(123, DEVICE->values.u8);
  TEST_ASSERT_EQUAL_FLOAT(2.5f, DEVICE->values.f32);
}

static void test_what_cannot_be_mapped_is_refused(void) {
  TEST_ASSERT_EQUAL_HEX32(0x06020000, bench_write(0x1602, 1, 0x2FFF0008, 4));
  TEST_ASSERT_EQUAL_HEX32(0x06090011, bench_write(0x1602, 1, 0x2F006308, 4));
  TEST_ASSERT_EQUAL_HEX32(0x06040041, bench_write(0x1602, 1, 0x2F000208, 4)); /* TPDO only */
  TEST_ASSERT_EQUAL_HEX32(0x06040041, bench_write(0x1602, 1, 0x2F000510, 4)); /* 16 of 8 bits */
  TEST_ASSERT_EQUAL_HEX32(0x06040041, bench_write(0x1A02, 1, 0x60400010, 4)); /* RPDO only */
  TEST_ASSERT_EQUAL_HEX32(0, bench_write(0x1A02, 1, 0x2F000840, 4));
  TEST_ASSERT_EQUAL_HEX32(0, bench_write(0x1A02, 2, 0x2F000508, 4));
  TEST_ASSERT_EQUAL_HEX32(0x06040042, bench_write(0x1A02, 0, 2, 1)); /* 9 bytes */
  TEST_ASSERT_EQUAL_HEX32(0, bench_write(0x1A02, 8, 0, 4));          /* no object */
  TEST_ASSERT_EQUAL_HEX32(0x06020000, bench_write(0x1A02, 8, 1, 4));
  TEST_ASSERT_EQUAL_HEX32(0x06090031, bench_write(0x1A02, 0, 9, 1));
  TEST_ASSERT_EQUAL_HEX32(0, bench_write(0x1A02, 0, 1, 1));
}

/* A value that its owner refreshes is read by the dictionary, the others are copied: each at its place in the frame. */
static void test_values_follow_each_other_however_they_are_read(void) {
  DEVICE->values.u16 = 0x1234;
  DEVICE->values.u8 = 0x56;
  pdo_map map = {.count = 2, .length = 3, .item = {{.bytes = 2}, {.from = &DEVICE->values.u8, .bytes = 1}}};
  TEST_ASSERT_EQUAL_HEX32(0, od_find(&DEVICE->node.dictionary, 0x2F00, 6, &map.item[0].object));
  uint8_t bytes[8] = {0};
  pdo_gather(&map, bytes);
  const uint8_t expected[3] = {0x34, 0x12, 0x56};
  TEST_ASSERT_EQUAL_HEX8_ARRAY(expected, bytes, 3);
}

static od_abort measure(void *owner, const od_object *object) {
  uint8_t *measured = owner;
  (void)object;
  ++*measured;
  return OD_OK;
}

/* A value that its owner measures anew for each reader, in a TPDO. */
static void test_a_value_that_its_owner_refreshes_is_refreshed_in_each_tpdo(void) {
  static uint8_t measured;
  static const od_hooks measures = {.refresh = measure};
  static const od_entry row[] = {
      {.type = OD_UNSIGNED8, .index = 0x3000, .bytes = 1, .access = OD_RO, .flags = OD_TPDO, .high = {.i = 255}}};
  const od_part part = {.table = {row, 1}, .values = &measured, .owner = &measured, .hooks = &measures};
  const object_dictionary dictionary = {.parts = &part, .count = 1};
  const pdo_mapping mapping = {.count = 1, .entry = {0x30000008}};
  pdo_map map;
  measured = 40;
  TEST_ASSERT_EQUAL_HEX32(OD_OK, pdo_resolve(&dictionary, PDO_TRANSMIT, &mapping, &map));
  for (uint8_t sent = 41; sent <= 43; sent++) {
    uint8_t bytes[8] = {0};
    pdo_gather(&map, bytes);
    TEST_ASSERT_EQUAL(sent, bytes[0]);
  }
}

static void test_a_tpdo_that_is_off_sends_nothing_whoever_asks(void) {
  tpdo *off = &DEVICE->node.tpdos[3];
  bench_operational();
  bench_wait_ms(5);
  bench.sent = 0;
  tpdo_request(off);
  tpdo_sync(off, 0);
  tpdo_tick(off, &DEVICE->node.sender);
  TEST_ASSERT_EQUAL(0, bench.sent);
}

static void test_an_rpdo_that_is_off_takes_nothing_whoever_gives_it(void) {
  const can_frame frame = {.id = RPDO1, .length = 8, .data = {6}};
  bench_operational();
  write_ok(0x1400, 1, 0x80000000u | RPDO1, 4);
  rpdo *off = &DEVICE->node.rpdos[0];
  TEST_ASSERT_EQUAL(RPDO_IGNORED, rpdo_receive(off, &frame));
  TEST_ASSERT_EQUAL(0, DEVICE->axis[0].controlword);
  TEST_ASSERT_FALSE(off->heard);
}

/* 100 us before a frame of RPDO1, and behind the tick's beginning, a request switches that RPDO off. */
static void test_a_frame_of_an_rpdo_that_has_been_switched_off_is_dropped(void) {
  const can_frame off = {
      .id = 0x605, .length = 8, .data = {0x23, 0x00, 0x14, 1, 0x05, 0x02, 0, 0x80}, .received_us = 100};
  const can_frame frame = {.id = RPDO1, .length = 3, .data = {0x06, 0x00, 9}, .received_us = 200};
  bench_operational();
  bench_wait_ms(20);
  bench.sent = 0;
  canopen_node_take(&DEVICE->node);
  TEST_ASSERT_TRUE(canopen_node_receive(&DEVICE->node, &off));
  TEST_ASSERT_TRUE(canopen_node_receive(&DEVICE->node, &frame));
  canopen_node_serve(&DEVICE->node);
  TEST_ASSERT_EQUAL_HEX8(0x60, bench_last(0x585)->data[0]);
  TEST_ASSERT_EQUAL(1, can_queue_count(&DEVICE->node.process_data));
  const uint32_t silent_ms = canopen_node_silent_ms(&DEVICE->node);
  bench_wait_ms(10);
  TEST_ASSERT_EQUAL(0, can_queue_count(&DEVICE->node.process_data));
  TEST_ASSERT_EQUAL(silent_ms + 10, canopen_node_silent_ms(&DEVICE->node)); /* it is no frame for this node */
  TEST_ASSERT_EQUAL(0, DEVICE->axis[0].controlword);
  TEST_ASSERT_EQUAL(1, bench.sent);
}

static void test_event_timer_repeats_a_tpdo_and_request_sends_one(void) {
  write_ok(0x1A02, 1, 0x2F000508, 4);
  write_ok(0x1A02, 0, 1, 1);
  write_ok(0x1802, 1, 0x40000385, 4);
  bench_operational();
  bench.sent = 0;
  bench_wait_ms(500);
  TEST_ASSERT_EQUAL(10, bench_count(TPDO3));
  canopen_node_request_tpdo(&DEVICE->node, 2);
  bench_wait_ms(2);
  TEST_ASSERT_EQUAL(11, bench_count(TPDO3));
}

/* --- a stop beside a value that is refused ------------------------------------------------------------------------ */

static void start_with_synchronous_rpdo1(void) {
  write_ok(0x1400, 1, 0x80000000u | RPDO1, 4);
  write_ok(0x1400, 2, 1, 1);
  write_ok(0x1400, 1, RPDO1, 4);
  bench_operational();
}

static void give_rpdo1(uint8_t controlword, uint8_t mode) {
  const uint8_t bytes[3] = {controlword, 0, mode};
  bench_give(RPDO1, 3, bytes);
  bench_wait_ms(2);
}

static void test_a_stop_beside_a_refused_value_is_obeyed_and_the_rest_reported_once(void) {
  bench_operational();
  give_rpdo1(0x0F, 9);
  for (uint32_t i = 0; i < 5; i++) {
    give_rpdo1(0x0B, 11); /* quick stop, no such mode */
  }
  TEST_ASSERT_EQUAL_HEX16(0x0B, DEVICE->axis[0].controlword);
  TEST_ASSERT_EQUAL(9, DEVICE->axis[0].mode);
  TEST_ASSERT_EQUAL(1, bench_count(0x85));
  const uint8_t message[8] = {0x00, 0x82, 0x11, 1, 0, 0x60, 0x60, 0}; /* 8200, RPDO 1, 6060:0 */
  TEST_ASSERT_EQUAL_HEX8_ARRAY(message, bench_last(0x85)->data, 8);
  TEST_ASSERT_EQUAL_HEX32(0x00018200, bench_get(0x1003, 1));
  give_rpdo1(0x0F, 9);
  TEST_ASSERT_EQUAL_HEX8(0, bench_last(0x85)->data[1]);
  TEST_ASSERT_EQUAL(0, DEVICE->node.objects.emergency.error_register);
}

/* Both controlwords and a mode that does not exist in one frame: each axis stops. */
static void test_the_stops_of_two_axes_beside_a_refused_value_are_both_obeyed(void) {
  write_ok(0x1400, 1, 0x80000000u | RPDO1, 4);
  write_ok(0x1600, 0, 0, 1);
  write_ok(0x1600, 1, 0x60400010, 4);
  write_ok(0x1600, 2, 0x68400010, 4);
  write_ok(0x1600, 3, 0x60600008, 4);
  write_ok(0x1600, 0, 3, 1);
  write_ok(0x1400, 1, RPDO1, 4);
  bench_operational();
  const uint8_t run[5] = {0x0F, 0, 0x0F, 0, 9};
  const uint8_t stop[5] = {0x0B, 0, 0x02, 0, 11};
  bench_give(RPDO1, 5, run);
  bench_give(RPDO1, 5, stop);
  bench_wait_ms(1);
  TEST_ASSERT_EQUAL_HEX16(0x0B, DEVICE->axis[0].controlword);
  TEST_ASSERT_EQUAL_HEX16(0x02, DEVICE->axis[1].controlword);
  TEST_ASSERT_EQUAL(9, DEVICE->axis[0].mode);
}

/* The same row of two axes is two objects, in either order. */
static void test_the_controlwords_of_two_axes_may_be_in_one_rpdo(void) {
  static const pdo_mapping mappings[] = {{.count = 2, .entry = {0x60400010, 0x68400010}},
                                         {.count = 2, .entry = {0x68400010, 0x60400010}}};
  for (int i = 0; i < 2; i++) {
    pdo_map map;
    TEST_ASSERT_EQUAL_HEX32(OD_OK, pdo_resolve(&DEVICE->node.dictionary, PDO_RECEIVE, &mappings[i], &map));
    TEST_ASSERT_EQUAL(4, map.length);
  }
}

/* RPDO1 and RPDO3, each with the controlword of one axis, wait for a SYNC. */
static void start_with_a_synchronous_controlword_for_each_axis(void) {
  static const uint32_t controlwords[] = {0x60400010, 0x68400010};
  for (uint16_t n = 0; n <= 2; n += 2) {
    const uint32_t identifier = RPDO1 + 0x100u * n;
    write_ok((uint16_t)(0x1400 + n), 1, 0x80000000u | identifier, 4);
    write_ok((uint16_t)(0x1600 + n), 0, 0, 1);
    write_ok((uint16_t)(0x1600 + n), 1, controlwords[n / 2], 4);
    write_ok((uint16_t)(0x1600 + n), 0, 1, 1);
    write_ok((uint16_t)(0x1400 + n), 2, 1, 1);
    write_ok((uint16_t)(0x1400 + n), 1, identifier, 4);
  }
  bench_operational();
}

static void give_controlwords(uint8_t azimuth, uint8_t pitch) {
  const uint8_t first[2] = {azimuth, 0};
  const uint8_t second[2] = {pitch, 0};
  bench_give(RPDO1, 2, first);
  bench_give(RPDO3, 2, second);
}

static void check_controlwords(uint16_t azimuth, uint16_t pitch) {
  TEST_ASSERT_EQUAL_HEX16(azimuth, DEVICE->axis[0].controlword);
  TEST_ASSERT_EQUAL_HEX16(pitch, DEVICE->axis[1].controlword);
}

static void test_the_stops_of_two_rpdos_that_wait_for_sync_are_obeyed_when_the_node_leaves_operational(void) {
  start_with_a_synchronous_controlword_for_each_axis();
  give_controlwords(0x0F, 0x0F);
  bench_give(SYNC, 0, NULL);
  bench_wait_ms(1);
  check_controlwords(0x0F, 0x0F);
  give_controlwords(0x0B, 0x02);
  bench_wait_ms(1);
  check_controlwords(0x0F, 0x0F);
  bench_nmt(128, BENCH_NODE);
  check_controlwords(0x0B, 0x02);
}

/* One of the two axes has not yet obeyed its last command: the SYNC waits for it, and takes effect on both. */
static void test_a_sync_waits_until_each_axis_can_take_its_command(void) {
  for (int same = 0; same <= 1; same++) { /* whether the first axis gets another command, too */
    bench_start();
    start_with_a_synchronous_controlword_for_each_axis();
    give_controlwords(0x0F, 0x0F);
    bench_give(SYNC, 0, NULL);
    bench_wait_ms(1);
    DEVICE->busy = true;
    give_controlwords(same ? 0x0F : 0x1F, 0x1F);
    bench_give(SYNC, 0, NULL);
    bench_wait_ms(5);
    check_controlwords(0x0F, 0x0F);
    DEVICE->busy = false;
    bench_wait_ms(1);
    check_controlwords(same ? 0x0F : 0x1F, 0x1F);
  }
}

/* The command that is there already waits for nothing; another one waits, and what comes after it, too. */
static void test_a_command_that_must_wait_keeps_its_place_among_the_frames(void) {
  const uint8_t speeds[8] = {0x10, 0x27};
  bench_operational();
  give_rpdo1(0x0F, 9);
  DEVICE->busy = true;
  give_rpdo1(0x0F, 8);
  TEST_ASSERT_EQUAL(8, DEVICE->axis[0].mode);
  give_rpdo1(0x1F, 9);
  bench_give(RPDO2, 8, speeds);
  bench_give(SYNC, 0, NULL);
  bench_wait_ms(5);
  TEST_ASSERT_EQUAL_HEX16(0x0F, DEVICE->axis[0].controlword);
  TEST_ASSERT_EQUAL(8, DEVICE->axis[0].mode);
  TEST_ASSERT_EQUAL(0, DEVICE->axis[0].target_velocity);
  DEVICE->busy = false;
  bench_wait_ms(1);
  TEST_ASSERT_EQUAL_HEX16(0x1F, DEVICE->axis[0].controlword);
  TEST_ASSERT_EQUAL(9, DEVICE->axis[0].mode);
  TEST_ASSERT_EQUAL(10000, DEVICE->axis[0].target_velocity);
}

/* The mode, then the controlwords of both axes, which obey their last commands still. */
static void test_a_frame_that_repeats_the_commands_of_both_axes_does_not_wait(void) {
  static const uint32_t objects[] = {0x60600008, 0x60400010, 0x68400010};
  static const uint8_t frames[][5] = {{9, 0x0F, 0, 0x07, 0}, {8, 0x0F, 0, 0x07, 0}, {7, 0x0F, 0, 0x0F, 0}};
  map_into_rpdo1(objects, 3);
  for (int i = 0; i < 3; i++) {
    bench_give(RPDO1, 5, frames[i]);
    bench_wait_ms(3);
    TEST_ASSERT_EQUAL(i == 0 ? 9 : 8, DEVICE->axis[0].mode); /* the third one has a new command for the second axis */
    TEST_ASSERT_EQUAL_HEX16(0x07, DEVICE->axis[1].controlword);
    DEVICE->busy = true;
  }
  DEVICE->busy = false;
  bench_wait_ms(1);
  TEST_ASSERT_EQUAL(7, DEVICE->axis[0].mode);
  TEST_ASSERT_EQUAL_HEX16(0x0F, DEVICE->axis[1].controlword);
}

/* Values that the device has set itself, beyond what a master may set: to send them again asks for nothing. */
static void test_a_value_that_is_there_already_is_not_refused(void) {
  static const uint32_t objects[] = {0x60400010, 0x60600008, 0x2F000920};
  const uint32_t bits = bench_bits(2000.0f);
  const uint8_t bytes[7] = {
      0x0F, 0, 11, (uint8_t)bits, (uint8_t)(bits >> 8), (uint8_t)(bits >> 16), (uint8_t)(bits >> 24)};
  map_into_rpdo1(objects, 3);
  bench_give(RPDO1, 7, bytes);
  bench_wait_ms(1);
  TEST_ASSERT_EQUAL_HEX16(0, DEVICE->axis[0].controlword);
  TEST_ASSERT_EQUAL(1, DEVICE->node.rpdos[0].refused);
  DEVICE->axis[0].mode = 11;
  DEVICE->values.f32 = 2000.0f;
  bench_give(RPDO1, 7, bytes);
  bench_wait_ms(1);
  TEST_ASSERT_EQUAL_HEX16(0x0F, DEVICE->axis[0].controlword);
  TEST_ASSERT_EQUAL(1, DEVICE->node.rpdos[0].refused);
}

/* RPDO1 of CiA 402 is the controlword alone; this one maps the mode, too. */
static void test_a_stop_in_a_frame_that_is_too_short_is_obeyed_and_nothing_else(void) {
  const struct {
    uint8_t bytes[2], length, expected;
  } cases[] = {{{0x0B, 0}, 2, 0x0B}, {{0x00, 0}, 2, 0x00}, {{0x0B, 0}, 1, 0x0F}, {{0x1F, 0}, 2, 0x0F}};
  bench_operational();
  for (size_t i = 0; i < sizeof cases / sizeof cases[0]; i++) {
    give_rpdo1(0x0F, 9);
    bench_give(RPDO1, cases[i].length, cases[i].bytes);
    bench_wait_ms(2);
    TEST_ASSERT_EQUAL_HEX16(cases[i].expected, DEVICE->axis[0].controlword);
    TEST_ASSERT_EQUAL(9, DEVICE->axis[0].mode);
    TEST_ASSERT_TRUE(emergency_is_active(&DEVICE->node.emergency, 0, 0x8210));
  }
}

/* Of two frames before a SYNC the later one counts, but a stop in the earlier one is obeyed at once. */
static void test_a_stop_that_waits_for_sync_is_not_replaced_by_a_later_frame(void) {
  start_with_synchronous_rpdo1();
  give_rpdo1(0x0F, 9);
  give_rpdo1(0x0F, 8);
  bench_wait_ms(2);
  TEST_ASSERT_EQUAL_HEX16(0, DEVICE->axis[0].controlword); /* no stop: nothing before the SYNC */
  give_rpdo1(0x0B, 9);
  give_rpdo1(0x0F, 7);
  bench_wait_ms(2);
  TEST_ASSERT_EQUAL_HEX16(0x0B, DEVICE->axis[0].controlword);
  bench_give(SYNC, 0, NULL);
  bench_wait_ms(2);
  TEST_ASSERT_EQUAL_HEX16(0x0F, DEVICE->axis[0].controlword);
  TEST_ASSERT_EQUAL(7, DEVICE->axis[0].mode);
}

static void test_a_command_that_waits_for_sync_does_not_undo_a_stop_in_a_frame_that_is_too_short(void) {
  start_with_synchronous_rpdo1();
  give_rpdo1(0x0F, 9);
  const uint8_t stop[2] = {0x0B, 0};
  bench_give(RPDO1, 2, stop);
  bench_wait_ms(1);
  bench_give(SYNC, 0, NULL);
  bench_wait_ms(1);
  TEST_ASSERT_EQUAL_HEX16(0x0B, DEVICE->axis[0].controlword);
}

static void test_a_refused_value_is_over_when_the_rpdo_starts_again(void) {
  bench_operational();
  give_rpdo1(0x0F, 11);
  TEST_ASSERT_TRUE(emergency_is_active(&DEVICE->node.emergency, 0, 0x8200));
  write_ok(0x1400, 1, 0x80000000u | RPDO1, 4);
  TEST_ASSERT_FALSE(emergency_is_active(&DEVICE->node.emergency, 0, 0x8200));
  write_ok(0x1400, 1, RPDO1, 4);
  give_rpdo1(0x0F, 11);
  TEST_ASSERT_TRUE(emergency_is_active(&DEVICE->node.emergency, 0, 0x8200));
  bench_nmt(128, BENCH_NODE);
  TEST_ASSERT_TRUE(emergency_is_active(&DEVICE->node.emergency, 0, 0x8200));
  bench_operational();
  TEST_ASSERT_FALSE(emergency_is_active(&DEVICE->node.emergency, 0, 0x8200));
}

static void test_a_refused_value_after_sync_is_reported_too(void) {
  const uint8_t too_fast[8] = {0, 0, 0, 0x7F, 0, 0, 0, 0};
  bench_operational();
  bench_give(RPDO2, 8, too_fast);
  bench_give(SYNC, 0, NULL);
  bench_wait_ms(1);
  const uint8_t message[8] = {0x00, 0x82, 0x11, 2, 0, 0xFF, 0x60, 0};
  TEST_ASSERT_EQUAL_HEX8_ARRAY(message, bench_last(0x85)->data, 8);
}

/* --- one identifier, one use ---------------------------------------------------------------------------------------
 */

enum { TAKEN = 0x06040043, OFF = (int32_t)0x80000000 };

static void test_no_two_services_share_an_identifier(void) {
  static const struct {
    uint16_t index;
    uint8_t sub;
    uint32_t free; /* an identifier that it may have */
  } uses[] = {{0x1005, 0, 0x80},  {0x1014, 0, 0x85},  {0x1400, 1, 0x205}, {0x1401, 1, 0x305}, {0x1800, 1, 0x185},
              {0x1801, 1, 0x285}, {0x1804, 1, 0x684}, {0x1807, 1, 0x6A8}, {0x1201, 1, 0x6A0}, {0x1201, 2, 0x6A1}};
  const uint32_t count = sizeof uses / sizeof uses[0];
  write_ok(0x1804, 1, 0x684, 4);
  write_ok(0x1807, 1, 0x6A8, 4);
  write_ok(0x1201, 1, 0x6A0, 4);
  write_ok(0x1201, 2, 0x6A1, 4);
  for (uint32_t i = 0; i < count; i++) {
    if (uses[i].index != 0x1005) {
      write_ok(uses[i].index, uses[i].sub, (uint32_t)OFF | uses[i].free, 4);
    }
    for (uint32_t k = 0; k < count; k++) {
      if (i != k) {
        TEST_ASSERT_EQUAL_HEX32(TAKEN, bench_write(uses[i].index, uses[i].sub, uses[k].free, 4));
      }
    }
    write_ok(uses[i].index, uses[i].sub, uses[i].free, 4);
  }
}

static void test_identifiers_of_fixed_services_cannot_be_taken(void) {
  static const uint32_t fixed[] = {0x000, 0x605, 0x585, 0x601, 0x7E4, 0x7E5, 0x705};
  write_ok(0x1014, 0, (uint32_t)OFF | 0x85, 4);
  write_ok(0x1400, 1, (uint32_t)OFF | RPDO1, 4);
  write_ok(0x1800, 1, (uint32_t)OFF | TPDO1, 4);
  for (uint32_t i = 0; i < sizeof fixed / sizeof fixed[0]; i++) {
    TEST_ASSERT_EQUAL_HEX32(0x06090030, bench_write(0x1005, 0, fixed[i], 4));
    TEST_ASSERT_EQUAL_HEX32(0x06090030, bench_write(0x1014, 0, fixed[i], 4));
    TEST_ASSERT_EQUAL_HEX32(0x06090030, bench_write(0x1400, 1, fixed[i], 4));
    TEST_ASSERT_EQUAL_HEX32(0x06090030, bench_write(0x1800, 1, fixed[i], 4));
    TEST_ASSERT_EQUAL_HEX32(0x06090030, bench_write(0x1201, 1, fixed[i], 4));
  }
}

static void test_a_value_that_is_refused_anyway_is_not_refused_as_taken(void) {
  const uint32_t producer = 0x40000000; /* of SYNC; the identifier itself is that of RPDO1 */
  TEST_ASSERT_EQUAL_HEX32(0x06090030, bench_write(0x1005, 0, producer | RPDO1, 4));
}

/* Some masters set bit 31 of 1005 ("consumer" of old versions), and bit 30 of an RPDO as for a TPDO. */
static void test_bits_without_a_meaning_are_taken_and_change_nothing(void) {
  write_ok(0x1005, 0, (uint32_t)OFF | 0x80, 4);
  TEST_ASSERT_EQUAL_HEX32(TAKEN, bench_write(0x1005, 0, (uint32_t)OFF | RPDO1, 4));
  TEST_ASSERT_EQUAL_HEX32(0x80, bench.device.node.listeners.sync);
  write_ok(0x1400, 1, (uint32_t)OFF | RPDO1, 4);
  TEST_ASSERT_EQUAL_HEX32(TAKEN, bench_write(0x1400, 1, 0x80, 4));
  write_ok(0x1400, 1, 0x40000000u | RPDO1, 4);
}

static void test_what_is_off_takes_no_identifier(void) {
  write_ok(0x1400, 1, (uint32_t)OFF | RPDO1, 4);
  write_ok(0x1005, 0, RPDO1, 4);
  TEST_ASSERT_EQUAL_HEX32(TAKEN, bench_write(0x1400, 1, RPDO1, 4));
  write_ok(0x1005, 0, 0x80, 4);
  write_ok(0x1400, 1, RPDO1, 4);
}

/* 205h is the identifier of RPDO1, and as good a period as any. */
static void test_a_value_that_is_no_identifier_may_equal_one(void) {
  write_ok(0x1006, 0, RPDO1, 4);
  write_ok(0x1017, 0, RPDO1, 2);
  write_ok(0x2F00, 7, RPDO1, 4);
}

/* --- while LSS changes the bit rate ---------------------------------------------------------------------------------
 */

static void test_during_a_change_of_the_bit_rate_only_nmt_is_obeyed(void) {
  bench_operational();
  DEVICE->node.lss.change = LSS_BEFORE_CHANGE;
  DEVICE->node.lss.left_ms = 1000;
  give_rpdo1(0x0F, 9);
  TEST_ASSERT_EQUAL(0, DEVICE->axis[0].controlword);
  const uint8_t enable[8] = {0x2B, 0x40, 0x60, 0, 0x0F};
  uint8_t answer[8];
  bench_sdo(enable, answer);
  TEST_ASSERT_EQUAL(0, DEVICE->axis[0].controlword);
  bench_nmt(2, BENCH_NODE);
  TEST_ASSERT_EQUAL(NMT_STOPPED, DEVICE->node.state);
}

/* Many masters write the whole configuration, also the identifier that is there already. */
static void test_the_identifier_that_a_pdo_has_may_be_written_while_it_is_on(void) {
  write_ok(0x1400, 1, RPDO1, 4);
  write_ok(0x1800, 1, TPDO1, 4);
  TEST_ASSERT_EQUAL_HEX32(0x08000022, bench_write(0x1400, 1, RPDO1 + 1, 4));
}

/* 0 .. 240 with SYNC, 254 and 255 by event; the others are reserved or need remote requests. */
static void test_only_transmission_types_that_exist_are_taken(void) {
  for (uint32_t type = 0; type <= 255; type++) {
    const bool good = type <= 240 || type >= 254;
    TEST_ASSERT_EQUAL_HEX32(good ? 0 : 0x06090030, bench_write(0x1400, 2, type, 1));
    TEST_ASSERT_EQUAL_HEX32(good ? 0 : 0x06090030, bench_write(0x1800, 2, type, 1));
  }
}

/* Rows of an application's table whose index is that of a record beyond the node's PDOs: its own hooks judge nothing.
 */
static void test_a_record_beyond_the_last_pdo_is_none_of_the_nodes(void) {
  static const uint16_t beyond[] = {0x1400 + RPDO_COUNT,
                                    0x1600 + RPDO_COUNT,
                                    0x1800 + TPDO_COUNT,
                                    0x1A00 + TPDO_COUNT,
                                    0x14FF,
                                    0x16FF,
                                    0x18FF,
                                    0x1AFF};
  const od_number extended = {.i = 0x20000000};
  const communication_objects before = DEVICE->node.objects;
  for (uint32_t i = 0; i < sizeof beyond / sizeof beyond[0]; i++) {
    const od_entry row = {.type = OD_UNSIGNED32, .index = beyond[i], .sub = 1, .bytes = 4};
    const od_object object = {&DEVICE->node.parts[1], &row};
    TEST_ASSERT_EQUAL_HEX32(OD_OK, node_objects_hooks.accept(&DEVICE->node, &object, extended));
    node_objects_hooks.changed(&DEVICE->node, &object);
    TEST_ASSERT_EQUAL_MEMORY(&before, &DEVICE->node.objects, sizeof before);
  }
}

/* RPDO1 to RPDO4 one after another, each with one byte of its own. */
static void test_each_of_the_four_rpdos_can_wait_for_sync(void) {
  static const uint8_t subs[] = {5, 6, 7, 8}; /* of 2F00: u8, u16, u32, u64 */
  static const uint8_t bits[] = {8, 16, 32, 64};
  for (uint16_t n = 0; n < 4; n++) {
    write_ok((uint16_t)(0x1400 + n), 1, 0x80000000u | (0x205u + 0x100u * n), 4);
    write_ok((uint16_t)(0x1600 + n), 0, 0, 1);
    write_ok((uint16_t)(0x1600 + n), 1, 0x2F000000u | (uint32_t)subs[n] << 8 | bits[n], 4);
    write_ok((uint16_t)(0x1600 + n), 0, 1, 1);
    write_ok((uint16_t)(0x1400 + n), 2, 1, 1);
    write_ok((uint16_t)(0x1400 + n), 1, 0x205u + 0x100u * n, 4);
  }
  bench_operational();
  const test_values before = DEVICE->values;
  for (uint16_t n = 0; n < 4; n++) {
    const uint8_t bytes[8] = {(uint8_t)(100 + n)};
    bench_give(0x205u + 0x100u * n, 8, bytes);
  }
  bench_wait_ms(3);
  TEST_ASSERT_EQUAL_MEMORY(&before, &DEVICE->values, sizeof before);
  bench_give(SYNC, 0, NULL);
  bench_wait_ms(1);
  TEST_ASSERT_EQUAL(100, DEVICE->values.u8);
  TEST_ASSERT_EQUAL(101, DEVICE->values.u16);
  TEST_ASSERT_EQUAL(102, DEVICE->values.u32);
  TEST_ASSERT_EQUAL(103, DEVICE->values.u64);
}

/* Default identifiers of node 5. */
static uint32_t tpdo_identifier(uint16_t n) { return n < 4 ? TPDO1 + 0x100u * n : 0x684u + 12u * (n - 4u); }

/* One byte of the test device in TPDO n + 1. */
static void map_u8(uint16_t n, uint8_t type, uint16_t event_ms) {
  const uint16_t record = (uint16_t)(0x1800 + n);
  write_ok(record, 1, 0x80000000u | tpdo_identifier(n), 4);
  write_ok((uint16_t)(0x1A00 + n), 0, 0, 1);
  write_ok((uint16_t)(0x1A00 + n), 1, 0x2F000508, 4);
  write_ok((uint16_t)(0x1A00 + n), 0, 1, 1);
  write_ok(record, 2, type, 1);
  write_ok(record, 3, 0, 2);
  write_ok(record, 5, event_ms, 2);
  write_ok(record, 1, tpdo_identifier(n), 4);
}

static void test_tpdo5_to_8_are_off_with_identifiers_beyond_the_predefined_set(void) {
  for (uint16_t n = 4; n < TPDO_COUNT; n++) {
    TEST_ASSERT_EQUAL_HEX32(0xC0000000u | tpdo_identifier(n), bench_get((uint16_t)(0x1800 + n), 1));
    TEST_ASSERT_EQUAL(0, bench_get((uint16_t)(0x1A00 + n), 0));
    write_ok((uint16_t)(0x1800 + n), 5, 1, 2);
    write_ok((uint16_t)(0x1800 + n), 1, 0x40000000u | tpdo_identifier(n), 4); /* on, but it maps nothing */
  }
  bench_operational();
  bench_wait_ms(20);
  for (uint16_t n = 4; n < TPDO_COUNT; n++) {
    TEST_ASSERT_EQUAL(0, bench_count(tpdo_identifier(n)));
  }
  TEST_ASSERT_EQUAL_HEX32(0x06020000, bench_write(0x1808, 1, 0x80000000u, 4));
  TEST_ASSERT_EQUAL_HEX32(0x06020000, bench_write(0x1404, 1, 0x80000000u, 4));
}

static void test_tpdo5_to_8_are_sent_in_every_ms_in_their_order(void) {
  for (uint16_t n = 4; n < TPDO_COUNT; n++) {
    map_u8(n, 255, 1);
  }
  bench_operational();
  bench.sent = 0;
  bench_wait_ms(50);
  for (uint16_t n = 4; n < TPDO_COUNT; n++) {
    TEST_ASSERT_EQUAL(50, bench_count(tpdo_identifier(n)));
  }
  uint16_t next = 4;
  for (uint32_t i = 0; i < bench.sent && i < BENCH_LOG; i++) {
    if (bench.log[i].id >= 0x680 && bench.log[i].id < 0x6E0) {
      TEST_ASSERT_EQUAL_HEX32(tpdo_identifier(next), bench.log[i].id);
      next = next == TPDO_COUNT - 1 ? 4 : (uint16_t)(next + 1);
    }
  }
}

static void test_tpdos_after_the_last_one_that_is_on_take_no_time(void) {
  TEST_ASSERT_EQUAL(2, DEVICE->node.tpdos_in_use);
  map_u8(6, 255, 1);
  TEST_ASSERT_EQUAL(7, DEVICE->node.tpdos_in_use);
  map_u8(4, 255, 1);
  TEST_ASSERT_EQUAL(7, DEVICE->node.tpdos_in_use);
  write_ok(0x1806, 1, 0x80000000u, 4);
  TEST_ASSERT_EQUAL(5, DEVICE->node.tpdos_in_use);
  write_ok(0x1804, 1, 0x80000000u, 4);
  TEST_ASSERT_EQUAL(2, DEVICE->node.tpdos_in_use);
  write_ok(0x1801, 1, 0x80000000u, 4);
  TEST_ASSERT_EQUAL(1, DEVICE->node.tpdos_in_use);
  write_ok(0x1800, 1, 0x80000000u, 4);
  TEST_ASSERT_EQUAL(0, DEVICE->node.tpdos_in_use);
}

/* SYNC counts as a frame of the master only when a PDO uses it. */
static void test_a_synchronous_tpdo8_makes_sync_a_sign_of_the_master(void) {
  write_ok(0x1801, 2, 255, 1);
  TEST_ASSERT_TRUE(DEVICE->node.sync_is_used); /* by RPDO2 */
  write_ok(0x1401, 2, 255, 1);
  TEST_ASSERT_FALSE(DEVICE->node.sync_is_used);
  map_u8(7, 1, 0);
  TEST_ASSERT_TRUE(DEVICE->node.sync_is_used);
  write_ok(0x1807, 1, 0x80000000u, 4);
  TEST_ASSERT_FALSE(DEVICE->node.sync_is_used);
}

static void test_each_of_the_eight_tpdos_can_answer_a_sync(void) {
  for (uint16_t n = 0; n < TPDO_COUNT; n++) {
    map_u8(n, 1, 0);
  }
  bench_operational();
  bench_wait_ms(5);
  bench.sent = 0;
  for (uint32_t syncs = 1; syncs <= 3; syncs++) {
    bench_give(SYNC, 0, NULL);
    bench_wait_ms(2);
    for (uint16_t n = 0; n < TPDO_COUNT; n++) {
      TEST_ASSERT_EQUAL(syncs, bench_count(tpdo_identifier(n)));
    }
  }
}

/* 10 ms at 1 Mbit/s, and as much more as a frame then lasts longer; what a master has set stays. */
static void test_default_inhibit_times_follow_the_bit_rate(void) {
  static const struct {
    uint16_t kbit_s;
    uint32_t inhibit_100us;
  } rows[] = {{500, 200}, {125, 800}, {250, 400}, {1000, 100}};
  write_ok(0x1802, 3, 7, 2);
  for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
    canopen_node_set_bit_rate(&DEVICE->node, rows[i].kbit_s);
    TEST_ASSERT_EQUAL(rows[i].inhibit_100us, bench_get(0x1800, 3));
    TEST_ASSERT_EQUAL(7, bench_get(0x1802, 3));
  }
}

/* Eight TPDOs that are sent once, when they start. */
static void test_each_of_the_eight_tpdos_starts_anew_with_another_bit_rate(void) {
  for (uint16_t n = 0; n < TPDO_COUNT; n++) {
    map_u8(n, 255, 0);
  }
  bench_operational();
  bench_wait_ms(5);
  bench.sent = 0;
  bench_wait_ms(20);
  TEST_ASSERT_EQUAL(0, bench.sent);
  canopen_node_set_bit_rate(&DEVICE->node, 500);
  bench_wait_ms(20);
  for (uint16_t n = 0; n < TPDO_COUNT; n++) {
    TEST_ASSERT_EQUAL(1, bench_count(tpdo_identifier(n)));
  }
}

/* The RPDO skips one byte before the controlword, and two between controlword and mode. */
static void test_a_stop_is_obeyed_beside_bytes_that_are_skipped(void) {
  static const uint32_t objects[] = {0x00050008, 0x60400010, 0x00060010, 0x60600008};
  map_into_rpdo1(objects, 4);
  const uint8_t run[6] = {0x77, 0x0F, 0, 0x77, 0x77, 9};
  const uint8_t stop[6] = {0x00, 0x0B, 0, 0x00, 0x00, 11};
  bench_give(RPDO1, 6, run);
  bench_wait_ms(1);
  TEST_ASSERT_EQUAL_HEX16(0x0F, DEVICE->axis[0].controlword);
  TEST_ASSERT_EQUAL(9, DEVICE->axis[0].mode);
  bench_give(RPDO1, 6, stop);
  bench_wait_ms(1);
  TEST_ASSERT_EQUAL_HEX16(0x0B, DEVICE->axis[0].controlword);
  TEST_ASSERT_EQUAL(9, DEVICE->axis[0].mode);
  bench_give(RPDO1, 6, run);
  bench_wait_ms(1);
  bench_give(RPDO1, 5, stop); /* too short */
  bench_wait_ms(1);
  TEST_ASSERT_EQUAL_HEX16(0x0B, DEVICE->axis[0].controlword);
}

/* Four in one ms at most: of more, the bus has no room for the answers. */
static void test_up_to_four_syncs_of_one_ms_are_answered_one_by_one(void) {
  bench_operational();
  bench_wait_ms(5);
  for (uint32_t given = 1; given <= 16; given += 3) {
    bench.sent = 0;
    for (uint32_t n = 0; n < given; n++) {
      bench_give(SYNC, 0, NULL);
    }
    bench_wait_ms(1);
    TEST_ASSERT_EQUAL(given < 4 ? given : 4, bench_count(TPDO2));
    bench_wait_ms(5);
    TEST_ASSERT_EQUAL(given < 4 ? given : 4, bench_count(TPDO2));
  }
}

static void test_a_tpdo_counts_its_syncs_anew_when_the_node_becomes_operational(void) {
  write_ok(0x1801, 2, 3, 1);
  for (int round = 0; round < 2; round++) {
    bench_operational();
    bench.sent = 0;
    for (uint32_t n = 1; n <= 5; n++) { /* the last two are left over */
      bench_give(SYNC, 0, NULL);
      bench_wait_ms(1);
      TEST_ASSERT_EQUAL(n < 3 ? 0 : 1, bench_count(TPDO2));
    }
    bench_nmt(128, BENCH_NODE);
  }
}

/* The node leaves operational behind the SYNC in the same ms, and is started again. */
static void test_a_sync_that_came_before_a_stop_is_not_answered_after_the_next_start(void) {
  static const uint8_t commands[] = {2, 128};
  for (uint32_t i = 0; i < sizeof commands; i++) {
    bench_operational();
    bench_wait_ms(5);
    bench.sent = 0;
    bench_give(SYNC, 0, NULL);
    bench_nmt(commands[i], BENCH_NODE);
    bench_operational();
    bench_wait_ms(5);
    TEST_ASSERT_EQUAL(0, bench_count(TPDO2));
  }
}

/* Without a counter, SYNC carries no start value: the first one counts. */
static void test_a_start_value_is_ignored_by_a_sync_without_counter(void) {
  start_tpdo2_at_counter_4();
  bench_operational();
  bench.sent = 0;
  for (uint32_t n = 1; n <= 6; n++) {
    bench_give(SYNC, 0, NULL);
    bench_wait_ms(1);
    TEST_ASSERT_EQUAL(n / 2, bench_count(TPDO2));
  }
}

static void test_a_full_bus_delays_a_synchronous_tpdo_with_the_values_of_its_sync(void) {
  write_ok(0x1801, 2, 2, 1);
  bench_operational();
  for (int32_t round = 1; round <= 2; round++) {
    bench.sent = 0;
    bench.bus_full = true;
    DEVICE->axis[0].target_velocity = round;
    for (int n = 0; n < 2; n++) {
      bench_give(SYNC, 0, NULL);
      bench_wait_ms(1);
    }
    DEVICE->axis[0].target_velocity = 99;
    bench_wait_ms(3);
    bench.bus_full = false;
    bench_wait_ms(3);
    TEST_ASSERT_EQUAL(1, bench_count(TPDO2));
    TEST_ASSERT_EQUAL(round, bench_last(TPDO2)->data[0]);
  }
}

/* ms from one frame to the next of a TPDO that has something to send in each ms. */
static void test_the_inhibit_time_of_a_tpdo_is_never_shorter_than_set(void) {
  static const struct {
    uint16_t inhibit_100us;
    uint32_t ms;
  } rows[] = {{0, 1}, {1, 1}, {10, 1}, {11, 2}, {20, 2}, {21, 3}, {95, 10}, {100, 10}, {101, 11}};
  for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
    bench_nmt(128, BENCH_NODE);
    map_u8(2, 255, 1);
    write_ok(0x1802, 1, 0x80000000u | TPDO3, 4);
    write_ok(0x1802, 3, rows[i].inhibit_100us, 2);
    write_ok(0x1802, 1, TPDO3, 4);
    bench_operational();
    bench_wait_ms(20);
    bench.sent = 0;
    bench_wait_ms(6 * rows[i].ms);
    TEST_ASSERT_EQUAL(6, bench_count(TPDO3));
  }
}

static void test_the_event_timer_counts_from_the_last_frame(void) {
  map_u8(2, 255, 20);
  bench_operational();
  bench_wait_ms(5);
  bench.sent = 0;
  DEVICE->node.tpdos[2].elapsed_ms = 0;
  bench_wait_ms(19);
  TEST_ASSERT_EQUAL(0, bench_count(TPDO3));
  bench_wait_ms(1);
  TEST_ASSERT_EQUAL(1, bench_count(TPDO3));
  bench_wait_ms(10);
  canopen_node_request_tpdo(&DEVICE->node, 2);
  bench_wait_ms(1);
  TEST_ASSERT_EQUAL(2, bench_count(TPDO3));
  bench_wait_ms(19);
  TEST_ASSERT_EQUAL(2, bench_count(TPDO3));
  bench_wait_ms(1);
  TEST_ASSERT_EQUAL(3, bench_count(TPDO3));
}

/* 20 ms, the one of the frame included. */
static void test_each_silence_of_an_rpdo_is_reported_once(void) {
  const uint8_t bytes[3] = {0x06, 0x00, 9};
  write_ok(0x1400, 5, 20, 2);
  bench_operational();
  for (int round = 0; round < 3; round++) {
    bench_give(RPDO1, 3, bytes);
    bench_wait_ms(19);
    bench_give(RPDO1, 3, bytes);
    bench_wait_ms(1);
    bench.sent = 0;
    bench_wait_ms(18);
    TEST_ASSERT_EQUAL(0, bench_count(0x85));
    bench_wait_ms(1);
    TEST_ASSERT_TRUE(emergency_is_active(&DEVICE->node.emergency, 0, 0x8250));
    bench_wait_ms(100);
    TEST_ASSERT_EQUAL(1, bench_count(0x85));
  }
}

static uint32_t late_rpdos; /* bit n: RPDO n + 1 */

static void note_late(void *context, uint32_t n) {
  (void)context;
  late_rpdos |= 1u << n;
}

static void test_two_rpdos_that_fall_silent_together_are_late_in_the_same_ms(void) {
  const uint8_t bytes[8] = {0x06, 0x00, 9};
  late_rpdos = 0;
  DEVICE->node.config.events.rpdo_late = note_late;
  write_ok(0x1400, 5, 20, 2);
  write_ok(0x1401, 5, 20, 2);
  bench_operational();
  bench_give(RPDO1, 3, bytes);
  bench_give(RPDO2, 8, bytes);
  bench_wait_ms(19);
  TEST_ASSERT_EQUAL_HEX32(0, late_rpdos);
  bench_wait_ms(1);
  TEST_ASSERT_EQUAL_HEX32(3, late_rpdos);
}

/* Into a map that held another mapping. */
static void test_a_mapping_that_is_refused_leaves_none(void) {
  static const struct {
    pdo_mapping mapping;
    od_abort answer;
  } rows[] = {
      {{.count = 2, .entry = {0x60400010, 0x2F000508}}, OD_OK},
      {{.count = 2, .entry = {0x60600008, 0x60400010}}, OD_OK}, /* not in the order of their indices */
      {{.count = 2, .entry = {0x60400010, 0x2FFF0008}}, OD_NO_OBJECT},
      {{.count = 2, .entry = {0x60400010, 0x2F006308}}, OD_NO_SUB},
      {{.count = 2, .entry = {0x60400010, 0x60410010}}, OD_NOT_MAPPABLE},             /* TPDO only */
      {{.count = 3, .entry = {0x60400010, 0x2F000508, 0x60400010}}, OD_NOT_MAPPABLE}, /* twice */
      {{.count = 3, .entry = {0x60400010, 0x2F000508, 0x2F000508}}, OD_NOT_MAPPABLE},
      {{.count = 2, .entry = {0x60400010, 0x2F000840}}, OD_MAPPING_TOO_LONG}, /* 10 bytes */
      {{.count = 9, .entry = {0x60400010}}, OD_MAPPING_TOO_LONG},
  };
  const object_dictionary *dictionary = &DEVICE->node.dictionary;
  for (size_t i = 0; i < sizeof rows / sizeof rows[0]; i++) {
    pdo_map map;
    TEST_ASSERT_EQUAL(OD_OK, pdo_resolve(dictionary, PDO_RECEIVE, &rows[0].mapping, &map));
    TEST_ASSERT_EQUAL_HEX32(rows[i].answer, pdo_resolve(dictionary, PDO_RECEIVE, &rows[i].mapping, &map));
    TEST_ASSERT_EQUAL(rows[i].answer == OD_OK ? 2 : 0, map.count);
    TEST_ASSERT_EQUAL(rows[i].answer == OD_OK ? 3 : 0, map.length);
  }
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_rpdo_acts_at_once_and_only_when_operational);
  RUN_TEST(test_synchronous_rpdo_waits_for_sync);
  RUN_TEST(test_one_value_out_of_range_refuses_the_whole_frame);
  RUN_TEST(test_a_wrong_rpdo_is_reported_though_a_good_one_follows_at_once);
  RUN_TEST(test_wrong_values_in_all_four_rpdos_are_reported_and_over_in_the_next_ms);
  RUN_TEST(test_a_wrong_rpdo_is_reported_though_the_node_leaves_operational_at_once);
  RUN_TEST(test_short_rpdo_is_reported_once_and_cleared_by_a_good_one);
  RUN_TEST(test_silent_rpdo_raises_its_emergency_after_the_event_time);
  RUN_TEST(test_what_waits_for_sync_is_forgotten_with_a_new_start);
  RUN_TEST(test_event_tpdo_reports_the_start_and_each_change_no_faster_than_inhibited);
  RUN_TEST(test_each_byte_of_an_event_sends_a_tpdo_and_no_other_byte_does);
  RUN_TEST(test_full_bus_delays_a_tpdo_and_sends_the_newest);
  RUN_TEST(test_synchronous_tpdo_answers_every_nth_sync);
  RUN_TEST(test_acyclic_synchronous_tpdo_waits_for_event_and_sync);
  RUN_TEST(test_tpdo_with_a_start_value_begins_at_that_counter);
  RUN_TEST(test_mapping_follows_the_sequence_of_the_standard_only);
  RUN_TEST(test_what_cannot_be_mapped_is_refused);
  RUN_TEST(test_values_follow_each_other_however_they_are_read);
  RUN_TEST(test_a_value_that_its_owner_refreshes_is_refreshed_in_each_tpdo);
  RUN_TEST(test_a_command_in_an_rpdo_is_executed_once_for_each_frame);
  RUN_TEST(test_an_rpdo_with_a_value_that_is_refused_executes_nothing);
  RUN_TEST(test_a_value_that_only_its_owner_refuses_is_refused_in_an_rpdo_too);
  RUN_TEST(test_a_command_that_fails_in_an_rpdo_leaves_the_other_objects_written);
  RUN_TEST(test_a_tpdo_that_is_off_sends_nothing_whoever_asks);
  RUN_TEST(test_an_rpdo_that_is_off_takes_nothing_whoever_gives_it);
  RUN_TEST(test_a_frame_of_an_rpdo_that_has_been_switched_off_is_dropped);
  RUN_TEST(test_event_timer_repeats_a_tpdo_and_request_sends_one);
  RUN_TEST(test_a_stop_beside_a_refused_value_is_obeyed_and_the_rest_reported_once);
  RUN_TEST(test_the_stops_of_two_axes_beside_a_refused_value_are_both_obeyed);
  RUN_TEST(test_the_controlwords_of_two_axes_may_be_in_one_rpdo);
  RUN_TEST(test_the_stops_of_two_rpdos_that_wait_for_sync_are_obeyed_when_the_node_leaves_operational);
  RUN_TEST(test_a_sync_waits_until_each_axis_can_take_its_command);
  RUN_TEST(test_a_command_that_must_wait_keeps_its_place_among_the_frames);
  RUN_TEST(test_a_frame_that_repeats_the_commands_of_both_axes_does_not_wait);
  RUN_TEST(test_a_value_that_is_there_already_is_not_refused);
  RUN_TEST(test_a_stop_in_a_frame_that_is_too_short_is_obeyed_and_nothing_else);
  RUN_TEST(test_a_stop_that_waits_for_sync_is_not_replaced_by_a_later_frame);
  RUN_TEST(test_a_command_that_waits_for_sync_does_not_undo_a_stop_in_a_frame_that_is_too_short);
  RUN_TEST(test_a_refused_value_is_over_when_the_rpdo_starts_again);
  RUN_TEST(test_a_refused_value_after_sync_is_reported_too);
  RUN_TEST(test_no_two_services_share_an_identifier);
  RUN_TEST(test_identifiers_of_fixed_services_cannot_be_taken);
  RUN_TEST(test_a_value_that_is_refused_anyway_is_not_refused_as_taken);
  RUN_TEST(test_bits_without_a_meaning_are_taken_and_change_nothing);
  RUN_TEST(test_what_is_off_takes_no_identifier);
  RUN_TEST(test_a_value_that_is_no_identifier_may_equal_one);
  RUN_TEST(test_during_a_change_of_the_bit_rate_only_nmt_is_obeyed);
  RUN_TEST(test_the_identifier_that_a_pdo_has_may_be_written_while_it_is_on);
  RUN_TEST(test_only_transmission_types_that_exist_are_taken);
  RUN_TEST(test_a_record_beyond_the_last_pdo_is_none_of_the_nodes);
  RUN_TEST(test_each_of_the_four_rpdos_can_wait_for_sync);
  RUN_TEST(test_tpdo5_to_8_are_off_with_identifiers_beyond_the_predefined_set);
  RUN_TEST(test_tpdo5_to_8_are_sent_in_every_ms_in_their_order);
  RUN_TEST(test_tpdos_after_the_last_one_that_is_on_take_no_time);
  RUN_TEST(test_a_synchronous_tpdo8_makes_sync_a_sign_of_the_master);
  RUN_TEST(test_each_of_the_eight_tpdos_can_answer_a_sync);
  RUN_TEST(test_default_inhibit_times_follow_the_bit_rate);
  RUN_TEST(test_each_of_the_eight_tpdos_starts_anew_with_another_bit_rate);
  RUN_TEST(test_a_stop_is_obeyed_beside_bytes_that_are_skipped);
  RUN_TEST(test_up_to_four_syncs_of_one_ms_are_answered_one_by_one);
  RUN_TEST(test_a_tpdo_counts_its_syncs_anew_when_the_node_becomes_operational);
  RUN_TEST(test_a_sync_that_came_before_a_stop_is_not_answered_after_the_next_start);
  RUN_TEST(test_a_start_value_is_ignored_by_a_sync_without_counter);
  RUN_TEST(test_a_full_bus_delays_a_synchronous_tpdo_with_the_values_of_its_sync);
  RUN_TEST(test_the_inhibit_time_of_a_tpdo_is_never_shorter_than_set);
  RUN_TEST(test_the_event_timer_counts_from_the_last_frame);
  RUN_TEST(test_each_silence_of_an_rpdo_is_reported_once);
  RUN_TEST(test_two_rpdos_that_fall_silent_together_are_late_in_the_same_ms);
  RUN_TEST(test_a_mapping_that_is_refused_leaves_none);
  return UNITY_END();
}
