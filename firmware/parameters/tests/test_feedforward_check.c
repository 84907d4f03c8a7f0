/* SPDX-License-Identifier: Apache-2.0 */
/* Feedforwards that take the motor's torque from the loop are refused, with the value's range; those of a design pass.
 */
#include "parameters/feedforward_check.h"

#include <string.h>

#include "parameters/axis_dictionary.h"
#include "parameters/axis_tuning.h"
#include "unity.h"

static axis_parameters set;

void setUp(void) {
  axis_tuning tuning;
  memset(&tuning, 0, sizeof tuning);
  const od_part part = {.table = axis_parameters_table, .values = &tuning};
  od_restore_defaults(&part, 1);
  set = tuning.staged;
  /* Half of the motor's torque: 20 Nm. */
  TEST_ASSERT_EQUAL_FLOAT(40.0f, set.motor.torque_constant_nm_a * set.motor.current_limit_a);
}

void tearDown(void) {}

static void expect_taken(void) { TEST_ASSERT_EQUAL(CONTROL_OK, feedforward_check(&set).status); }

static void expect_refused(uint32_t object, uint32_t bound_by, float low, float high) {
  const parameter_refusal refusal = feedforward_check(&set);
  TEST_ASSERT_EQUAL(CONTROL_UNSTABLE, refusal.status);
  TEST_ASSERT_EQUAL_HEX32(object, refusal.object);
  TEST_ASSERT_EQUAL_HEX32(bound_by, refusal.bound_by);
  TEST_ASSERT_EQUAL_FLOAT(low, refusal.low);
  TEST_ASSERT_EQUAL_FLOAT(high, refusal.high);
}

/* At the limit the value passes, just above it is refused with `limit` as the end of its range. */
static void expect_limit(float *value, uint32_t object, uint32_t bound_by, float low, float limit) {
  const float before = *value;
  *value = limit;
  expect_taken();
  *value = 1.001f * limit;
  expect_refused(object, bound_by, low, limit);
  *value = before;
}

static void test_the_defaults_of_the_list_pass(void) { expect_taken(); }

static void test_the_inertia_is_bound_by_that_of_the_plant(void) {
  set.plant.inertia_kg_m2 = 4.0f;
  expect_limit(&set.speed_loop.acceleration_inertia_kg_m2, PARAMETER_OBJECT(0x2000, 5), PARAMETER_OBJECT(0x2056, 1),
               0.0f, 12.0f);
}

static void test_the_friction_torques_are_bound_by_half_of_the_motor(void) {
  const uint32_t motor = PARAMETER_OBJECT(0x2055, 6);
  set.friction.positive.breakaway_nm = 20.0f;
  expect_limit(&set.friction.positive.coulomb_nm, PARAMETER_OBJECT(0x2030, 7), motor, 1e-6f, 20.0f);
  expect_limit(&set.friction.positive.breakaway_nm, PARAMETER_OBJECT(0x2030, 8), motor, 1e-6f, 20.0f);
  set.friction.negative.breakaway_nm = 20.0f;
  expect_limit(&set.friction.negative.coulomb_nm, PARAMETER_OBJECT(0x2030, 11), motor, 1e-6f, 20.0f);
  expect_limit(&set.friction.negative.breakaway_nm, PARAMETER_OBJECT(0x2030, 12), motor, 1e-6f, 20.0f);
}

static void test_a_smaller_gain_of_the_feedforward_permits_larger_torques(void) {
  set.friction.gain = 0.5f;
  expect_limit(&set.friction.positive.breakaway_nm, PARAMETER_OBJECT(0x2030, 8), PARAMETER_OBJECT(0x2055, 6), 1e-6f,
               40.0f);
}

static void test_coefficients_per_rate_are_bound_by_those_of_the_plant(void) {
  set.plant.viscous_nm_s_rad = 10.0f;
  set.plant.damping_nm_s_rad = 200.0f;
  const uint32_t viscous = PARAMETER_OBJECT(0x2056, 3);
  expect_limit(&set.friction.positive.viscous_nm_s_rad, PARAMETER_OBJECT(0x2030, 10), viscous, 0.0f, 30.0f);
  expect_limit(&set.friction.negative.viscous_nm_s_rad, PARAMETER_OBJECT(0x2030, 14), viscous, 0.0f, 30.0f);
  expect_limit(&set.friction.damping_nm_s_rad, PARAMETER_OBJECT(0x2030, 6), PARAMETER_OBJECT(0x2056, 5), 0.0f, 600.0f);
}

static void test_without_friction_of_the_plant_half_of_the_motor_at_1_rad_s_is_permitted(void) {
  set.plant.viscous_nm_s_rad = 0.0f;
  set.plant.damping_nm_s_rad = 0.0f;
  set.friction.damping_nm_s_rad = 0.0f;
  const uint32_t motor = PARAMETER_OBJECT(0x2055, 6);
  expect_limit(&set.friction.positive.viscous_nm_s_rad, PARAMETER_OBJECT(0x2030, 10), motor, 0.0f, 20.0f);
  expect_limit(&set.friction.damping_nm_s_rad, PARAMETER_OBJECT(0x2030, 6), motor, 0.0f, 20.0f);
}

static void test_a_model_that_is_off_or_has_no_bristles_is_not_judged(void) {
  set.friction.damping_nm_s_rad = 1e6f;
  expect_refused(PARAMETER_OBJECT(0x2030, 6), PARAMETER_OBJECT(0x2056, 5), 0.0f, 900.0f);
  set.friction.model = (uint32_t)FRICTION_STEADY;
  expect_taken();
  set.friction.positive.breakaway_nm = 1e4f;
  expect_refused(PARAMETER_OBJECT(0x2030, 8), PARAMETER_OBJECT(0x2055, 6), 1e-6f, 20.0f);
  set.friction.gain = 0.0f;
  expect_taken();
  set.friction.gain = 1.0f;
  set.friction.model = (uint32_t)FRICTION_NONE;
  expect_taken();
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_the_defaults_of_the_list_pass);
  RUN_TEST(test_the_inertia_is_bound_by_that_of_the_plant);
  RUN_TEST(test_the_friction_torques_are_bound_by_half_of_the_motor);
  RUN_TEST(test_a_smaller_gain_of_the_feedforward_permits_larger_torques);
  RUN_TEST(test_coefficients_per_rate_are_bound_by_those_of_the_plant);
  RUN_TEST(test_without_friction_of_the_plant_half_of_the_motor_at_1_rad_s_is_permitted);
  RUN_TEST(test_a_model_that_is_off_or_has_no_bristles_is_not_judged);
  return UNITY_END();
}
