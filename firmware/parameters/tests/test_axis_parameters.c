/* SPDX-License-Identifier: Apache-2.0 */
/* The list of parameters: what it says is what the blocks take, and a set that is refused names the value that is wrong
 * and what would be right. */
#include <math.h>
#include <stddef.h>
#include <stdio.h>
#include <string.h>

#include "base/scalar.h"
#include "parameters/axis_dictionary.h"
#include "parameters/axis_parameters.h"
#include "parameters/axis_tuning.h"
#include "servo/servo_app.h"
#include "support/random.h"
#include "unity.h"

static axis_parameters defaults;
static servo_axis_params built;

void setUp(void) {
  axis_tuning tuning;
  const od_part part = {.table = axis_parameters_table, .values = &tuning};
  od_restore_defaults(&part, 1);
  defaults = tuning.staged;
}

void tearDown(void) {}

/* --- rows of the list --- */

typedef struct {
  uint32_t object;
  const char *name;
  size_t offset; /* in axis_parameters */
  bool real;
  float low;
  float high;
} row;

#define NOTHING(...)
#define REAL_ROW(index_, sub_, flags_, group_, member_, low_, high_, ...) \
  {PARAMETER_OBJECT(index_, sub_), #group_ "." #member_, offsetof(axis_parameters, group_.member_), true, low_, high_},
#define WHOLE_ROW(index_, sub_, flags_, group_, member_, low_, high_, ...) \
  {PARAMETER_OBJECT(index_, sub_), #group_ "." #member_, offsetof(axis_parameters, group_.member_), false, low_, high_},
#define DIRECTION_ROW(sub_, side_, title_) FRICTION_DIRECTION_ROWS(REAL_ROW, sub_, side_, title_)

static const row rows[] = {AXIS_PARAMETERS(NOTHING, REAL_ROW, REAL_ROW, WHOLE_ROW, DIRECTION_ROW, NOTHING)};

enum { ROWS = sizeof rows / sizeof rows[0] };

static void set(axis_parameters *p, const row *r, float value) {
  const uint32_t whole = r->real ? 0 : (uint32_t)value;
  memcpy((char *)p + r->offset, r->real ? (const void *)&value : &whole, sizeof value);
}

static const row *row_at(uint32_t object) {
  for (int i = 0; i < ROWS; ++i) {
    if (rows[i].object == object) {
      return &rows[i];
    }
  }
  return NULL;
}

static parameter_refusal check_with(const row *r, float value) {
  axis_parameters p = defaults;
  set(&p, r, value);
  return axis_parameters_check(&p);
}

/* --- tests --- */

static void test_the_defaults_of_the_list_are_taken(void) {
  TEST_ASSERT_EQUAL(CONTROL_OK, axis_parameters_build(&defaults, &built));
  const parameter_refusal refusal = axis_parameters_check(&defaults);
  TEST_ASSERT_EQUAL(CONTROL_OK, refusal.status);
  TEST_ASSERT_EQUAL_HEX32(0, refusal.object);
}

static void test_the_struct_is_what_the_rows_list_and_nothing_else(void) {
  TEST_ASSERT_EQUAL_UINT(sizeof(axis_parameters), ROWS * sizeof(float));
  for (int i = 0; i < ROWS; ++i) {
    TEST_ASSERT_EQUAL_UINT_MESSAGE((size_t)i * sizeof(float), rows[i].offset, rows[i].name);
  }
}

static void test_every_copied_value_reaches_its_block(void) {
  axis_parameters p = defaults;
  float step = 0.0f;
#define CHANGE_REAL(index_, sub_, flags_, group_, member_, low_, high_, ...) p.group_.member_ *= 1.0f + (step += 1e-3f);
#define CHANGE_DIRECTION(sub_, side_, title_) FRICTION_DIRECTION_ROWS(CHANGE_REAL, sub_, side_, title_)
#define EXPECT_REAL(index_, sub_, flags_, group_, member_, low_, high_, default_, unit_, name_, help_, to_) \
  TEST_ASSERT_EQUAL_FLOAT_MESSAGE(p.group_.member_, built.to_, #group_ "." #member_);
#define EXPECT_WHOLE(index_, sub_, flags_, group_, member_, low_, high_, default_, name_, help_, to_, type_) \
  TEST_ASSERT_EQUAL_UINT32_MESSAGE(p.group_.member_, (uint32_t)built.to_, #group_ "." #member_);
#define EXPECT_DIRECTION(sub_, side_, title_) FRICTION_DIRECTION_ROWS(EXPECT_REAL, sub_, side_, title_)
  AXIS_PARAMETERS(NOTHING, CHANGE_REAL, NOTHING, NOTHING, CHANGE_DIRECTION, NOTHING)
  p.speed_loop.setpoint_weight = 0.6f;
  p.speed_loop.tracking_rate_per_s = 50.0f; /* below the bound by the gains */
  p.sensors.window_ticks = 5;
  TEST_ASSERT_EQUAL(CONTROL_OK, axis_parameters_build(&p, &built));
  AXIS_PARAMETERS(NOTHING, EXPECT_REAL, NOTHING, EXPECT_WHOLE, EXPECT_DIRECTION, NOTHING)
  TEST_ASSERT_EQUAL_FLOAT(p.position_loop.rate_limit_rad_s, built.tracker.rate_limit_rad_s);
}

/* Alone at an end of its range, a value is taken, or another value sets a narrower limit and is named. */
static void expect_anti_windup(float kp, float ki, float wanted_per_s, float built_per_s) {
  axis_parameters p = defaults;
  p.speed_loop.proportional_nm_s_rad = kp;
  p.speed_loop.integral_nm_rad = ki;
  p.speed_loop.tracking_rate_per_s = wanted_per_s;
  TEST_ASSERT_EQUAL(CONTROL_OK, axis_parameters_build(&p, &built));
  TEST_ASSERT_EQUAL_FLOAT(built_per_s, built.speed.pi.tracking_rate_per_s);
}

/* What a limit leaves in the integral must not outlast it for long. */
static void test_anti_windup_is_at_most_twice_as_fast_as_the_integral(void) {
  expect_anti_windup(100.0f, 1000.0f, 15.0f, 15.0f);
  expect_anti_windup(100.0f, 1000.0f, 20.0f, 20.0f);
  expect_anti_windup(100.0f, 1000.0f, 500.0f, 20.0f);
  expect_anti_windup(100.0f, 0.0f, 500.0f, 0.0f);
  expect_anti_windup(0.0f, 1000.0f, 500.0f, 500.0f);
  expect_anti_windup(0.0f, 0.0f, 500.0f, 0.0f);
}

static void test_every_value_may_be_at_the_ends_of_its_range_unless_another_one_is_named(void) {
  for (int i = 0; i < ROWS; ++i) {
    for (int end = 0; end < 2; ++end) {
      const float value = end == 0 ? rows[i].low : rows[i].high;
      const parameter_refusal refusal = check_with(&rows[i], value);
      const bool taken = refusal.status == CONTROL_OK;
      TEST_ASSERT_TRUE_MESSAGE(taken || refusal.bound_by != 0, rows[i].name);
      TEST_ASSERT_TRUE_MESSAGE(taken || refusal.object == rows[i].object || refusal.bound_by == rows[i].object,
                               rows[i].name);
    }
  }
}

static void expect_own_range(const row *r, float value, control_status status) {
  const parameter_refusal refusal = check_with(r, value);
  TEST_ASSERT_EQUAL_MESSAGE(status, refusal.status, r->name);
  TEST_ASSERT_EQUAL_HEX32_MESSAGE(r->object, refusal.object, r->name);
  TEST_ASSERT_EQUAL_HEX32_MESSAGE(0, refusal.bound_by, r->name);
  TEST_ASSERT_EQUAL_FLOAT_MESSAGE(r->low, refusal.low, r->name);
  TEST_ASSERT_EQUAL_FLOAT_MESSAGE(r->high, refusal.high, r->name);
}

static float below(float value) { return value == 0.0f ? -1e-6f : nextafterf(value, -INFINITY); }

static void test_a_value_beyond_its_range_is_named_with_its_range(void) {
  for (int i = 0; i < ROWS; ++i) {
    const row *r = &rows[i];
    expect_own_range(r, r->real ? nextafterf(r->high, INFINITY) : r->high + 1.0f, CONTROL_OUT_OF_RANGE);
    if (r->real) {
      expect_own_range(r, below(r->low), CONTROL_OUT_OF_RANGE);
      expect_own_range(r, NAN, CONTROL_NOT_FINITE);
      expect_own_range(r, INFINITY, CONTROL_NOT_FINITE);
    }
  }
}

/* The blocks' own checks have no other ranges than the list. The design of the current loop judges the resistance. */
static void expect_the_block_refuses(float *value, float wrong, const char *name) {
  current_loop_params current;
  if (value == &built.resistance_ohm) {
    TEST_ASSERT_NOT_EQUAL_MESSAGE(CONTROL_OK, current_loop_design(&current, wrong, 3e-3f, 2.5f, 6283.0f, 5e-5f), name);
    return;
  }
  const float right = *value;
  *value = wrong;
  TEST_ASSERT_NOT_EQUAL_MESSAGE(CONTROL_OK, servo_axis_check(&built, SERVO_TICK_S, SERVO_PWM_PERIOD_S), name);
  *value = right;
}

static void test_the_blocks_refuse_what_the_list_refuses(void) {
  TEST_ASSERT_EQUAL(CONTROL_OK, axis_parameters_build(&defaults, &built));
#define BLOCK_REFUSES(index_, sub_, flags_, group_, member_, low_, high_, default_, unit_, name_, help_, to_) \
  expect_the_block_refuses(&built.to_, (high_)*1.0001f, #to_);                                                \
  expect_the_block_refuses(&built.to_, (low_) == 0.0f ? -1e-6f : (low_)-1e-3f * fabsf(low_), #to_);
#define BLOCK_REFUSES_DIRECTION(sub_, side_, title_) FRICTION_DIRECTION_ROWS(BLOCK_REFUSES, sub_, side_, title_)
  AXIS_PARAMETERS(NOTHING, BLOCK_REFUSES, NOTHING, NOTHING, BLOCK_REFUSES_DIRECTION, NOTHING)
}

static void expect(const axis_parameters *p, uint32_t object, uint32_t bound_by, float low, float high) {
  const parameter_refusal refusal = axis_parameters_check(p);
  TEST_ASSERT_NOT_EQUAL(CONTROL_OK, refusal.status);
  TEST_ASSERT_EQUAL_HEX32(object, refusal.object);
  TEST_ASSERT_EQUAL_HEX32(bound_by, refusal.bound_by);
  TEST_ASSERT_EQUAL_FLOAT(low, refusal.low);
  TEST_ASSERT_EQUAL_FLOAT(high, refusal.high);
}

static void test_breakaway_below_coulomb_torque_is_named_with_the_coulomb_torque(void) {
  axis_parameters p = defaults;
  p.friction.positive.breakaway_nm = 5.0f;
  expect(&p, PARAMETER_OBJECT(0x2030, 8), PARAMETER_OBJECT(0x2030, 7), 6.0f, 1e4f);
  p = defaults;
  p.friction.negative.coulomb_nm = 20.0f;
  expect(&p, PARAMETER_OBJECT(0x2030, 12), PARAMETER_OBJECT(0x2030, 11), 20.0f, 1e4f);
}

static void test_bristles_too_soft_for_the_breakaway_torque_are_named(void) {
  axis_parameters p = defaults;
  p.friction.stiffness_nm_rad = 8.0f;
  expect(&p, PARAMETER_OBJECT(0x2030, 5), PARAMETER_OBJECT(0x2030, 8), 9.0f, 1e9f);
  p.friction.stiffness_nm_rad = 9.0f; /* they are bent by 1 rad */
  TEST_ASSERT_EQUAL(CONTROL_OK, axis_parameters_check(&p).status);
}

static void test_a_setpoint_model_is_off_or_fast(void) {
  axis_parameters p = defaults;
  p.speed_loop.setpoint_model_rad_s = 99.0f;
  expect(&p, PARAMETER_OBJECT(0x2000, 6), 0, 100.0f, 1000.0f);
  p.speed_loop.setpoint_model_rad_s = 100.0f;
  TEST_ASSERT_EQUAL(CONTROL_OK, axis_parameters_check(&p).status);
}

static void test_filters_that_cannot_be_designed_name_frequency_or_width(void) {
  axis_parameters p = defaults;
  p.filters.notch_hz = 0.5f;
  expect(&p, PARAMETER_OBJECT(0x2040, 1), 0, 1.0f, 490.0f);
  p.filters.notch_hz = 20.0f;
  p.filters.notch_width_hz = 50.0f;
  expect(&p, PARAMETER_OBJECT(0x2040, 2), PARAMETER_OBJECT(0x2040, 1), 0.02f, 40.0f);
  p.filters.notch_hz = 480.0f;
  p.filters.notch_width_hz = 600.0f;
  expect(&p, PARAMETER_OBJECT(0x2040, 2), PARAMETER_OBJECT(0x2040, 1), 0.48f, 445.633835f);
  p = defaults;
  p.filters.lowpass_hz = 0.9f;
  expect(&p, PARAMETER_OBJECT(0x2040, 4), 0, 1.0f, 490.0f);
  p.filters.lowpass_hz = 1.0f;
  p.filters.notch_hz = 490.0f;
  TEST_ASSERT_EQUAL(CONTROL_OK, axis_parameters_check(&p).status);
}

/* Ends of ranges, and each decade between them. */
static float draw(random_source *source, const row *r) {
  if (!r->real) {
    return (float)floor(random_uniform(source, (double)r->low, (double)r->high + 0.999));
  }
  if (random_uniform(source, 0.0, 1.0) < 0.1) {
    return random_uniform(source, 0.0, 1.0) < 0.5 ? r->low : r->high;
  }
  const double low = r->low > 0.0f ? (double)r->low : 1e-6 * (double)r->high;
  return scalar_clamp((float)random_decades(source, low, (double)r->high), r->low, r->high);
}

static void test_whatever_is_refused_has_a_name_and_is_taken_with_what_would_be_right(void) {
  random_source source = {13};
  const int sets = random_cases(20000);
  int refused = 0;
  for (int set_number = 0; set_number < sets; ++set_number) {
    axis_parameters p;
    for (int i = 0; i < ROWS; ++i) {
      set(&p, &rows[i], draw(&source, &rows[i]));
    }
    parameter_refusal refusal = axis_parameters_check(&p);
    refused += refusal.status != CONTROL_OK ? 1 : 0;
    for (int turn = 0; turn < 8 && refusal.status != CONTROL_OK; ++turn) {
      const row *r = row_at(refusal.object);
      TEST_ASSERT_NOT_NULL(r);
      TEST_ASSERT_TRUE_MESSAGE(refusal.low <= refusal.high, r->name);
      const float share = (float)random_uniform(&source, 0.0, 1.0);
      set(&p, r, scalar_clamp(refusal.low + share * (refusal.high - refusal.low), refusal.low, refusal.high));
      refusal = axis_parameters_check(&p);
    }
    TEST_ASSERT_EQUAL(CONTROL_OK, refusal.status);
    TEST_ASSERT_EQUAL(CONTROL_OK, axis_parameters_build(&p, &built));
  }
  TEST_ASSERT_TRUE(refused > sets / 10 && refused < sets);
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_the_defaults_of_the_list_are_taken);
  RUN_TEST(test_the_struct_is_what_the_rows_list_and_nothing_else);
  RUN_TEST(test_every_copied_value_reaches_its_block);
  RUN_TEST(test_anti_windup_is_at_most_twice_as_fast_as_the_integral);
  RUN_TEST(test_every_value_may_be_at_the_ends_of_its_range_unless_another_one_is_named);
  RUN_TEST(test_a_value_beyond_its_range_is_named_with_its_range);
  RUN_TEST(test_the_blocks_refuse_what_the_list_refuses);
  RUN_TEST(test_breakaway_below_coulomb_torque_is_named_with_the_coulomb_torque);
  RUN_TEST(test_bristles_too_soft_for_the_breakaway_torque_are_named);
  RUN_TEST(test_a_setpoint_model_is_off_or_fast);
  RUN_TEST(test_filters_that_cannot_be_designed_name_frequency_or_width);
  RUN_TEST(test_whatever_is_refused_has_a_name_and_is_taken_with_what_would_be_right);
  return UNITY_END();
}
