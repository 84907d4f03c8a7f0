/* Staged, active and previous set of an axis: what each operation changes, and what a refusal leaves as it was. */
#include "parameters/axis_tuning.h"

#include <string.h>

#include "parameters/axis_dictionary.h"
#include "servo/servo_app.h"
#include "unity.h"

static axis_tuning tuning;
static servo_axis axis;
static servo_axis_params in_force;
static axis_parameters defaults;

void setUp(void) {
  memset(&tuning, 0, sizeof tuning);
  const od_part part = {.table = axis_parameters_table, .values = &tuning};
  od_restore_defaults(&part, 1);
  defaults = tuning.staged;
  memset(&tuning, 0x5A, sizeof tuning);
  TEST_ASSERT_EQUAL(CONTROL_OK, axis_tuning_start(&tuning, &defaults, &in_force));
  servo_axis_reset(&axis, &in_force, 0, SERVO_TICK_S);
}

void tearDown(void) {}

static void expect_gains(float staged, float active) {
  TEST_ASSERT_EQUAL_FLOAT(staged, tuning.staged.speed_loop.proportional_nm_s_rad);
  TEST_ASSERT_EQUAL_FLOAT(active, tuning.active.speed_loop.proportional_nm_s_rad);
  TEST_ASSERT_EQUAL_FLOAT(active, in_force.speed.pi.proportional_gain);
  TEST_ASSERT_EQUAL_HEX32(axis_parameters_crc(&tuning.active), tuning.active_crc);
}

static control_status apply(float gain) {
  tuning.staged.speed_loop.proportional_nm_s_rad = gain;
  return axis_tuning_apply(&tuning, &axis, &in_force, SERVO_TICK_S);
}

static uint32_t flags(void) {
  axis_tuning_refresh(&tuning);
  return tuning.flags;
}

static void test_the_start_makes_one_set_staged_active_and_in_force(void) {
  expect_gains(720.0f, 720.0f);
  TEST_ASSERT_EQUAL_MEMORY(&defaults, &tuning.previous, sizeof defaults);
  TEST_ASSERT_EQUAL(CONTROL_OK, tuning.last_result);
  TEST_ASSERT_EQUAL(CONTROL_OK, tuning.refusal.status);
  TEST_ASSERT_EQUAL_HEX32(0, tuning.stored_crc);
}

static void test_a_start_with_a_wrong_set_is_refused_and_changes_nothing(void) {
  axis_parameters wrong = defaults;
  wrong.speed_loop.proportional_nm_s_rad = -1.0f;
  axis_tuning before = tuning;
  TEST_ASSERT_EQUAL(CONTROL_OUT_OF_RANGE, axis_tuning_start(&tuning, &wrong, &in_force));
  TEST_ASSERT_EQUAL_MEMORY(&before, &tuning, sizeof before);
}

static void test_an_applied_set_is_in_force_and_undo_takes_it_back_and_gives_it_again(void) {
  TEST_ASSERT_EQUAL(CONTROL_OK, apply(700.0f));
  expect_gains(700.0f, 700.0f);
  TEST_ASSERT_EQUAL(CONTROL_OK, apply(690.0f));
  expect_gains(690.0f, 690.0f);
  TEST_ASSERT_EQUAL(CONTROL_OK, axis_tuning_undo(&tuning, &axis, &in_force, SERVO_TICK_S));
  expect_gains(700.0f, 700.0f);
  TEST_ASSERT_EQUAL(CONTROL_OK, axis_tuning_undo(&tuning, &axis, &in_force, SERVO_TICK_S));
  expect_gains(690.0f, 690.0f);
}

static void test_a_refused_set_stays_staged_and_the_active_one_in_force(void) {
  TEST_ASSERT_EQUAL(CONTROL_OK, apply(700.0f));
  TEST_ASSERT_EQUAL(CONTROL_OUT_OF_RANGE, apply(2e6f));
  expect_gains(2e6f, 700.0f);
  TEST_ASSERT_EQUAL(CONTROL_OUT_OF_RANGE, tuning.last_result);
  TEST_ASSERT_EQUAL(CONTROL_OUT_OF_RANGE, tuning.refusal.status);
  TEST_ASSERT_EQUAL_HEX32(0x20000100, tuning.refusal.object);
  TEST_ASSERT_EQUAL_FLOAT(1e6f, tuning.refusal.high);
  axis_tuning_revert(&tuning);
  expect_gains(700.0f, 700.0f);
  TEST_ASSERT_EQUAL(CONTROL_OK, apply(710.0f));
  TEST_ASSERT_EQUAL(CONTROL_OK, tuning.last_result);
  TEST_ASSERT_EQUAL(CONTROL_OK, tuning.refusal.status);
}

static void test_the_flags_say_what_is_staged_and_what_is_not_stored(void) {
  TEST_ASSERT_EQUAL(AXIS_TUNING_DIRTY, flags());
  tuning.stored_crc = tuning.active_crc;
  TEST_ASSERT_EQUAL(0, flags());
  tuning.staged.speed_loop.proportional_nm_s_rad = 700.0f;
  TEST_ASSERT_EQUAL(AXIS_TUNING_STAGED, flags());
  TEST_ASSERT_EQUAL(CONTROL_OK, apply(700.0f));
  TEST_ASSERT_EQUAL(AXIS_TUNING_DIRTY, flags());
  tuning.staged.speed_loop.proportional_nm_s_rad = 690.0f;
  TEST_ASSERT_EQUAL(AXIS_TUNING_STAGED | AXIS_TUNING_DIRTY, flags());
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_the_start_makes_one_set_staged_active_and_in_force);
  RUN_TEST(test_a_start_with_a_wrong_set_is_refused_and_changes_nothing);
  RUN_TEST(test_an_applied_set_is_in_force_and_undo_takes_it_back_and_gives_it_again);
  RUN_TEST(test_a_refused_set_stays_staged_and_the_active_one_in_force);
  RUN_TEST(test_the_flags_say_what_is_staged_and_what_is_not_stored);
  return UNITY_END();
}
