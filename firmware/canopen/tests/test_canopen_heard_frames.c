/* SPDX-License-Identifier: Apache-2.0 */
/* The heard frames, and that they include each identifier that an object accepts. */
#include "canopen/bench.h"
#include "canopen/cob_id.h"
#include "canopen/heard_frames.h"

void setUp(void) { bench_start(); }
void tearDown(void) {}

enum { SYNC = 0x1005, RPDO_1 = 0x1400, BAD_VALUE = 0x06090030, INCOMPATIBLE = 0x06040043 };

/* CiA 301, table 40, written a second time. */
static bool is_restricted(uint32_t id) {
  return id <= 0x07F || (id >= 0x101 && id <= 0x180) || (id >= 0x581 && id <= 0x5FF) || (id >= 0x601 && id <= 0x67F) ||
         (id >= 0x6E0 && id <= 0x6FF) || id >= 0x701;
}

static bool is_heard(uint32_t id) { return heard_frame(&(can_frame){.id = id}); }

static void test_the_ranges_rise_and_do_not_overlap(void) {
  for (uint32_t i = 0; i < HEARD_RANGES; i++) {
    TEST_ASSERT_TRUE(heard_ranges[i].first <= heard_ranges[i].last && heard_ranges[i].last <= 0x7FF);
    TEST_ASSERT_TRUE(i == 0 || heard_ranges[i].first > heard_ranges[i - 1].last);
  }
}

static void test_every_identifier_that_is_not_restricted_is_heard_and_free(void) {
  for (uint32_t id = 0; id <= 0x7FF; id++) {
    TEST_ASSERT_EQUAL(!is_restricted(id), heard_identifier_is_free(id));
    TEST_ASSERT_EQUAL(!is_restricted(id), cob_id_is_allowed(id));
    TEST_ASSERT_TRUE(is_restricted(id) || is_heard(id));
  }
  TEST_ASSERT_FALSE(cob_id_is_allowed(COB_ID_EXTENDED | 0x200));
  TEST_ASSERT_FALSE(cob_id_is_allowed(0x1000 | 0x200));
}

static void test_services_are_heard_and_what_nobody_listens_to_is_not(void) {
  const uint32_t services[] = {0x000, 0x601, 0x67F, 0x701, 0x77F, HEARD_LSS_REQUEST};
  for (uint32_t i = 0; i < sizeof services / sizeof services[0]; i++) {
    TEST_ASSERT_TRUE(is_heard(services[i]));
    TEST_ASSERT_FALSE(heard_identifier_is_free(services[i]));
  }
  const uint32_t others[] = {0x001, 0x07F, 0x101, 0x180, 0x581, 0x5FF, 0x6E0, 0x6FF, 0x780, 0x7E4, 0x7E6, 0x7FF};
  for (uint32_t i = 0; i < sizeof others / sizeof others[0]; i++) {
    TEST_ASSERT_FALSE(is_heard(others[i]));
  }
  TEST_ASSERT_FALSE(heard_frame(&(can_frame){.id = 0x200, .flags = CAN_FRAME_EXTENDED}));
  TEST_ASSERT_FALSE(heard_frame(&(can_frame){.id = 0x200, .flags = CAN_FRAME_REMOTE}));
}

/* Passes a frame like the bus: through the table. */
static void give_if_heard(uint32_t id, uint8_t length, const uint8_t *bytes) {
  if (is_heard(id)) {
    bench_give(id, length, bytes);
  }
}

/* Whether EMCY, SYNC or a PDO that is on uses this identifier. */
static bool is_in_use(uint32_t id) {
  const communication_objects *objects = &bench.device.node.objects;
  bool used = objects->sync.cob_id == id || objects->emergency.cob_id == id;
  for (int i = 0; i < RPDO_COUNT; i++) {
    used = used || (objects->rpdo[i].cob_id & ~(uint32_t)COB_ID_NO_REMOTE) == id;
  }
  for (int i = 0; i < TPDO_COUNT; i++) {
    used = used || (objects->tpdo[i].cob_id & ~(uint32_t)COB_ID_NO_REMOTE) == id;
  }
  return used;
}

static void test_an_rpdo_is_obeyed_at_each_identifier_that_it_takes(void) {
  for (uint32_t id = 0; id <= 0x7FF; id++) {
    TEST_ASSERT_EQUAL_HEX32(0, bench_write(RPDO_1, 1, COB_ID_INVALID, 4));
    if (is_in_use(id)) {
      TEST_ASSERT_EQUAL_HEX32(INCOMPATIBLE, bench_write(RPDO_1, 1, id, 4));
      continue;
    }
    TEST_ASSERT_EQUAL_HEX32(is_restricted(id) ? BAD_VALUE : 0, bench_write(RPDO_1, 1, id, 4));
    if (!is_restricted(id)) {
      bench_operational();
      const uint8_t controlword[3] = {(uint8_t)id, (uint8_t)(id >> 8), 0};
      give_if_heard(id, sizeof controlword, controlword);
      bench_wait_ms(1);
      TEST_ASSERT_EQUAL_HEX16(id, bench.device.axis[0].controlword);
    }
  }
}

static void test_a_sync_is_obeyed_at_each_identifier_that_it_takes(void) {
  const uint8_t none[1] = {0};
  TEST_ASSERT_EQUAL_HEX32(0, bench_write(RPDO_1, 1, COB_ID_INVALID, 4));
  for (uint32_t id = 0; id <= 0x7FF; id++) {
    if (id != (bench.device.node.objects.sync.cob_id & 0x7FF) && is_in_use(id)) {
      TEST_ASSERT_EQUAL_HEX32(INCOMPATIBLE, bench_write(SYNC, 0, id, 4));
      continue;
    }
    TEST_ASSERT_EQUAL_HEX32(is_restricted(id) ? BAD_VALUE : 0, bench_write(SYNC, 0, id, 4));
    if (!is_restricted(id)) {
      bench.device.node.sync.heard = false;
      give_if_heard(id, 0, none);
      bench_wait_ms(1);
      TEST_ASSERT_TRUE(bench.device.node.sync.heard);
    }
  }
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_the_ranges_rise_and_do_not_overlap);
  RUN_TEST(test_every_identifier_that_is_not_restricted_is_heard_and_free);
  RUN_TEST(test_services_are_heard_and_what_nobody_listens_to_is_not);
  RUN_TEST(test_an_rpdo_is_obeyed_at_each_identifier_that_it_takes);
  RUN_TEST(test_a_sync_is_obeyed_at_each_identifier_that_it_takes);
  return UNITY_END();
}
