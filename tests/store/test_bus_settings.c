/* SPDX-License-Identifier: Apache-2.0 */
/* Node id and bit rate of the servo's node: set by LSS, persisted in flash, followed by COB-IDs and inhibit times. */
#include <stdio.h>

#include "canopen/cob_id.h"
#include "support/flash_model.h"
#include "support/node_objects.h"
#include "support/rigid_machine.h"
#include "unity.h"

enum {
  LOG = 256,
  RESET_MS = 50,
  SAVE_MS = 1000,
  STORED_ID = 42,
  CONFIGURE_ID = 0x11,
  CONFIGURE_RATE = 0x13,
  STORE = 0x17
};
enum { RATE_500 = 2, RATE_250 = 3, RATE_125 = 4, TPDO1 = 0x180, TPDO4 = 0x480 };

#define SAVE 0x65766173u
#define LOAD 0x64616F6Cu

static flash_model model;
static flash_model bus_model;
static hal_flash areas[PARAMETER_STORE_AREAS];
static hal_flash bus_pages;
static servo_node node;
static rigid_machine machine;
static can_frame sent[LOG];
static uint32_t sent_count;
static uint16_t joined_kbit_s;
static uint32_t joins;
static bool join_answers;

static bool send(void *context, const can_frame *frame) {
  (void)context;
  sent[sent_count++ % LOG] = *frame;
  return true;
}

static bool join(void *context, uint16_t kbit_s) {
  (void)context;
  joined_kbit_s = kbit_s;
  joins++;
  return join_answers;
}

static void wait_ms(uint32_t duration_ms) {
  for (uint32_t i = 0; i < duration_ms; ++i) {
    servo_node_tick(&node);
    servo_node_serve(&node);
    servo_node_background(&node);
  }
}

static void power_up(bool recovering) {
  const servo_node_bus bus = {.flash = &bus_pages, .recovering = recovering, .joiner = {join, NULL}};
  rigid_machine_init(&machine);
  bus_model.off = false;
  bus_model.operations_left = -1;
  joins = 0;
  TEST_ASSERT_TRUE(rigid_machine_start_node_on(&machine, &node, 1, (can_sender){send, NULL}, areas, &bus));
  sent_count = 0;
  wait_ms(3);
}

void setUp(void) {
  flash_model_init(&model, 2048, 4);
  flash_model_init(&bus_model, 2048, BUS_SETTINGS_LOG_PAGES);
  areas[0] = flash_model_area(&model, 0);
  areas[1] = flash_model_area(&model, 1);
  bus_pages = flash_model_area(&bus_model, 0);
  join_answers = true;
  power_up(false);
}

void tearDown(void) { TEST_ASSERT_EQUAL(0, model.rule_breaks + bus_model.rule_breaks); }

/* --- the bus
 * --------------------------------------------------------------------------------------------------------- */

static void give(uint32_t id, const uint8_t *bytes, uint8_t length) {
  can_frame frame = {.id = id, .length = length};
  memcpy(frame.data, bytes, length);
  TEST_ASSERT_TRUE(servo_node_receive(&node, &frame));
}

/* The last frame with this identifier since the log was emptied, or NULL. */
static const can_frame *heard(uint32_t id) {
  const can_frame *last = NULL;
  for (uint32_t i = 0; i < sent_count && i < LOG; ++i) {
    last = sent[i].id == id ? &sent[i] : last;
  }
  return last;
}

static void nmt(uint8_t command) {
  give(0, (const uint8_t[]){command, 0}, 2);
  wait_ms(RESET_MS);
}

/* An LSS request that is answered within 5 ms; returns the error, -1 without an answer. */
static int lss(uint8_t command, uint8_t first, uint8_t second) {
  sent_count = 0;
  give(LSS_REQUEST_COB_ID, (const uint8_t[]){command, first, second, 0, 0, 0, 0, 0}, 8);
  wait_ms(5);
  const can_frame *answer = heard(LSS_RESPONSE_COB_ID);
  TEST_ASSERT_TRUE(answer == NULL || (answer->data[0] == command && answer->length == 8));
  return answer == NULL ? -1 : answer->data[1];
}

static void switch_to(uint8_t state) { TEST_ASSERT_EQUAL(-1, lss(0x04, state, 0)); }

static void store_settings(uint8_t node_id, uint8_t rate) {
  switch_to(1);
  TEST_ASSERT_EQUAL(LSS_OK, lss(CONFIGURE_ID, node_id, 0));
  TEST_ASSERT_EQUAL(LSS_OK, lss(CONFIGURE_RATE, 0, rate));
  TEST_ASSERT_EQUAL(LSS_OK, lss(STORE, 0, 0));
  switch_to(0);
}

static uint32_t get(uint16_t index, uint8_t sub) { return node_object_get(&node, index, sub); }

static od_abort set(uint16_t index, uint8_t sub, uint32_t value) { return node_object_set(&node, index, sub, value); }

static void command(uint16_t index, uint8_t group, uint32_t signature) {
  od_abort answer = OD_PENDING;
  for (int ms = 0; ms < SAVE_MS && answer == OD_PENDING; ++ms) {
    answer = set(index, group, signature);
    wait_ms(1);
  }
  TEST_ASSERT_EQUAL(OD_OK, answer);
}

/* A TPDO can be changed while it is off. */
static void set_tpdo4(uint32_t cob_id, uint16_t inhibit_100us) {
  TEST_ASSERT_EQUAL(OD_OK, set(0x1803, 1, COB_ID_INVALID | get(0x1803, 1)));
  TEST_ASSERT_EQUAL(OD_OK, set(0x1803, 3, inhibit_100us));
  TEST_ASSERT_EQUAL(OD_OK, set(0x1803, 1, cob_id));
}

/* --- node id
 * --------------------------------------------------------------------------------------------------------- */

static void test_a_fresh_node_has_id_1_at_1_mbit_s(void) {
  TEST_ASSERT_NOT_NULL(heard(0x701));
  TEST_ASSERT_EQUAL(1, get(0x3050, 1));
  TEST_ASSERT_EQUAL(1000, joined_kbit_s);
  TEST_ASSERT_EQUAL(1, joins);
  TEST_ASSERT_EQUAL(1, get(0x3050, 1));
  TEST_ASSERT_EQUAL(1000, get(0x3050, 2));
  TEST_ASSERT_EQUAL(1, get(0x3050, 3));
  TEST_ASSERT_EQUAL(1000, get(0x3050, 4));
}

static void test_a_new_node_id_counts_from_the_reset_of_the_communication(void) {
  switch_to(1);
  TEST_ASSERT_EQUAL(LSS_OK, lss(CONFIGURE_ID, STORED_ID, 0));
  switch_to(0);
  TEST_ASSERT_EQUAL(1, get(0x3050, 1));
  sent_count = 0;
  nmt(130);
  TEST_ASSERT_NOT_NULL(heard(0x700 + STORED_ID));
  TEST_ASSERT_NULL(heard(0x701));
  TEST_ASSERT_EQUAL(STORED_ID, get(0x3050, 1));
  TEST_ASSERT_EQUAL_HEX32(0x40000000 + TPDO1 + STORED_ID, get(0x1800, 1));
  TEST_ASSERT_EQUAL_HEX32(0x80 + STORED_ID, get(0x1014, 0));
  TEST_ASSERT_EQUAL_HEX32(0x600 + STORED_ID, get(0x1200, 1));
  sent_count = 0;
  give(0x600 + STORED_ID, (const uint8_t[]){0x40, 0x00, 0x10, 0, 0, 0, 0, 0}, 8);
  wait_ms(2);
  TEST_ASSERT_NOT_NULL(heard(0x580 + STORED_ID));
  power_up(false); /* it was not stored */
  TEST_ASSERT_NOT_NULL(heard(0x701));
}

static void test_what_is_stored_counts_from_the_next_start(void) {
  store_settings(STORED_ID, RATE_125);
  TEST_ASSERT_EQUAL(1, get(0x3050, 1));
  TEST_ASSERT_EQUAL(STORED_ID, get(0x3050, 3));
  TEST_ASSERT_EQUAL(125, get(0x3050, 4));
  power_up(false);
  TEST_ASSERT_NOT_NULL(heard(0x700 + STORED_ID));
  TEST_ASSERT_EQUAL(STORED_ID, get(0x3050, 1));
  TEST_ASSERT_EQUAL(125, joined_kbit_s);
  TEST_ASSERT_EQUAL(STORED_ID, get(0x3050, 1));
  TEST_ASSERT_EQUAL(125, get(0x3050, 2));
}

static void test_a_node_without_id_is_silent_but_for_lss(void) {
  store_settings(BUS_UNCONFIGURED, 0);
  power_up(false);
  nmt(1);
  give(0x601, (const uint8_t[]){0x40, 0x00, 0x10, 0, 0, 0, 0, 0}, 8);
  give(0x6FF, (const uint8_t[]){0x40, 0x00, 0x10, 0, 0, 0, 0, 0}, 8);
  wait_ms(500);
  TEST_ASSERT_EQUAL(0, sent_count);
  TEST_ASSERT_EQUAL(255, get(0x3050, 1));
  TEST_ASSERT_EQUAL(255, get(0x3050, 1));
  give(LSS_REQUEST_COB_ID, (const uint8_t[]){0x4C, 0, 0, 0, 0, 0, 0, 0}, 8);
  wait_ms(2);
  TEST_ASSERT_EQUAL_HEX8(0x50, heard(LSS_RESPONSE_COB_ID)->data[0]);
  switch_to(1);
  TEST_ASSERT_EQUAL(LSS_OK, lss(CONFIGURE_ID, STORED_ID, 0));
  switch_to(0);
  wait_ms(RESET_MS);
  TEST_ASSERT_NOT_NULL_MESSAGE(heard(0x700 + STORED_ID), "no boot-up with its first node id");
  TEST_ASSERT_EQUAL(STORED_ID, get(0x3050, 1));
  TEST_ASSERT_EQUAL_HEX32(0x80 + STORED_ID, get(0x1014, 0));
}

static void test_a_node_may_lose_its_id(void) {
  switch_to(1);
  TEST_ASSERT_EQUAL(LSS_OK, lss(CONFIGURE_ID, BUS_UNCONFIGURED, 0));
  switch_to(0);
  nmt(130);
  sent_count = 0;
  wait_ms(500);
  TEST_ASSERT_EQUAL(0, sent_count);
}

static void test_with_torque_lss_changes_nothing(void) {
  for (uint32_t controlword = 6; controlword <= 7; ++controlword) {
    TEST_ASSERT_EQUAL(OD_OK, set(0x6040, 0, controlword));
    wait_ms(5);
  }
  TEST_ASSERT_EQUAL(OD_OK, set(0x6040, 0, 0x0F));
  wait_ms(5);
  TEST_ASSERT_EQUAL_HEX32(0x27, get(0x6041, 0) & 0x6F);
  switch_to(1);
  TEST_ASSERT_EQUAL(LSS_SEE_DETAIL, lss(CONFIGURE_ID, 9, 0));
  TEST_ASSERT_EQUAL(LSS_SEE_DETAIL, lss(CONFIGURE_RATE, 0, RATE_125));
  TEST_ASSERT_EQUAL(LSS_SEE_DETAIL, lss(STORE, 0, 0));
  TEST_ASSERT_EQUAL(-1, lss(0x15, 0, 0));
  TEST_ASSERT_EQUAL(1, joins);
  TEST_ASSERT_EQUAL(0, bus_model.operations);
  TEST_ASSERT_EQUAL(OD_OK, set(0x6040, 0, 0));
  wait_ms(300);
  TEST_ASSERT_EQUAL(LSS_OK, lss(CONFIGURE_ID, 9, 0));
}

/* --- bit rate
 * -------------------------------------------------------------------------------------------------------- */

/* Of all four TPDOs, as fast as their inhibit times allow: 8 bytes are 135 bits with the most stuffing, 7 are
 * 125. */
static double share_of_bus(uint32_t kbit_s) {
  static const double bits[] = {125, 125, 135, 135};
  double share = 0.0;
  for (uint16_t n = 0; n < 4; ++n) {
    share += bits[n] / ((double)get((uint16_t)(0x1800 + n), 3) * 0.1 * kbit_s);
  }
  return share;
}

static void test_default_inhibit_times_leave_half_of_the_bus_at_every_bit_rate(void) {
  static const struct {
    uint8_t index;
    uint32_t kbit_s;
  } rates[] = {{0, 1000}, {RATE_500, 500}, {RATE_250, 250}, {RATE_125, 125}};
  for (uint32_t i = 0; i < 4; ++i) {
    setUp();
    store_settings(1, rates[i].index);
    power_up(false);
    TEST_ASSERT_EQUAL(rates[i].kbit_s, get(0x3050, 2));
    printf("%4u kbit/s: inhibit time %.1f ms, TPDOs take at most %.0f %% of the bus\n", (unsigned)rates[i].kbit_s,
           0.1 * get(0x1800, 3), 100.0 * share_of_bus(rates[i].kbit_s));
    TEST_ASSERT_TRUE(share_of_bus(rates[i].kbit_s) <= 0.5);
  }
}

static void activate(uint16_t delay_ms) {
  give(LSS_REQUEST_COB_ID, (const uint8_t[]){0x15, (uint8_t)delay_ms, (uint8_t)(delay_ms >> 8), 0, 0, 0, 0, 0}, 8);
}

static void test_an_activated_bit_rate_counts_at_once_after_two_silent_times(void) {
  switch_to(1);
  TEST_ASSERT_EQUAL(LSS_OK, lss(CONFIGURE_RATE, 0, RATE_250));
  nmt(1);
  activate(150);
  wait_ms(2);
  sent_count = 0;
  wait_ms(140);
  TEST_ASSERT_EQUAL(1000, joined_kbit_s);
  wait_ms(20);
  TEST_ASSERT_EQUAL(250, joined_kbit_s);
  TEST_ASSERT_EQUAL(250, get(0x3050, 2));
  TEST_ASSERT_EQUAL(1000, get(0x3050, 4));
  wait_ms(130);
  TEST_ASSERT_EQUAL_MESSAGE(0, sent_count, "not silent");
  wait_ms(20);
  TEST_ASSERT_NOT_NULL(heard(0x701));
  TEST_ASSERT_EQUAL(80, get(0x1800, 3));
  TEST_ASSERT_EQUAL(80, node.canopen.tpdos[0].communication->inhibit_100us);
  nmt(130);
  TEST_ASSERT_EQUAL(250, joined_kbit_s);
  TEST_ASSERT_EQUAL(80, get(0x1800, 3));
  power_up(false); /* it was not stored */
  TEST_ASSERT_EQUAL(1000, joined_kbit_s);
  TEST_ASSERT_EQUAL(20, get(0x1800, 3));
}

static void test_a_wrong_stored_bit_rate_is_recovered_without_it(void) {
  store_settings(STORED_ID, RATE_125);
  power_up(true);
  TEST_ASSERT_NOT_NULL(heard(0x701));
  TEST_ASSERT_EQUAL(1000, joined_kbit_s);
  TEST_ASSERT_EQUAL(STORED_ID, get(0x3050, 3));
  TEST_ASSERT_EQUAL(125, get(0x3050, 4));
  switch_to(1);
  TEST_ASSERT_EQUAL(LSS_OK, lss(STORE, 0, 0));
  power_up(false);
  TEST_ASSERT_EQUAL(1, get(0x3050, 1));
  TEST_ASSERT_EQUAL(1000, joined_kbit_s);
}

static void test_a_controller_that_does_not_answer_is_known(void) {
  TEST_ASSERT_FALSE(node.objects.bus.join_failed);
  join_answers = false;
  power_up(false);
  TEST_ASSERT_TRUE(node.objects.bus.join_failed);
}

/* --- beside 0x1010 and 0x1011
 * ---------------------------------------------------------------------------------------- */

static void test_lss_and_the_parameter_store_keep_each_other(void) {
  TEST_ASSERT_EQUAL(OD_OK, set(0x607F, 0, 654321));
  command(0x1010, 1, SAVE);
  store_settings(STORED_ID, RATE_500);
  power_up(false);
  TEST_ASSERT_EQUAL(654321, get(0x607F, 0));
  TEST_ASSERT_EQUAL(STORED_ID, get(0x3050, 1));
  command(0x1010, 1, SAVE);
  power_up(false);
  TEST_ASSERT_EQUAL(STORED_ID, get(0x3050, 1));
  command(0x1011, 1, LOAD);
  power_up(false);
  TEST_ASSERT_EQUAL(1000000, get(0x607F, 0));
  TEST_ASSERT_EQUAL(STORED_ID, get(0x3050, 1));
  TEST_ASSERT_EQUAL(500, get(0x3050, 2));
}

static void test_saved_defaults_follow_node_id_and_bit_rate_and_other_values_stay(void) {
  set_tpdo4(0x40000000 + 0x3C0, 123);
  command(0x1010, 1, SAVE);
  store_settings(STORED_ID, RATE_125);
  power_up(false);
  TEST_ASSERT_EQUAL_HEX32(0x40000000 + TPDO1 + STORED_ID, get(0x1800, 1));
  TEST_ASSERT_EQUAL(160, get(0x1800, 3));
  TEST_ASSERT_EQUAL_HEX32(0x40000000 + 0x3C0, get(0x1803, 1));
  TEST_ASSERT_EQUAL(123, get(0x1803, 3));
  command(0x1010, 1, SAVE); /* now with node id 42 at 125 kbit/s */
  store_settings(7, RATE_250);
  power_up(false);
  TEST_ASSERT_EQUAL_HEX32(0x40000000 + TPDO1 + 7, get(0x1800, 1));
  TEST_ASSERT_EQUAL_HEX32(0x80 + 7, get(0x1014, 0));
  TEST_ASSERT_EQUAL(80, get(0x1800, 3));
  TEST_ASSERT_EQUAL(123, get(0x1803, 3));
  command(0x1011, 1, LOAD);
  power_up(false);
  TEST_ASSERT_EQUAL_HEX32(0x40000000 + TPDO4 + 7, get(0x1803, 1));
  TEST_ASSERT_EQUAL(80, get(0x1803, 3));
}

static void test_an_identifier_that_is_another_nodes_default_stays(void) {
  set_tpdo4(0x40000000 + TPDO4 + STORED_ID, 20); /* the defaults for node 42 */
  command(0x1010, 1, SAVE);
  store_settings(9, 0);
  power_up(false);
  TEST_ASSERT_EQUAL_HEX32(0x40000000 + TPDO4 + STORED_ID, get(0x1803, 1));
  TEST_ASSERT_EQUAL_HEX32(0x40000000 + TPDO1 + 9, get(0x1800, 1));
}

static void test_a_tpdo_that_is_off_stays_off_with_another_node_id(void) {
  TEST_ASSERT_EQUAL(OD_OK, set(0x1803, 1, COB_ID_INVALID | (TPDO4 + 1)));
  command(0x1010, 2, SAVE);
  switch_to(1);
  TEST_ASSERT_EQUAL(LSS_OK, lss(CONFIGURE_ID, STORED_ID, 0));
  nmt(130);
  TEST_ASSERT_EQUAL_HEX32(COB_ID_INVALID | (TPDO4 + STORED_ID), get(0x1803, 1));
}

/* 680h to 6AFh: docs/decisions/canopen.md. The other half of the free range is for clients that borrow PDOs. */
static void test_tpdo5_to_8_of_the_first_twelve_nodes_have_identifiers_of_their_own(void) {
  bool used[0x800] = {false};
  for (uint8_t id = 1; id <= 12; ++id) {
    switch_to(1);
    TEST_ASSERT_EQUAL(LSS_OK, lss(CONFIGURE_ID, id, 0));
    nmt(130);
    for (uint16_t n = 4; n < TPDO_COUNT; ++n) {
      const uint32_t cob_id = get((uint16_t)(0x1800 + n), 1);
      TEST_ASSERT_EQUAL_HEX32(0xC0000000, cob_id & ~COB_ID_IDENTIFIER);
      const uint32_t identifier = cob_id & COB_ID_IDENTIFIER;
      TEST_ASSERT_TRUE(identifier >= 0x680 && identifier <= 0x6AF && !used[identifier]);
      used[identifier] = true;
      TEST_ASSERT_EQUAL(OD_OK, set((uint16_t)(0x1800 + n), 1, COB_ID_NO_REMOTE | identifier));
    }
  }
}

/* TPDO8 of node 127 would be 722h, which belongs to heartbeats. */
static void test_a_default_identifier_beyond_the_free_range_does_not_hinder_the_start(void) {
  switch_to(1);
  TEST_ASSERT_EQUAL(LSS_OK, lss(CONFIGURE_ID, 127, 0));
  nmt(130);
  TEST_ASSERT_EQUAL_HEX32(0xC0000722, get(0x1807, 1));
  TEST_ASSERT_EQUAL_HEX32(OD_BAD_VALUE, set(0x1807, 1, 0x40000722));
  command(0x1010, 2, SAVE);
  power_up(false);
  TEST_ASSERT_TRUE(get(0x3031, 1) <= 1);
}

static void test_a_node_id_that_may_be_an_older_one_is_reported_until_the_next_save(void) {
  store_settings(7, RATE_500);
  store_settings(STORED_ID, RATE_250);
  TEST_ASSERT_FALSE(emergency_is_active(&node.canopen.emergency, SERVO_AXES + 2, 0x6310));
  const uint32_t newest = node.objects.bus.log.newest_unit;
  bus_model.weak[newest].shows = SHOWS_UNREADABLE;
  power_up(false);
  TEST_ASSERT_EQUAL(7, get(0x3050, 1));
  TEST_ASSERT_TRUE(emergency_is_active(&node.canopen.emergency, SERVO_AXES + 2, 0x6310));
  TEST_ASSERT_EQUAL_HEX32(0x08, get(0x6041, 0) & 0x4F); /* it may be the address of another machine */
  store_settings(7, RATE_500); /* the same: written all the same, because another one may be newer */
  TEST_ASSERT_FALSE(emergency_is_active(&node.canopen.emergency, SERVO_AXES + 2, 0x6310));
  bus_model.weak[newest].shows = SHOWS_RIGHT;
  power_up(false);
  TEST_ASSERT_EQUAL(7, get(0x3050, 1));
  TEST_ASSERT_FALSE(emergency_is_active(&node.canopen.emergency, SERVO_AXES + 2, 0x6310));
}

/* --- loss of power
 * --------------------------------------------------------------------------------------------------- */

static bool stored_is_reported(uint8_t detail) {
  bool found = false;
  for (uint32_t i = 0; i < sent_count && i < LOG; ++i) {
    found = found || (sent[i].data[0] == 0x10 && sent[i].data[1] == 0x63 && sent[i].data[3] == detail);
  }
  return found;
}

/* SYNC on an identifier that is RPDO1's under the new node id. */
static void test_a_node_id_under_which_cob_ids_collide_takes_their_defaults_and_says_so(void) {
  TEST_ASSERT_EQUAL(OD_OK, set(0x1005, 0, 0x200 + STORED_ID));
  command(0x1010, 2, SAVE);
  switch_to(1);
  TEST_ASSERT_EQUAL(LSS_OK, lss(CONFIGURE_ID, STORED_ID, 0));
  switch_to(0);
  sent_count = 0;
  nmt(130);
  TEST_ASSERT_EQUAL_HEX32(0x80, get(0x1005, 0));
  TEST_ASSERT_EQUAL_HEX32(0x200 + STORED_ID, get(0x1400, 1) & COB_ID_IDENTIFIER);
  TEST_ASSERT_TRUE(stored_is_reported(8));
  command(0x1010, 2, SAVE);
  TEST_ASSERT_FALSE_MESSAGE(node.cob_ids_collide, "the save stored identifiers that do not collide");
  sent_count = 0;
  nmt(130);
  TEST_ASSERT_FALSE(stored_is_reported(8));
}

static void test_a_loss_of_power_while_lss_stores_leaves_the_old_settings_or_the_new_ones(void) {
  for (int kind = 0; kind < FLASH_CUTS; ++kind) {
    setUp();
    store_settings(7, RATE_500);
    TEST_ASSERT_EQUAL(2, bus_model.operations); /* the mark of the first save after a start, and the entry */
    bus_model.cut = (flash_cut)kind;
    bus_model.operations_left = 0;
    switch_to(1);
    TEST_ASSERT_EQUAL(LSS_OK, lss(CONFIGURE_ID, STORED_ID, 0));
    TEST_ASSERT_EQUAL(LSS_STORE_FAILED, lss(STORE, 0, 0));
    power_up(false);
    TEST_ASSERT_EQUAL(7, get(0x3050, 1));
    TEST_ASSERT_EQUAL(500, joined_kbit_s);
    store_settings(STORED_ID, RATE_250);
    power_up(false);
    TEST_ASSERT_EQUAL(STORED_ID, get(0x3050, 1));
  }
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_a_fresh_node_has_id_1_at_1_mbit_s);
  RUN_TEST(test_a_new_node_id_counts_from_the_reset_of_the_communication);
  RUN_TEST(test_what_is_stored_counts_from_the_next_start);
  RUN_TEST(test_a_node_without_id_is_silent_but_for_lss);
  RUN_TEST(test_a_node_may_lose_its_id);
  RUN_TEST(test_with_torque_lss_changes_nothing);
  RUN_TEST(test_default_inhibit_times_leave_half_of_the_bus_at_every_bit_rate);
  RUN_TEST(test_an_activated_bit_rate_counts_at_once_after_two_silent_times);
  RUN_TEST(test_a_wrong_stored_bit_rate_is_recovered_without_it);
  RUN_TEST(test_a_controller_that_does_not_answer_is_known);
  RUN_TEST(test_lss_and_the_parameter_store_keep_each_other);
  RUN_TEST(test_saved_defaults_follow_node_id_and_bit_rate_and_other_values_stay);
  RUN_TEST(test_an_identifier_that_is_another_nodes_default_stays);
  RUN_TEST(test_a_tpdo_that_is_off_stays_off_with_another_node_id);
  RUN_TEST(test_tpdo5_to_8_of_the_first_twelve_nodes_have_identifiers_of_their_own);
  RUN_TEST(test_a_default_identifier_beyond_the_free_range_does_not_hinder_the_start);
  RUN_TEST(test_a_node_id_under_which_cob_ids_collide_takes_their_defaults_and_says_so);
  RUN_TEST(test_a_node_id_that_may_be_an_older_one_is_reported_until_the_next_save);
  RUN_TEST(test_a_loss_of_power_while_lss_stores_leaves_the_old_settings_or_the_new_ones);
  return UNITY_END();
}
