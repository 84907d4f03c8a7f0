/* SPDX-License-Identifier: Apache-2.0 */
/* The two halves of the fault table: each fault has a row in both, and each row says everything an operator needs. */
#include "protection/fault_texts.h"

#include <stdio.h>

#include "unity.h"

void setUp(void) {}
void tearDown(void) {}

static void test_every_fault_has_a_code_and_a_latency(void) {
  for (int i = 1; i < FAULT_COUNT; ++i) {
    char fault[32];
    (void)snprintf(fault, sizeof fault, "fault %d", i);
    TEST_ASSERT_NOT_EQUAL_MESSAGE(0, fault_table[i].code, fault);
    TEST_ASSERT_NOT_EQUAL_MESSAGE(0, fault_table[i].latency_ms, fault);
  }
}

static void test_every_fault_has_all_its_texts(void) {
  for (int i = 1; i < FAULT_COUNT; ++i) {
    const fault_text *text = fault_text_of((fault_id)i);
    const char *const texts[] = {text->name,  text->detection, text->when, text->cause,
                                 text->check, text->cure,      text->clear};
    for (unsigned k = 0; k < sizeof texts / sizeof texts[0]; ++k) {
      char place[32];
      (void)snprintf(place, sizeof place, "fault %d, text %u", i, k);
      TEST_ASSERT_NOT_NULL_MESSAGE(texts[k], place);
      TEST_ASSERT_NOT_EQUAL_MESSAGE('\0', texts[k][0], place);
    }
    TEST_ASSERT_NOT_NULL(text->timer);
  }
}

/* What a restart or a change that is over has left behind cannot last: it is reported, and needs no reset. */
static void test_events_are_reported_once_and_conditions_as_long_as_they_last(void) {
  static const fault_id events[] = {FAULT_WATCHDOG_RESET,  FAULT_EXCEPTION_RESET, FAULT_BROWN_OUT_RESET,
                                    FAULT_STACK_OVERFLOW,  FAULT_RAM_PARITY,      FAULT_OPTION_BYTES,
                                    FAULT_GAINS_TAKEN_BACK};
  for (unsigned i = 0; i < sizeof events / sizeof events[0]; ++i) {
    TEST_ASSERT_TRUE_MESSAGE(fault_text_of(events[i])->reported_once, fault_text_of(events[i])->name);
  }
  static const fault_id conditions[] = {FAULT_ENCODER_LOST, FAULT_OVER_CURRENT, FAULT_UNDER_VOLTAGE,
                                        FAULT_IMAGE_DAMAGED};
  for (unsigned i = 0; i < sizeof conditions / sizeof conditions[0]; ++i) {
    TEST_ASSERT_FALSE_MESSAGE(fault_text_of(conditions[i])->reported_once, fault_text_of(conditions[i])->name);
  }
}

static void test_an_axis_without_a_fault_has_a_name_for_it_too(void) {
  TEST_ASSERT_EQUAL_STRING("no fault", fault_text_of(FAULT_NONE)->name);
  TEST_ASSERT_EQUAL_HEX16(0, fault_table[FAULT_NONE].code);
}

static void test_every_column_of_the_fault_log_has_a_name_and_a_unit(void) {
  for (int i = 0; i < FAULT_LOG_SIGNALS; ++i) {
    TEST_ASSERT_NOT_NULL(fault_signals[i].name);
    TEST_ASSERT_NOT_NULL(fault_signals[i].unit);
  }
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_every_fault_has_a_code_and_a_latency);
  RUN_TEST(test_every_fault_has_all_its_texts);
  RUN_TEST(test_events_are_reported_once_and_conditions_as_long_as_they_last);
  RUN_TEST(test_an_axis_without_a_fault_has_a_name_for_it_too);
  RUN_TEST(test_every_column_of_the_fault_log_has_a_name_and_a_unit);
  return UNITY_END();
}
