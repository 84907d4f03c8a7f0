/* SPDX-License-Identifier: Apache-2.0 */
/* Staged, active and previous set of an axis: what each operation changes, and what a refusal leaves as it was. */
#include "parameters/axis_tuning.h"

#include <stdio.h>
#include <string.h>

#include "parameters/axis_dictionary.h"
#include "servo/servo_app.h"
#include "support/check.h"
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
  tuning.gains_follow = false;
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
  const uint32_t changes = tuning.changes;
  tuning.overridden = true;
  TEST_ASSERT_EQUAL(CONTROL_OK, axis_tuning_start(&tuning, &defaults, &in_force));
  TEST_ASSERT_EQUAL_UINT32(changes + 1, tuning.changes);
  TEST_ASSERT_FALSE(tuning.overridden);
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

static loop_verdict judge(void) {
  loop_verdict verdict = LOOP_RUNNING;
  for (int ms = 0; ms < 300 && verdict == LOOP_RUNNING; ++ms) {
    verdict = axis_tuning_judge(&tuning);
  }
  return verdict;
}

static void test_an_unstable_set_is_refused_and_the_value_that_differs_most_is_named(void) {
  TEST_ASSERT_EQUAL(LOOP_STABLE, judge());
  TEST_ASSERT_EQUAL(CONTROL_OK, tuning.last_result);
  TEST_ASSERT_EQUAL(CONTROL_OK, tuning.refusal.status);
  tuning.staged.speed_loop.proportional_nm_s_rad = 800.0f;
  tuning.staged.filters.lowpass_hz = 5.0f;
  TEST_ASSERT_EQUAL(LOOP_REFUSED, judge());
  TEST_ASSERT_EQUAL(CONTROL_UNSTABLE, tuning.last_result);
  TEST_ASSERT_EQUAL(CONTROL_UNSTABLE, tuning.refusal.status);
  TEST_ASSERT_EQUAL_HEX32(PARAMETER_OBJECT(0x2040, 4), tuning.refusal.object);
  TEST_ASSERT_EQUAL_FLOAT(0.0f, tuning.refusal.low);
  TEST_ASSERT_EQUAL_FLOAT(0.0f, tuning.refusal.high);
  expect_gains(800.0f, 720.0f);
}

/* Stored gains for another machine: nothing differs from what is active, so the plant is named. */
static void test_an_active_set_that_is_unstable_names_the_inertia_of_its_plant(void) {
  axis_parameters unstable = defaults;
  unstable.speed_loop.proportional_nm_s_rad = 20000.0f;
  TEST_ASSERT_EQUAL(CONTROL_OK, axis_tuning_start(&tuning, &unstable, &in_force));
  TEST_ASSERT_EQUAL(LOOP_REFUSED, judge());
  TEST_ASSERT_EQUAL_HEX32(PARAMETER_OBJECT(0x2056, 1), tuning.refusal.object);
  TEST_ASSERT_EQUAL_FLOAT(defaults.plant.inertia_kg_m2, tuning.refusal.low);
  TEST_ASSERT_EQUAL_FLOAT(defaults.plant.inertia_kg_m2, tuning.refusal.high);
}

static void test_a_tracking_loop_that_is_unstable_is_refused_by_its_gain(void) {
  tuning.staged.tracking_loop.kind = TRACKER_PI;
  TEST_ASSERT_EQUAL(CONTROL_OK, apply(720.0f));
  tuning.staged.tracking_loop.proportional_per_s = 90.0f;
  TEST_ASSERT_EQUAL(LOOP_REFUSED, judge());
  TEST_ASSERT_EQUAL_HEX32(PARAMETER_OBJECT(0x2011, 2), tuning.refusal.object);
}

static void test_the_proportional_gain_alone_is_named_too(void) {
  tuning.staged.speed_loop.proportional_nm_s_rad = 20000.0f;
  TEST_ASSERT_EQUAL(LOOP_REFUSED, judge());
  TEST_ASSERT_EQUAL_HEX32(PARAMETER_OBJECT(0x2000, 1), tuning.refusal.object);
  TEST_ASSERT_EQUAL_FLOAT(720.0f, tuning.refusal.low);
  TEST_ASSERT_EQUAL_FLOAT(720.0f, tuning.refusal.high);
}

/* A gain that is much too high, and beside it one value that has changed by even more: that one is named. */
static void test_each_value_that_decides_is_named_by_its_object(void) {
  axis_parameters *s = &tuning.staged;
  const struct {
    uint32_t object;
    float *real;
    uint32_t *whole;
    float value;
  } values[] = {
      {PARAMETER_OBJECT(0x2000, 2), &s->speed_loop.integral_nm_rad, NULL, 1.0f},
      {PARAMETER_OBJECT(0x2000, 3), &s->speed_loop.setpoint_weight, NULL, 0.001f},
      {PARAMETER_OBJECT(0x2020, 4), &s->observer.bandwidth_rad_s, NULL, 0.5f},
      {PARAMETER_OBJECT(0x2020, 2), &s->observer.inertia_kg_m2, NULL, 0.01f},
      {PARAMETER_OBJECT(0x2020, 1), NULL, &s->observer.on, 0.0f},
      {PARAMETER_OBJECT(0x2040, 4), &s->filters.lowpass_hz, NULL, 200.0f},
      {PARAMETER_OBJECT(0x2040, 5), &s->filters.lowpass_damping, NULL, 0.1f},
      {PARAMETER_OBJECT(0x2040, 1), &s->filters.notch_hz, NULL, 100.0f},
      {PARAMETER_OBJECT(0x2040, 2), &s->filters.notch_width_hz, NULL, 0.1f},
      {PARAMETER_OBJECT(0x2040, 3), &s->filters.notch_depth, NULL, 0.9f},
      {PARAMETER_OBJECT(0x2050, 3), NULL, &s->sensors.window_ticks, 16.0f},
      {PARAMETER_OBJECT(0x2050, 2), &s->sensors.crossover_rad_s, NULL, 1.0f},
      {PARAMETER_OBJECT(0x2050, 1), NULL, &s->sensors.source, 0.0f},
      {PARAMETER_OBJECT(0x2010, 1), &s->position_loop.proportional_per_s, NULL, 0.1f},
      {PARAMETER_OBJECT(0x2011, 2), &s->tracking_loop.proportional_per_s, NULL, 0.01f},
      {PARAMETER_OBJECT(0x2011, 3), &s->tracking_loop.integral_per_s2, NULL, 0.01f},
      {PARAMETER_OBJECT(0x2011, 1), NULL, &s->tracking_loop.kind, 0.0f},
      {PARAMETER_OBJECT(0x2055, 5), &s->motor.bandwidth_rad_s, NULL, 10.0f},
      {PARAMETER_OBJECT(0x2056, 1), &s->plant.inertia_kg_m2, NULL, 0.1f},
  };
  for (unsigned i = 0; i < sizeof values / sizeof values[0]; ++i) {
    char text[120];
    axis_tuning_revert(&tuning);
    const float before = values[i].real != NULL ? *values[i].real : (float)*values[i].whole;
    s->speed_loop.proportional_nm_s_rad = 4950.0f;
    s->speed_loop.acceleration_inertia_kg_m2 = 0.0f; /* else it is too large for the smaller plant, and is named */
    if (values[i].real != NULL) {
      *values[i].real = values[i].value;
    } else {
      *values[i].whole = (uint32_t)values[i].value;
    }
    const loop_verdict verdict = judge();
    (void)snprintf(text, sizeof text, "%04X:%u from %g to %g: verdict %d, named %X", (unsigned)(values[i].object >> 16),
                   (unsigned)(values[i].object >> 8 & 0xFFu), (double)before, (double)values[i].value, (int)verdict,
                   (unsigned)tuning.refusal.object);
    TEST_ASSERT_EQUAL_MESSAGE(LOOP_REFUSED, verdict, text);
    TEST_ASSERT_EQUAL_HEX32_MESSAGE(values[i].object, tuning.refusal.object, text);
    TEST_ASSERT_EQUAL_FLOAT_MESSAGE(before, tuning.refusal.low, text);
  }
}

static void test_stability_is_judged_on_the_plant_and_the_delays_of_the_staged_set(void) {
  axis_parameters *s = &tuning.staged;
  s->plant.inertia_kg_m2 = 6.0f;
  s->plant.min_inertia_kg_m2 = 3.0f;
  s->plant.viscous_nm_s_rad = 8.0f;
  s->plant.stiffness_nm_rad = 3e4f;
  s->plant.damping_nm_s_rad = 300.0f;
  s->plant.encoder_delay_s = 1e-4f;
  s->plant.gyro_delay_s = 5e-4f;
  s->plant.gyro_bandwidth_rad_s = 2000.0f;
  s->motor.bandwidth_rad_s = 5000.0f;
  s->position_loop.proportional_per_s = 9.0f;
  (void)axis_tuning_judge(&tuning);
  const loop_stability_input *in = &tuning.judged;
  CHECK_SAME("kg m^2", 6.0, in->plant.inertia_kg_m2);
  CHECK_SAME("smallest kg m^2", 3.0, in->plant.min_inertia_kg_m2);
  CHECK_SAME("Nm s/rad", 8.0, in->plant.viscous_nm_s_rad);
  CHECK_SAME("Nm/rad", 3e4, in->plant.stiffness_nm_rad);
  CHECK_SAME("Nm s/rad of the bristles", 300.0, in->plant.damping_nm_s_rad);
  /* Two PWM periods of 50 us, the current loop, the sensor. */
  CHECK_NEAR("s to the angle", 1e-4 + 2e-4 + 1e-4, in->plant.encoder_delay_s, 1e-9);
  CHECK_NEAR("s to the gyro", 1e-4 + 2e-4 + 5e-4 + 5e-4, in->plant.gyro_delay_s, 1e-9);
  CHECK_SAME("1/s", 9.0, in->position_per_s);
  CHECK_SAME("s", SERVO_TICK_S, in->dt_s);
  s->plant.min_inertia_kg_m2 = 9.0f; /* not known: the smallest inertia is not above the largest */
  (void)axis_tuning_judge(&tuning);
  CHECK_SAME("smallest kg m^2", 6.0, tuning.judged.plant.min_inertia_kg_m2);
}

/* Little inertia at the zenith: the azimuth's gains follow it, and another axis would shake. */
static void test_the_azimuths_gains_are_judged_as_they_follow_its_inertia(void) {
  tuning.staged.plant.gyro_mounting = (uint32_t)GYRO_ON_LINE_OF_SIGHT;
  TEST_ASSERT_EQUAL(LOOP_STABLE, judge());
  TEST_ASSERT_FALSE(tuning.judged.gyro_vanishes); /* the pitch axis: its gyro measures all of its rate */
  tuning.staged.plant.min_inertia_kg_m2 = 0.1f;
  TEST_ASSERT_EQUAL(LOOP_REFUSED, judge());
  tuning.gains_follow = true;
  TEST_ASSERT_EQUAL(LOOP_STABLE, judge());
  TEST_ASSERT_TRUE(tuning.judged.gains_follow);
  TEST_ASSERT_TRUE(tuning.judged.gyro_vanishes);
  tuning.staged.plant.gyro_mounting = (uint32_t)GYRO_ON_AXIS;
  TEST_ASSERT_EQUAL(LOOP_STABLE, judge());
  TEST_ASSERT_FALSE(tuning.judged.gyro_vanishes || tuning.judged.gyro_below);
  tuning.staged.plant.gyro_mounting = (uint32_t)GYRO_BELOW_JOINT;
  TEST_ASSERT_EQUAL(LOOP_STABLE, judge());
  TEST_ASSERT_TRUE(tuning.judged.gyro_below && !tuning.judged.gyro_vanishes);
}

static void test_a_feedforward_beyond_the_plant_is_refused_at_once_with_its_range(void) {
  tuning.staged.speed_loop.acceleration_inertia_kg_m2 = 1e3f;
  TEST_ASSERT_EQUAL(LOOP_REFUSED, axis_tuning_judge(&tuning));
  TEST_ASSERT_EQUAL(CONTROL_UNSTABLE, tuning.last_result);
  TEST_ASSERT_EQUAL_HEX32(PARAMETER_OBJECT(0x2000, 5), tuning.refusal.object);
  TEST_ASSERT_EQUAL_HEX32(PARAMETER_OBJECT(0x2056, 1), tuning.refusal.bound_by);
  TEST_ASSERT_EQUAL_FLOAT(18.0f, tuning.refusal.high);
  expect_gains(720.0f, 720.0f);
  TEST_ASSERT_EQUAL(LOOP_REFUSED, axis_tuning_judge(&tuning)); /* again, with nothing changed */
  axis_tuning_revert(&tuning);
  TEST_ASSERT_EQUAL(LOOP_STABLE, judge());
}

/* A first power-up: 1 A of 16 A. The seal takes more than half of what is left; its feedforward stays. */
static void test_a_lower_current_limit_keeps_the_feedforward_in_force(void) {
  tuning.staged.friction.model = tuning.active.friction.model = (uint32_t)FRICTION_LUGRE;
  tuning.staged.friction.positive.coulomb_nm = tuning.active.friction.positive.coulomb_nm = 7.0f;
  tuning.staged.friction.positive.breakaway_nm = tuning.active.friction.positive.breakaway_nm = 9.0f;
  tuning.staged.motor.current_limit_a = 1.0f;
  tuning.staged.speed_loop.proportional_nm_s_rad = 700.0f; /* no part of it */
  TEST_ASSERT_EQUAL(LOOP_STABLE, judge());
  tuning.active.friction.positive.coulomb_nm = 6.0f; /* taken back: the same staged set is now a change */
  TEST_ASSERT_EQUAL(LOOP_REFUSED, axis_tuning_judge(&tuning));
  tuning.active.friction.positive.coulomb_nm = 7.0f;
  tuning.staged.friction.positive.coulomb_nm = 8.0f;
  TEST_ASSERT_EQUAL(LOOP_REFUSED, axis_tuning_judge(&tuning));
  TEST_ASSERT_EQUAL_HEX32(PARAMETER_OBJECT(0x2030, 7), tuning.refusal.object);
  tuning.staged.friction.positive.coulomb_nm = 6.5f; /* smaller, but another one: it is judged by the limit of now */
  TEST_ASSERT_EQUAL(LOOP_REFUSED, axis_tuning_judge(&tuning));
}

static void test_the_check_starts_again_when_the_staged_set_changes(void) {
  tuning.staged.speed_loop.proportional_nm_s_rad = 20000.0f;
  TEST_ASSERT_EQUAL(LOOP_RUNNING, axis_tuning_judge(&tuning));
  axis_tuning_revert(&tuning);
  TEST_ASSERT_EQUAL(LOOP_STABLE, judge());
}

static void test_a_set_that_cannot_be_built_is_left_to_apply(void) {
  tuning.staged.speed_loop.proportional_nm_s_rad = -1.0f;
  TEST_ASSERT_EQUAL(LOOP_STABLE, judge());
  TEST_ASSERT_EQUAL(CONTROL_OUT_OF_RANGE, apply(-1.0f));
}

static void test_a_set_is_proven_after_it_has_run_without_oscillation(void) {
  TEST_ASSERT_FALSE(axis_tuning_can_take_back(&tuning));
  TEST_ASSERT_EQUAL(CONTROL_OK, apply(700.0f));
  TEST_ASSERT_TRUE(axis_tuning_can_take_back(&tuning));
  for (int ms = 0; ms < AXIS_TUNING_PROVEN_TICKS; ++ms) {
    axis_tuning_ran(&tuning, false);
  }
  TEST_ASSERT_TRUE(axis_tuning_can_take_back(&tuning));
  for (int ms = 0; ms < AXIS_TUNING_PROVEN_TICKS; ++ms) {
    TEST_ASSERT_TRUE(axis_tuning_can_take_back(&tuning));
    axis_tuning_ran(&tuning, true);
  }
  TEST_ASSERT_FALSE(axis_tuning_can_take_back(&tuning));
}

static void test_another_set_must_run_as_long_before_it_is_proven(void) {
  TEST_ASSERT_EQUAL(CONTROL_OK, apply(700.0f));
  for (int ms = 0; ms < AXIS_TUNING_PROVEN_TICKS - 1; ++ms) {
    axis_tuning_ran(&tuning, true);
  }
  const uint32_t changes = tuning.changes;
  TEST_ASSERT_EQUAL(CONTROL_OK, apply(690.0f));
  TEST_ASSERT_EQUAL(changes + 1, tuning.changes);
  for (int ms = 0; ms < AXIS_TUNING_PROVEN_TICKS; ++ms) {
    TEST_ASSERT_TRUE(axis_tuning_can_take_back(&tuning));
    axis_tuning_ran(&tuning, true);
  }
  TEST_ASSERT_FALSE(axis_tuning_can_take_back(&tuning));
}

/* It has run before: there is nothing to take back. */
static void test_the_set_of_the_start_counts_as_proven(void) {
  memset(&tuning, 0, sizeof tuning);
  TEST_ASSERT_EQUAL(CONTROL_OK, axis_tuning_start(&tuning, &defaults, &in_force));
  TEST_ASSERT_FALSE(axis_tuning_can_take_back(&tuning));
  TEST_ASSERT_EQUAL_MEMORY(&defaults, &tuning.proven, sizeof defaults);
}

/* Each value in turn: motor and plant need the lock, and would return without it. */
static void test_a_set_is_not_taken_back_when_a_guarded_value_has_changed_since(void) {
  int guarded = 0;
  for (uint32_t i = 0; i < axis_parameters_table.count; ++i) {
    const od_entry *entry = &axis_parameters_table.entries[i];
    if (axis_parameters_has(entry)) {
      setUp();
      const float value = axis_parameters_value(&tuning.staged, entry);
      const float other = 0.999f * value + 0.001f * (value < 1.0f ? (float)entry->high.f : (float)entry->low.f);
      memcpy((uint8_t *)&tuning.staged + entry->offset, &other, sizeof other);
      if (axis_tuning_apply(&tuning, &axis, &in_force, SERVO_TICK_S) == CONTROL_OK && other != value) {
        guarded += (entry->flags & OD_GUARDED) != 0;
        TEST_ASSERT_EQUAL((entry->flags & OD_GUARDED) == 0, axis_tuning_can_take_back(&tuning));
      }
    }
  }
  TEST_ASSERT_GREATER_OR_EQUAL(10, guarded);
}

static void test_a_set_for_other_motor_data_is_proven_as_any(void) {
  tuning.staged.motor.current_limit_a = 1.0f;
  TEST_ASSERT_EQUAL(CONTROL_OK, apply(700.0f));
  for (int ms = 0; ms < AXIS_TUNING_PROVEN_TICKS; ++ms) {
    axis_tuning_ran(&tuning, true);
  }
  TEST_ASSERT_EQUAL(CONTROL_OK, apply(690.0f));
  TEST_ASSERT_TRUE(axis_tuning_can_take_back(&tuning));
}

static void test_a_set_that_is_taken_back_is_gone(void) {
  axis.mode = SERVO_SPEED;
  TEST_ASSERT_EQUAL(CONTROL_OK, apply(700.0f));
  axis_tuning_take_back(&tuning, &axis, &in_force, 3.0f, SERVO_TICK_S);
  expect_gains(700.0f, 720.0f);
  TEST_ASSERT_FALSE(axis_tuning_can_take_back(&tuning));
  TEST_ASSERT_EQUAL_FLOAT(3.0f, axis.speed.pi.integral);
  TEST_ASSERT_EQUAL(CONTROL_OK, axis_tuning_undo(&tuning, &axis, &in_force, SERVO_TICK_S));
  expect_gains(720.0f, 720.0f);
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_the_start_makes_one_set_staged_active_and_in_force);
  RUN_TEST(test_a_start_with_a_wrong_set_is_refused_and_changes_nothing);
  RUN_TEST(test_an_applied_set_is_in_force_and_undo_takes_it_back_and_gives_it_again);
  RUN_TEST(test_a_refused_set_stays_staged_and_the_active_one_in_force);
  RUN_TEST(test_the_flags_say_what_is_staged_and_what_is_not_stored);
  RUN_TEST(test_an_unstable_set_is_refused_and_the_value_that_differs_most_is_named);
  RUN_TEST(test_an_active_set_that_is_unstable_names_the_inertia_of_its_plant);
  RUN_TEST(test_a_tracking_loop_that_is_unstable_is_refused_by_its_gain);
  RUN_TEST(test_the_proportional_gain_alone_is_named_too);
  RUN_TEST(test_each_value_that_decides_is_named_by_its_object);
  RUN_TEST(test_stability_is_judged_on_the_plant_and_the_delays_of_the_staged_set);
  RUN_TEST(test_the_azimuths_gains_are_judged_as_they_follow_its_inertia);
  RUN_TEST(test_a_feedforward_beyond_the_plant_is_refused_at_once_with_its_range);
  RUN_TEST(test_a_lower_current_limit_keeps_the_feedforward_in_force);
  RUN_TEST(test_the_check_starts_again_when_the_staged_set_changes);
  RUN_TEST(test_a_set_that_cannot_be_built_is_left_to_apply);
  RUN_TEST(test_a_set_is_proven_after_it_has_run_without_oscillation);
  RUN_TEST(test_another_set_must_run_as_long_before_it_is_proven);
  RUN_TEST(test_the_set_of_the_start_counts_as_proven);
  RUN_TEST(test_a_set_is_not_taken_back_when_a_guarded_value_has_changed_since);
  RUN_TEST(test_a_set_for_other_motor_data_is_proven_as_any);
  RUN_TEST(test_a_set_that_is_taken_back_is_gone);
  return UNITY_END();
}
