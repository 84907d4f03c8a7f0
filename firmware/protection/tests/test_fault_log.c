/* SPDX-License-Identifier: Apache-2.0 */
/* The log of faults, its edges: the board's entries, and the memory beside the log. */
#include "protection/fault_log.h"

#include <string.h>

#include "unity.h"

void setUp(void) {}
void tearDown(void) {}

/* What lies behind the log in memory looks like the history of a third axis. */
typedef struct {
  fault_log log;
  fault_log_history behind;
} surrounded_log;

static surrounded_log new_log(void) {
  surrounded_log s;
  memset(&s, 0, sizeof s);
  s.behind.count = 7;
  s.behind.next = 7;
  return s;
}

static void test_a_fault_of_the_board_has_no_samples_whatever_the_axes_did(void) {
  surrounded_log s = new_log();
  for (int axis = 0; axis < SERVO_AXES; ++axis) {
    for (int tick = 0; tick < 40; ++tick) {
      fault_log_sample_tick(&s.log, axis, &(fault_log_sample){.current_a = 1.0f});
    }
  }
  fault_log_write(&s.log, FAULT_LOG_BOARD, FAULT_TICK_LATE, 41);
  const fault_log_entry *entry = fault_log_find(&s.log, 0);
  TEST_ASSERT_EQUAL(FAULT_TICK_LATE, entry->fault);
  TEST_ASSERT_EQUAL(FAULT_LOG_BOARD, entry->source);
  TEST_ASSERT_EQUAL(41, entry->tick);
  TEST_ASSERT_EQUAL(0, entry->samples);
}

static void test_each_axis_has_its_own_samples_up_to_the_tick_of_the_fault(void) {
  surrounded_log s = new_log();
  for (uint32_t tick = 1; tick <= 3; ++tick) {
    fault_log_sample_tick(&s.log, 0, &(fault_log_sample){.current_a = (float)tick});
    fault_log_sample_tick(&s.log, 1, &(fault_log_sample){.current_a = -(float)tick});
    fault_log_write(&s.log, 0, FAULT_STALL, tick);
    fault_log_write(&s.log, 1, FAULT_RUNAWAY, tick);
  }
  const fault_log_entry *pitch = fault_log_find(&s.log, 0);
  const fault_log_entry *azimuth = fault_log_find(&s.log, 1);
  TEST_ASSERT_EQUAL(1, pitch->source);
  TEST_ASSERT_EQUAL(0, azimuth->source);
  TEST_ASSERT_EQUAL(3, azimuth->samples);
  for (int i = 0; i < 3; ++i) {
    TEST_ASSERT_EQUAL_FLOAT((float)(i + 1), azimuth->before[i].current_a);
    TEST_ASSERT_EQUAL_FLOAT(-(float)(i + 1), pitch->before[i].current_a);
  }
}

static void test_a_full_log_keeps_eight_faults_and_writes_nowhere_else(void) {
  surrounded_log s = new_log();
  const fault_log_history before = s.behind;
  for (uint32_t tick = 1; tick <= 100; ++tick) {
    fault_log_sample_tick(&s.log, 1, &(fault_log_sample){.current_a = (float)tick});
    fault_log_write(&s.log, 1, FAULT_STALL, tick);
    TEST_ASSERT_EQUAL(tick, fault_log_find(&s.log, 0)->tick);
  }
  for (uint32_t age = 0; age < FAULT_LOG_ENTRIES; ++age) {
    TEST_ASSERT_EQUAL(100 - age, fault_log_find(&s.log, age)->tick);
  }
  TEST_ASSERT_NULL(fault_log_find(&s.log, FAULT_LOG_ENTRIES));
  TEST_ASSERT_EQUAL_MEMORY(&before, &s.behind, sizeof before);
  TEST_ASSERT_EQUAL(0, s.log.history[0].count); /* the other axis */
}

static void test_a_cleared_log_is_empty_and_keeps_the_samples(void) {
  surrounded_log s = new_log();
  fault_log_sample_tick(&s.log, 0, &(fault_log_sample){.current_a = 5.0f});
  fault_log_write(&s.log, 0, FAULT_STALL, 1);
  fault_log_clear(&s.log);
  TEST_ASSERT_NULL(fault_log_find(&s.log, 0));
  fault_log_write(&s.log, 0, FAULT_STALL, 2);
  TEST_ASSERT_NULL(fault_log_find(&s.log, 1));
  TEST_ASSERT_EQUAL(1, fault_log_find(&s.log, 0)->samples);
  TEST_ASSERT_EQUAL_FLOAT(5.0f, fault_log_find(&s.log, 0)->before[0].current_a);
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_a_fault_of_the_board_has_no_samples_whatever_the_axes_did);
  RUN_TEST(test_each_axis_has_its_own_samples_up_to_the_tick_of_the_fault);
  RUN_TEST(test_a_full_log_keeps_eight_faults_and_writes_nowhere_else);
  RUN_TEST(test_a_cleared_log_is_empty_and_keeps_the_samples);
  return UNITY_END();
}
