/* SPDX-License-Identifier: Apache-2.0 */
/* Reports of the faults of one axis, tick by tick. */
#include "node/fault_reports.h"
#include "unity.h"

static fault_reports reports;

void setUp(void) { reports = (fault_reports){0}; }
void tearDown(void) {}

#define EXPECT(over_, reported_, item_)                \
  do {                                                 \
    const fault_reports_item item = (item_);           \
    TEST_ASSERT_EQUAL_INT((over_), item.over);         \
    TEST_ASSERT_EQUAL_INT((reported_), item.reported); \
  } while (0)

static const fault_set LOST = UINT64_C(1) << FAULT_ENCODER_LOST;
static const fault_set JUMP = UINT64_C(1) << FAULT_ENCODER_JUMP;
static const fault_set HOT = UINT64_C(1) << FAULT_OVER_TEMPERATURE;
static const fault_set STAGE = UINT64_C(1) << FAULT_POWER_STAGE;

static void test_a_fault_is_reported_when_the_axis_falls_into_it_and_over_when_it_is_reset(void) {
  EXPECT(FAULT_NONE, FAULT_NONE, fault_reports_step(&reports, FAULT_NONE, 0));
  EXPECT(FAULT_NONE, FAULT_ENCODER_LOST, fault_reports_step(&reports, FAULT_ENCODER_LOST, LOST));
  EXPECT(FAULT_NONE, FAULT_NONE, fault_reports_step(&reports, FAULT_ENCODER_LOST, LOST));
  EXPECT(FAULT_NONE, FAULT_NONE, fault_reports_step(&reports, FAULT_ENCODER_LOST, 0)); /* the axis is still in it */
  EXPECT(FAULT_ENCODER_LOST, FAULT_NONE, fault_reports_step(&reports, FAULT_NONE, 0));
  EXPECT(FAULT_NONE, FAULT_NONE, fault_reports_step(&reports, FAULT_NONE, 0));
  EXPECT(FAULT_NONE, FAULT_ENCODER_LOST, fault_reports_step(&reports, FAULT_ENCODER_LOST, LOST)); /* another time */
}

static void test_a_fault_that_comes_while_another_is_latched_is_reported_once_and_over_when_it_is_gone(void) {
  (void)fault_reports_step(&reports, FAULT_ENCODER_LOST, LOST);
  EXPECT(FAULT_NONE, FAULT_OVER_TEMPERATURE, fault_reports_step(&reports, FAULT_ENCODER_LOST, LOST | HOT));
  EXPECT(FAULT_NONE, FAULT_NONE, fault_reports_step(&reports, FAULT_ENCODER_LOST, LOST | HOT));
  EXPECT(FAULT_OVER_TEMPERATURE, FAULT_NONE, fault_reports_step(&reports, FAULT_ENCODER_LOST, LOST));
  EXPECT(FAULT_NONE, FAULT_NONE, fault_reports_step(&reports, FAULT_ENCODER_LOST, HOT)); /* comes and goes */
}

static void test_of_several_the_one_that_the_axis_is_in_comes_first_then_one_a_tick_the_worst_first(void) {
  EXPECT(FAULT_NONE, FAULT_ENCODER_LOST, fault_reports_step(&reports, FAULT_ENCODER_LOST, LOST | HOT | STAGE));
  EXPECT(FAULT_NONE, FAULT_POWER_STAGE,
         fault_reports_step(&reports, FAULT_ENCODER_LOST, LOST)); /* gone, but reported */
  EXPECT(FAULT_POWER_STAGE, FAULT_OVER_TEMPERATURE, fault_reports_step(&reports, FAULT_ENCODER_LOST, LOST));
  EXPECT(FAULT_OVER_TEMPERATURE, FAULT_NONE, fault_reports_step(&reports, FAULT_ENCODER_LOST, LOST));
}

static void test_faults_of_one_code_are_over_together(void) {
  (void)fault_reports_step(&reports, FAULT_ENCODER_LOST, LOST);
  EXPECT(FAULT_NONE, FAULT_ENCODER_JUMP, fault_reports_step(&reports, FAULT_ENCODER_LOST, JUMP));
  EXPECT(FAULT_NONE, FAULT_NONE, fault_reports_step(&reports, FAULT_ENCODER_LOST, 0)); /* 7320 goes on */
  EXPECT(FAULT_ENCODER_LOST, FAULT_NONE, fault_reports_step(&reports, FAULT_NONE, 0));
}

static void test_a_healthy_axis_reports_nothing_of_what_does_not_make_it_fail(void) {
  EXPECT(FAULT_NONE, FAULT_NONE, fault_reports_step(&reports, FAULT_NONE, HOT));
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_a_fault_is_reported_when_the_axis_falls_into_it_and_over_when_it_is_reset);
  RUN_TEST(test_a_fault_that_comes_while_another_is_latched_is_reported_once_and_over_when_it_is_gone);
  RUN_TEST(test_of_several_the_one_that_the_axis_is_in_comes_first_then_one_a_tick_the_worst_first);
  RUN_TEST(test_faults_of_one_code_are_over_together);
  RUN_TEST(test_a_healthy_axis_reports_nothing_of_what_does_not_make_it_fail);
  return UNITY_END();
}
