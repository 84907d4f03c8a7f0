/* SPDX-License-Identifier: Apache-2.0 */
/* LSS: each service of one slave, and a master that finds many of them by fastscan. */
#include "canopen/lss_slave.h"
#include "support/random.h"
#include "unity.h"

enum { WAITING = 0, CONFIGURATION = 1, NO_ANSWER = 0, FOUND = 0x4F };

static lss_slave slave;
static bool torque;
static lss_store_progress store_says;
static bus_settings stored;
static uint32_t stores;
static uint16_t activated;

static const uint32_t identity[LSS_IDENTITY_PARTS] = {0, 0x54534456, 1, 0xCAFE0001};

static bool has_torque(void *context) {
  (void)context;
  return torque;
}

static lss_store_progress store(void *context, const bus_settings *settings) {
  (void)context;
  stores++;
  stored = *settings;
  return store_says;
}

static void activate(void *context, uint16_t kbit_s) {
  (void)context;
  activated = kbit_s;
}

static void start(uint8_t node_id) {
  const lss_callbacks callbacks = {.has_torque = has_torque, .store = store, .activate = activate};
  lss_slave_init(&slave, &(bus_settings){node_id, 1000}, &callbacks);
  lss_slave_identify(&slave, identity);
  torque = false;
  store_says = LSS_STORE_DONE;
  stored = (bus_settings){0, 0};
  stores = 0;
  activated = 0;
}

void setUp(void) { start(1); }
void tearDown(void) {}

/* Sends a request; returns the answer's first byte, NO_ANSWER if there is none. */
static uint8_t ask_bytes(const uint8_t bytes[LSS_BYTES]) {
  (void)lss_slave_receive(&slave, bytes);
  const uint8_t *answer = lss_slave_outgoing(&slave);
  const uint8_t command = answer != NULL ? answer[0] : NO_ANSWER;
  lss_slave_sent(&slave);
  TEST_ASSERT_NULL(lss_slave_outgoing(&slave));
  return command;
}

static uint8_t ask(uint8_t command, uint8_t first, uint8_t second) {
  return ask_bytes((const uint8_t[LSS_BYTES]){command, first, second});
}

static uint8_t ask_number(uint8_t command, uint32_t number) {
  return ask_bytes((const uint8_t[LSS_BYTES]){command, (uint8_t)number, (uint8_t)(number >> 8), (uint8_t)(number >> 16),
                                              (uint8_t)(number >> 24)});
}

static uint32_t number_answered(void) {
  uint32_t number;
  memcpy(&number, &slave.answer[1], sizeof number);
  return number;
}

static void switch_to(uint8_t state) { TEST_ASSERT_EQUAL_HEX8(NO_ANSWER, ask(0x04, state, 0)); }

/* Second byte of the answer. */
static uint8_t error_of(uint8_t command, uint8_t first, uint8_t second) {
  TEST_ASSERT_EQUAL_HEX8(command, ask(command, first, second));
  TEST_ASSERT_EQUAL(slave.answer[1] == LSS_SEE_DETAIL ? LSS_DETAIL_TORQUE : 0, slave.answer[2]);
  return slave.answer[1];
}

/* --- states
 * --------------------------------------------------------------------------------------------------------- */

static void test_a_waiting_slave_neither_answers_nor_changes_anything(void) {
  static const uint8_t commands[] = {0x11, 0x13, 0x15, 0x17, 0x5A, 0x5B, 0x5C, 0x5D, 0x5E};
  for (uint32_t i = 0; i < sizeof commands; ++i) {
    TEST_ASSERT_EQUAL_HEX8(NO_ANSWER, ask(commands[i], 3, 3));
  }
  TEST_ASSERT_EQUAL(1, slave.pending.node_id);
  TEST_ASSERT_EQUAL(0, stores);
  TEST_ASSERT_FALSE(lss_slave_is_silent(&slave));
}

static void test_no_other_command_is_answered_in_either_state(void) {
  static const uint8_t known[] = {0x11, 0x13, 0x17, 0x5A, 0x5B, 0x5C, 0x5D, 0x5E};
  for (uint8_t state = WAITING; state <= CONFIGURATION; ++state) {
    for (uint32_t command = 0; command <= 0xFF; ++command) {
      const bool answered = memchr(known, (int)command, sizeof known) != NULL;
      start(1);
      switch_to(state);
      TEST_ASSERT_EQUAL_HEX8(state == CONFIGURATION && answered ? command : NO_ANSWER, ask((uint8_t)command, 0xEE, 0));
    }
  }
}

static void test_a_state_that_does_not_exist_is_ignored(void) {
  switch_to(CONFIGURATION);
  switch_to(2);
  TEST_ASSERT_EQUAL_HEX8(0x5E, ask(0x5E, 0, 0));
}

/* One of the four is too small by 1 or too large by 1, or none is wrong. */
static void test_the_four_numbers_in_order_select_this_slave_alone(void) {
  for (uint32_t i = 0; i <= 2 * LSS_IDENTITY_PARTS; ++i) {
    const uint32_t wrong = i / 2;
    const uint32_t error = i % 2 == 0 ? 1u : UINT32_MAX;
    start(1);
    for (uint8_t part = 0; part < LSS_IDENTITY_PARTS; ++part) {
      const bool selects = wrong == LSS_IDENTITY_PARTS && part == 3;
      TEST_ASSERT_EQUAL_HEX8(selects ? 0x44 : NO_ANSWER,
                             ask_number((uint8_t)(0x40 + part), identity[part] + (part == wrong ? error : 0u)));
    }
    TEST_ASSERT_EQUAL(wrong == LSS_IDENTITY_PARTS, slave.configuring);
  }
  static const uint8_t rest[LSS_BYTES - 1] = {0};
  TEST_ASSERT_EQUAL_HEX8_ARRAY(rest, &slave.answer[1], sizeof rest);
}

static void test_numbers_out_of_order_select_nothing(void) {
  (void)ask_number(0x40, identity[0]);
  (void)ask_number(0x42, identity[2]);
  TEST_ASSERT_EQUAL_HEX8(NO_ANSWER, ask_number(0x43, identity[3]));
  for (uint8_t part = 0; part < 3; ++part) {
    (void)ask_number((uint8_t)(0x40 + part), identity[part]);
  }
  TEST_ASSERT_EQUAL_HEX8(0x44, ask_number(0x43, identity[3]));
  switch_to(WAITING);
  for (uint8_t part = 1; part < LSS_IDENTITY_PARTS; ++part) { /* the first number is asked for anew */
    TEST_ASSERT_EQUAL_HEX8(NO_ANSWER, ask_number((uint8_t)(0x40 + part), identity[part]));
  }
}

/* --- inquiries
 * ------------------------------------------------------------------------------------------------------ */

static void test_it_says_who_it_is_also_with_torque(void) {
  torque = true;
  switch_to(CONFIGURATION);
  for (uint8_t part = 0; part < LSS_IDENTITY_PARTS; ++part) {
    TEST_ASSERT_EQUAL_HEX8(0x5A + part, ask((uint8_t)(0x5A + part), 0, 0));
    TEST_ASSERT_EQUAL_HEX32(identity[part], number_answered());
  }
  TEST_ASSERT_EQUAL_HEX8(0x5E, ask(0x5E, 0, 0));
  TEST_ASSERT_EQUAL(1, slave.answer[1]);
  start(BUS_UNCONFIGURED);
  switch_to(CONFIGURATION);
  TEST_ASSERT_EQUAL_HEX8(0x5E, ask(0x5E, 0, 0));
  TEST_ASSERT_EQUAL(255, slave.answer[1]);
}

static bool is_identified(uint32_t vendor, uint32_t product, uint32_t revision_low, uint32_t revision_high,
                          uint32_t serial_low, uint32_t serial_high) {
  const uint32_t numbers[] = {vendor, product, revision_low, revision_high, serial_low, serial_high};
  uint8_t answer = NO_ANSWER;
  for (uint8_t step = 0; step < 6; ++step) {
    answer = ask_number((uint8_t)(0x46 + step), numbers[step]);
    TEST_ASSERT_TRUE(step == 5 || answer == NO_ANSWER);
  }
  return answer == FOUND;
}

static void test_identify_answers_for_its_product_within_the_ranges(void) {
  const uint32_t serial = identity[3];
  TEST_ASSERT_TRUE(is_identified(0, identity[1], 1, 1, serial, serial));
  TEST_ASSERT_TRUE(is_identified(0, identity[1], 0, UINT32_MAX, 0, UINT32_MAX));
  TEST_ASSERT_FALSE(is_identified(1, identity[1], 0, UINT32_MAX, 0, UINT32_MAX));
  TEST_ASSERT_FALSE(is_identified(0, 0, 0, UINT32_MAX, 0, UINT32_MAX));
  TEST_ASSERT_FALSE(is_identified(0, identity[1], 2, UINT32_MAX, 0, UINT32_MAX));
  TEST_ASSERT_FALSE(is_identified(0, identity[1], 0, 0, 0, UINT32_MAX));
  TEST_ASSERT_FALSE(is_identified(0, identity[1], 0, UINT32_MAX, serial + 1, UINT32_MAX));
  TEST_ASSERT_FALSE(is_identified(0, identity[1], 0, UINT32_MAX, 0, serial - 1));
}

/* The first of the six requests begins anew, whatever came before it; the others count only in their order. */
static void test_an_identification_is_answered_after_its_six_requests_in_order_only(void) {
  static const struct {
    uint8_t count, steps[8], answer; /* to the last one */
  } rows[] = {{6, {0, 1, 2, 3, 4, 5}, FOUND},        {7, {0, 0, 1, 2, 3, 4, 5}, FOUND},
              {8, {0, 1, 0, 1, 2, 3, 4, 5}, FOUND},  {5, {1, 2, 3, 4, 5}, NO_ANSWER},
              {6, {3, 1, 2, 3, 4, 5}, NO_ANSWER},    {5, {0, 1, 2, 3, 5}, NO_ANSWER},
              {7, {0, 1, 2, 2, 3, 4, 5}, NO_ANSWER}, {6, {0, 1, 3, 2, 4, 5}, NO_ANSWER}};
  const uint32_t numbers[] = {identity[0], identity[1], identity[2], identity[2], identity[3], identity[3]};
  for (size_t i = 0; i < sizeof rows / sizeof rows[0]; ++i) {
    start(1);
    for (uint8_t n = 0; n < rows[i].count; ++n) {
      const uint8_t step = rows[i].steps[n];
      TEST_ASSERT_EQUAL_HEX8(n + 1 == rows[i].count ? rows[i].answer : NO_ANSWER,
                             ask_number((uint8_t)(0x46 + step), numbers[step]));
    }
  }
}

static void test_only_a_slave_without_node_id_answers_who_looks_for_such(void) {
  TEST_ASSERT_EQUAL_HEX8(NO_ANSWER, ask(0x4C, 0, 0));
  start(BUS_UNCONFIGURED);
  TEST_ASSERT_EQUAL_HEX8(0x50, ask(0x4C, 0, 0));
}

/* --- configuration
 * -------------------------------------------------------------------------------------------------- */

static void test_a_node_id_is_pending_until_the_communication_is_reset(void) {
  switch_to(CONFIGURATION);
  TEST_ASSERT_EQUAL(LSS_OK, error_of(0x11, 127, 0));
  TEST_ASSERT_EQUAL(1, slave.active.node_id);
  lss_slave_take_node_id(&slave);
  TEST_ASSERT_EQUAL(127, slave.active.node_id);
}

static void test_node_ids_that_do_not_exist_are_refused(void) {
  switch_to(CONFIGURATION);
  for (uint32_t node_id = 0; node_id <= 255; ++node_id) {
    const bool good = (node_id >= 1 && node_id <= 127) || node_id == 255;
    slave.pending.node_id = 99;
    TEST_ASSERT_EQUAL(good ? LSS_OK : LSS_OUT_OF_RANGE, error_of(0x11, (uint8_t)node_id, 0));
    TEST_ASSERT_EQUAL(good ? node_id : 99, slave.pending.node_id);
  }
}

static void test_bit_rates_of_the_table_are_taken_or_refused(void) {
  static const uint16_t kbit_s[] = {1000, 0, 500, 250, 125};
  switch_to(CONFIGURATION);
  for (uint32_t index = 0; index <= 255; ++index) {
    const uint16_t wanted = index < 5 ? kbit_s[index] : 0;
    slave.pending.kbit_s = 1;
    TEST_ASSERT_EQUAL(wanted != 0 ? LSS_OK : LSS_OUT_OF_RANGE, error_of(0x13, 0, (uint8_t)index));
    TEST_ASSERT_EQUAL(wanted != 0 ? wanted : 1, slave.pending.kbit_s);
  }
  TEST_ASSERT_EQUAL(LSS_OUT_OF_RANGE, error_of(0x13, 1, 0)); /* another table */
  TEST_ASSERT_EQUAL(0, bus_kbit_s_of_index(bus_index_of_kbit_s(0)));
  TEST_ASSERT_EQUAL(0, bus_kbit_s_of_index(bus_index_of_kbit_s(800)));
  TEST_ASSERT_EQUAL(125, bus_kbit_s_of_index(bus_index_of_kbit_s(125)));
}

static void test_what_is_pending_is_stored_and_answered_when_it_is(void) {
  switch_to(CONFIGURATION);
  (void)error_of(0x11, 42, 0);
  (void)error_of(0x13, 0, 4);
  store_says = LSS_STORE_PENDING;
  TEST_ASSERT_EQUAL_HEX8(NO_ANSWER, ask(0x17, 0, 0));
  TEST_ASSERT_EQUAL_HEX8(NO_ANSWER, ask(0x11, 43, 0)); /* one at a time */
  lss_slave_tick(&slave);
  TEST_ASSERT_NULL(lss_slave_outgoing(&slave));
  store_says = LSS_STORE_DONE;
  lss_slave_tick(&slave);
  TEST_ASSERT_NOT_NULL(lss_slave_outgoing(&slave));
  TEST_ASSERT_EQUAL_HEX8(0x17, slave.answer[0]);
  TEST_ASSERT_EQUAL(LSS_OK, slave.answer[1]);
  TEST_ASSERT_EQUAL(0, slave.answer[2]);
  TEST_ASSERT_EQUAL(42, stored.node_id);
  TEST_ASSERT_EQUAL(125, stored.kbit_s);
  lss_slave_sent(&slave);
  lss_slave_tick(&slave);
  TEST_ASSERT_EQUAL(3, stores);
}

static void test_a_store_that_fails_or_is_not_there_says_so(void) {
  switch_to(CONFIGURATION);
  store_says = LSS_STORE_REFUSED;
  TEST_ASSERT_EQUAL(LSS_STORE_FAILED, error_of(0x17, 0, 0));
  slave.callbacks.store = NULL;
  TEST_ASSERT_EQUAL(LSS_STORE_UNSUPPORTED, error_of(0x17, 0, 0));
}

static void test_with_torque_nothing_is_changed(void) {
  static const uint8_t commands[] = {0x11, 0x13, 0x17};
  torque = true;
  switch_to(CONFIGURATION);
  for (uint32_t i = 0; i < sizeof commands; ++i) {
    TEST_ASSERT_EQUAL(LSS_SEE_DETAIL, error_of(commands[i], 2, 2));
  }
  TEST_ASSERT_EQUAL(1, slave.pending.node_id);
  TEST_ASSERT_EQUAL(1000, slave.pending.kbit_s);
  TEST_ASSERT_EQUAL(0, stores);
  TEST_ASSERT_EQUAL_HEX8(NO_ANSWER, ask(0x15, 0, 0));
  TEST_ASSERT_FALSE(lss_slave_is_silent(&slave));
}

/* --- change of the bit rate
 * ------------------------------------------------------------------------------------------ */

static void test_the_bit_rate_changes_between_two_times_of_silence(void) {
  const uint16_t delay_ms = 300;
  switch_to(CONFIGURATION);
  (void)error_of(0x13, 0, 3);
  TEST_ASSERT_EQUAL_HEX8(NO_ANSWER, ask(0x15, (uint8_t)delay_ms, (uint8_t)(delay_ms >> 8)));
  uint32_t before = 0, after = 0;
  for (uint32_t ms = 0; lss_slave_is_silent(&slave); ++ms) {
    TEST_ASSERT_TRUE(ms < 10000);
    lss_slave_tick(&slave);
    before += activated == 0 ? 1 : 0;
    after += activated != 0 && lss_slave_is_silent(&slave) ? 1 : 0;
  }
  TEST_ASSERT_EQUAL(250, activated);
  TEST_ASSERT_EQUAL(250, slave.active.kbit_s);
  TEST_ASSERT_EQUAL(delay_ms, before);
  TEST_ASSERT_EQUAL(delay_ms + 1, after);
}

static void test_the_bit_rate_stays_when_an_axis_was_enabled_meanwhile(void) {
  switch_to(CONFIGURATION);
  (void)error_of(0x13, 0, 3);
  (void)ask(0x15, 10, 0);
  torque = true;
  for (int ms = 0; ms < 20; ++ms) {
    lss_slave_tick(&slave);
  }
  TEST_ASSERT_EQUAL(0, activated);
  TEST_ASSERT_EQUAL(1000, slave.active.kbit_s);
  TEST_ASSERT_FALSE(lss_slave_is_silent(&slave));
}

static void test_an_axis_with_torque_ends_the_silence_at_once(void) {
  for (int changed = 0; changed <= 1; ++changed) {
    start(1);
    torque = false;
    switch_to(CONFIGURATION);
    (void)error_of(0x13, 0, 3);
    (void)ask(0x15, 0xFF, 0xFF); /* 65 s */
    slave.left_ms = changed ? 0 : slave.left_ms;
    lss_slave_tick(&slave);
    TEST_ASSERT_TRUE(lss_slave_is_silent(&slave));
    torque = true;
    lss_slave_tick(&slave);
    TEST_ASSERT_FALSE(lss_slave_is_silent(&slave));
    TEST_ASSERT_EQUAL(changed ? 250 : 1000, slave.active.kbit_s);
  }
}

static void test_a_device_that_cannot_change_its_bit_rate_ignores_it(void) {
  slave.callbacks.activate = NULL;
  switch_to(CONFIGURATION);
  (void)ask(0x15, 0, 0);
  TEST_ASSERT_FALSE(lss_slave_is_silent(&slave));
}

/* --- without node id
 * ------------------------------------------------------------------------------------------------- */

static void test_the_first_node_id_counts_when_the_slave_is_switched_to_waiting(void) {
  static const uint8_t to_waiting[LSS_BYTES] = {0x04, WAITING};
  start(BUS_UNCONFIGURED);
  switch_to(CONFIGURATION);
  TEST_ASSERT_FALSE(lss_slave_receive(&slave, to_waiting)); /* it has no node id */
  switch_to(CONFIGURATION);
  (void)error_of(0x11, 7, 0);
  TEST_ASSERT_TRUE(lss_slave_receive(&slave, to_waiting));
  lss_slave_take_node_id(&slave);
  TEST_ASSERT_FALSE(lss_slave_is_unconfigured(&slave));
  switch_to(CONFIGURATION);
  (void)error_of(0x11, 8, 0);
  TEST_ASSERT_FALSE(lss_slave_receive(&slave, to_waiting)); /* it has one */
}

/* --- fastscan
 * --------------------------------------------------------------------------------------------------------- */

enum { SLAVES = 6 };
static lss_slave slaves[SLAVES];

/* Whether any slave answers; each at most once. */
static bool scan_all(uint32_t number, uint8_t bit, uint8_t part, uint8_t next) {
  const uint8_t request[LSS_BYTES] = {
      0x51, (uint8_t)number, (uint8_t)(number >> 8), (uint8_t)(number >> 16), (uint8_t)(number >> 24), bit, part, next};
  bool any = false;
  for (int i = 0; i < SLAVES; ++i) {
    (void)lss_slave_receive(&slaves[i], request);
    const uint8_t *answer = lss_slave_outgoing(&slaves[i]);
    TEST_ASSERT_TRUE(answer == NULL || answer[0] == FOUND);
    any = any || answer != NULL;
    lss_slave_sent(&slaves[i]);
  }
  return any;
}

/* As a master does; false: no node is left. */
static bool scan(uint32_t found[LSS_IDENTITY_PARTS]) {
  if (!scan_all(0, 0x80, 0, 0)) {
    return false;
  }
  for (uint8_t part = 0; part < LSS_IDENTITY_PARTS; ++part) {
    found[part] = 0;
    for (int bit = 31; bit >= 0; --bit) {
      if (!scan_all(found[part], (uint8_t)bit, part, part)) {
        found[part] |= 1u << bit;
      }
    }
    TEST_ASSERT_TRUE(scan_all(found[part], 0, part, (uint8_t)((part + 1) % LSS_IDENTITY_PARTS)));
  }
  return true;
}

/* The one in the configuration state; there must be exactly one. */
static int the_configuring(void) {
  int which = -1;
  for (int i = 0; i < SLAVES; ++i) {
    if (slaves[i].configuring) {
      TEST_ASSERT_EQUAL_MESSAGE(-1, which, "two slaves are switched at once");
      which = i;
    }
  }
  TEST_ASSERT_NOT_EQUAL(-1, which);
  return which;
}

static void find_all(void) {
  const lss_callbacks none = {NULL, NULL, NULL, NULL};
  for (uint8_t n = 0; n < SLAVES; ++n) {
    uint32_t found[LSS_IDENTITY_PARTS];
    TEST_ASSERT_TRUE(scan(found));
    lss_slave *one = &slaves[the_configuring()];
    TEST_ASSERT_EQUAL_HEX32_ARRAY(one->identity, found, LSS_IDENTITY_PARTS);
    one->callbacks = none;
    (void)lss_slave_receive(one, (const uint8_t[LSS_BYTES]){0x11, (uint8_t)(n + 10)});
    lss_slave_sent(one);
    TEST_ASSERT_TRUE(lss_slave_receive(one, (const uint8_t[LSS_BYTES]){0x04, WAITING}));
    lss_slave_take_node_id(one);
  }
  uint32_t nobody[LSS_IDENTITY_PARTS];
  TEST_ASSERT_FALSE(scan(nobody));
}

static void start_slaves(random_source *random, uint32_t parts_that_differ) {
  for (int i = 0; i < SLAVES; ++i) {
    uint32_t own[LSS_IDENTITY_PARTS];
    lss_slave_init(&slaves[i], &(bus_settings){BUS_UNCONFIGURED, 1000}, &(lss_callbacks){NULL, NULL, NULL, NULL});
    for (uint32_t part = 0; part < LSS_IDENTITY_PARTS; ++part) {
      const bool differs = (parts_that_differ >> part & 1u) != 0;
      own[part] = differs ? (uint32_t)random_bits(random) : identity[part];
    }
    lss_slave_identify(&slaves[i], own);
  }
}

static void test_fastscan_finds_each_slave_once_whatever_reports_them_apart(void) {
  random_source random = {1};
  for (uint32_t parts_that_differ = 1; parts_that_differ < 16; ++parts_that_differ) {
    for (int repetition = 0; repetition < 20; ++repetition) {
      start_slaves(&random, parts_that_differ);
      find_all();
    }
  }
}

static void test_fastscan_finds_serial_numbers_that_are_neighbours_or_extreme(void) {
  static const uint32_t serials[SLAVES] = {0, 1, 2, 0x80000000, 0xFFFFFFFE, 0xFFFFFFFF};
  random_source random = {1};
  start_slaves(&random, 8);
  for (int i = 0; i < SLAVES; ++i) {
    slaves[i].identity[3] = serials[i];
  }
  find_all();
}

static void test_fastscan_leaves_slaves_with_a_node_id_or_in_configuration_and_wrong_requests_alone(void) {
  random_source random = {1};
  start_slaves(&random, 8);
  for (int i = 0; i < SLAVES; ++i) {
    slaves[i].active.node_id = (uint8_t)(i + 1);
  }
  TEST_ASSERT_FALSE(scan_all(0, 0x80, 0, 0));
  start_slaves(&random, 8);
  for (int i = 0; i < SLAVES; ++i) {
    slaves[i].configuring = true; /* the master has found them and gives them their node ids */
  }
  TEST_ASSERT_FALSE(scan_all(0, 0x80, 0, 0));
  start_slaves(&random, 8);
  TEST_ASSERT_TRUE(scan_all(0, 0x80, 0, 0));
  TEST_ASSERT_FALSE(scan_all(0, 32, 0, 0));
  TEST_ASSERT_FALSE(scan_all(0, 31, 1, 1)); /* not its turn */
  TEST_ASSERT_FALSE(scan_all(0, 31, 4, 0));
  TEST_ASSERT_FALSE(scan_all(0, 31, 0, 4));
  TEST_ASSERT_TRUE(scan_all(0, 31, 0, 0));
}

/* A master that ends early, or leaves parts out, has found nobody. */
static void test_fastscan_switches_no_slave_before_all_four_parts_matched(void) {
  static const struct {
    uint8_t parts[4];
    uint8_t count;
  } orders[] = {{{0, 1}, 2}, {{0, 1, 2}, 3}, {{0, 3}, 2}, {{0, 2, 3}, 3}};
  random_source random = {1};
  for (unsigned order = 0; order < sizeof orders / sizeof orders[0]; ++order) {
    start_slaves(&random, 8);
    TEST_ASSERT_TRUE(scan_all(0, 0x80, 0, 0));
    for (uint8_t i = 0; i < orders[order].count; ++i) {
      const uint8_t part = orders[order].parts[i];
      const bool last = i + 1 == orders[order].count;
      TEST_ASSERT_TRUE(scan_all(slaves[0].identity[part], 0, part, last ? 0 : orders[order].parts[i + 1]));
    }
    for (int i = 0; i < SLAVES; ++i) {
      TEST_ASSERT_FALSE(slaves[i].configuring);
    }
  }
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_a_waiting_slave_neither_answers_nor_changes_anything);
  RUN_TEST(test_no_other_command_is_answered_in_either_state);
  RUN_TEST(test_a_state_that_does_not_exist_is_ignored);
  RUN_TEST(test_the_four_numbers_in_order_select_this_slave_alone);
  RUN_TEST(test_numbers_out_of_order_select_nothing);
  RUN_TEST(test_it_says_who_it_is_also_with_torque);
  RUN_TEST(test_identify_answers_for_its_product_within_the_ranges);
  RUN_TEST(test_an_identification_is_answered_after_its_six_requests_in_order_only);
  RUN_TEST(test_only_a_slave_without_node_id_answers_who_looks_for_such);
  RUN_TEST(test_a_node_id_is_pending_until_the_communication_is_reset);
  RUN_TEST(test_node_ids_that_do_not_exist_are_refused);
  RUN_TEST(test_bit_rates_of_the_table_are_taken_or_refused);
  RUN_TEST(test_what_is_pending_is_stored_and_answered_when_it_is);
  RUN_TEST(test_a_store_that_fails_or_is_not_there_says_so);
  RUN_TEST(test_with_torque_nothing_is_changed);
  RUN_TEST(test_the_bit_rate_changes_between_two_times_of_silence);
  RUN_TEST(test_the_bit_rate_stays_when_an_axis_was_enabled_meanwhile);
  RUN_TEST(test_an_axis_with_torque_ends_the_silence_at_once);
  RUN_TEST(test_a_device_that_cannot_change_its_bit_rate_ignores_it);
  RUN_TEST(test_the_first_node_id_counts_when_the_slave_is_switched_to_waiting);
  RUN_TEST(test_fastscan_finds_each_slave_once_whatever_reports_them_apart);
  RUN_TEST(test_fastscan_finds_serial_numbers_that_are_neighbours_or_extreme);
  RUN_TEST(test_fastscan_switches_no_slave_before_all_four_parts_matched);
  RUN_TEST(test_fastscan_leaves_slaves_with_a_node_id_or_in_configuration_and_wrong_requests_alone);
  return UNITY_END();
}
