/* SPDX-License-Identifier: Apache-2.0 */
/* Monitors that judge every few ticks: drift, standstill, direction, reduced speed. */
#include "protection/slow_monitors.h"

#include <math.h>
#include <string.h>

#include "support/check.h"
#include "unity.h"

#define DT_S 0.001f

typedef struct {
  slow_monitors slow;
  axis_protection protection;
  protection_limits limits;
  protection_motor motor;
  protection_inputs in;
  slow_commands commands;
  fault_set broken;
  double angle_rad;
  int tick;
} bench;

static bench b;

void setUp(void) {
  memset(&b, 0, sizeof b);
  b.limits.base_rate_rad_s = 0.02f;
  b.limits.reduced_speed_rad_s = 0.1f;
  b.motor = (protection_motor){.current_limit_a = 10.0f, .torque_constant_nm_a = 4.0f};
  b.in.angle_valid = b.in.gyro_valid = b.in.closed = b.in.speed_closed = true;
}

void tearDown(void) {}

/* One tick at these rates of encoder and gyro. */
static fault_set step(float encoder_rad_s, float gyro_rad_s) {
  b.angle_rad += (double)encoder_rad_s * (double)DT_S;
  b.in.angle = (angle_turn32)(int64_t)llrint(b.angle_rad / (double)ANGLE_RAD_PER_TURN32);
  b.protection.last_inertial_rad_s = gyro_rad_s;
  b.in.rate_rad_s = encoder_rad_s;
  b.protection.slow_rate_rad_s += (encoder_rad_s - b.protection.slow_rate_rad_s) * 0.1f;
  slow_monitors_add(&b.slow, &b.protection, b.broken, b.in.torque_nm);
  if (++b.tick % SLOW_MONITOR_TICKS == 0) {
    slow_monitors_judge(&b.slow, &b.limits, &b.motor, &b.protection, &b.in, &b.commands, DT_S);
  }
  return b.slow.found;
}

static void run(float rate_rad_s, int ticks) {
  for (int i = 0; i < ticks; ++i) {
    TEST_ASSERT_EQUAL_HEX64(0, step(rate_rad_s, rate_rad_s));
  }
}

/* Ticks until this fault and no other one; 0: not within `most`. */
static int ticks_until(fault_id fault, float encoder_rad_s, float gyro_rad_s, int most) {
  for (int i = 1; i <= most; ++i) {
    const fault_set found = step(encoder_rad_s, gyro_rad_s);
    if (found != 0) {
      TEST_ASSERT_EQUAL_HEX64(fault_bit(fault), found);
      return i;
    }
  }
  return 0;
}

/* --- drift -------------------------------------------------------------------------------------------------------- */

static void test_a_creep_below_the_base_rate_is_a_drift_of_either_sensor(void) {
  for (int sign = -1; sign <= 1; sign += 2) {
    for (int gyro = 0; gyro <= 1; ++gyro) {
      setUp();
      b.limits.fixed_base_rad = 0.005f;
      run(0.3f, 100);
      const float rate_rad_s = 0.019f * (float)sign;
      const float encoder_rad_s = gyro == 1 ? 0.0f : rate_rad_s;
      CHECK_NEAR("ticks", 270.0, ticks_until(FAULT_SENSORS_DRIFT, encoder_rad_s, rate_rad_s - encoder_rad_s, 1000),
                 12.0);
    }
  }
}

static void test_a_base_that_moves_has_no_drift(void) {
  TEST_ASSERT_EQUAL(0, ticks_until(FAULT_SENSORS_DRIFT, 0.0f, 0.019f, 10000));
}

static void test_a_drift_that_is_reported_begins_anew(void) {
  b.limits.fixed_base_rad = 0.005f;
  TEST_ASSERT_TRUE(ticks_until(FAULT_SENSORS_DRIFT, 0.0f, 0.019f, 1000) > 0);
  TEST_ASSERT_EQUAL_HEX64(fault_bit(FAULT_SENSORS_DRIFT), step(0.0f, 0.0f)); /* until the next judgement */
  for (int i = 1; i < SLOW_MONITOR_TICKS; ++i) {
    (void)step(0.0f, 0.0f);
  }
  TEST_ASSERT_EQUAL_HEX64(0, b.slow.found);
  TEST_ASSERT_TRUE(ticks_until(FAULT_SENSORS_DRIFT, 0.0f, 0.019f, 1000) > 250);
}

/* A difference that FAULT_SENSORS_DISAGREE judges: at most its limit counts here, whatever its size. */
static void test_a_large_difference_counts_as_the_largest_that_is_no_disagreement(void) {
  b.limits.fixed_base_rad = 0.05f;
  run(0.0f, 8);
  for (int i = 0; i < 100; ++i) {
    (void)step(0.0f, 3.0f);
  }
  CHECK_NEAR("rad", 0.002, b.slow.drift.difference_rad, 1e-4);
}

static void test_what_a_broken_or_missing_sensor_adds_is_no_drift(void) {
  static const fault_id broken[] = {FAULT_ENCODER_LOST,     FAULT_ENCODER_JUMP,    FAULT_ENCODER_STUCK,
                                    FAULT_GYRO_LOST,        FAULT_ENCODER_ERRATIC, FAULT_GYRO_STUCK,
                                    FAULT_SENSORS_DISAGREE, FAULT_GYRO_SATURATED};
  for (unsigned i = 0; i < sizeof broken / sizeof broken[0]; ++i) {
    setUp();
    b.limits.fixed_base_rad = 0.005f;
    for (int tick = 0; tick < 2000; ++tick) {
      b.broken = tick % 200 == 7 ? fault_bit(broken[i]) : fault_bit(FAULT_OVERLOAD);
      TEST_ASSERT_EQUAL_HEX64(0, step(0.0f, 0.019f));
    }
  }
  setUp();
  b.limits.fixed_base_rad = 0.005f;
  const int ticks = ticks_until(FAULT_SENSORS_DRIFT, 0.0f, 0.019f, 1000);
  setUp();
  b.limits.fixed_base_rad = 0.005f;
  for (int i = 1; i <= ticks; ++i) { /* it breaks in the window in which they would have drifted too far */
    b.broken = i == ticks - 1 ? fault_bit(FAULT_GYRO_STUCK) : 0;
    TEST_ASSERT_EQUAL_HEX64(0, step(0.0f, 0.019f));
  }
  TEST_ASSERT_EQUAL(ticks - SLOW_MONITOR_TICKS, ticks_until(FAULT_SENSORS_DRIFT, 0.0f, 0.019f, 1000));
  setUp();
  b.limits.fixed_base_rad = 0.005f;
  b.protection.gyro_missing_ticks = 1;
  TEST_ASSERT_EQUAL(0, ticks_until(FAULT_SENSORS_DRIFT, 0.0f, 0.019f, 2000));
  b.protection.gyro_missing_ticks = 0;
  b.in.angle_valid = false;
  TEST_ASSERT_EQUAL(0, ticks_until(FAULT_SENSORS_DRIFT, 0.0f, 0.019f, 2000));
  b.in.angle_valid = true;
  b.angle_rad += 1.0; /* at another place now */
  CHECK_NEAR("ticks", 270.0, ticks_until(FAULT_SENSORS_DRIFT, 0.0f, 0.019f, 1000), 12.0);
}

/* --- standstill --------------------------------------------------------------------------------------------------- */

static void test_an_axis_that_stands_and_is_moved_leaves_its_standstill_only_on_a_fixed_base(void) {
  for (int fixed = 0; fixed <= 1; ++fixed) {
    setUp();
    b.limits.fixed_base_rad = fixed == 1 ? 0.005f : 0.0f;
    b.limits.standstill_rad = 0.01f;
    b.commands.standing = true;
    run(0.0f, 1200);
    TEST_ASSERT_INT_WITHIN(fixed == 1 ? SLOW_MONITOR_TICKS / 2 : 0, fixed == 1 ? 102 : 0,
                           ticks_until(FAULT_STANDSTILL_LEFT, 0.1f, 0.1f, 200));
  }
}

static void test_without_an_angle_no_motion_is_seen(void) {
  b.limits.fixed_base_rad = 0.005f;
  b.limits.standstill_rad = 0.01f;
  b.commands.standing = b.commands.reduced = true;
  run(0.0f, 1200);
  b.in.angle_valid = false;
  run(0.0f, 100);
  b.in.angle_valid = true;
  b.angle_rad += 1.0; /* at another place now */
  run(0.0f, 100);
}

static void test_an_axis_whose_loops_are_open_may_be_moved(void) {
  b.limits.fixed_base_rad = 0.005f;
  b.limits.standstill_rad = 0.01f;
  b.commands.standing = true;
  b.in.closed = false;
  run(0.1f, 2000);
  b.in.closed = true;
  run(0.1f, 900); /* and closed, from a second later on */
  TEST_ASSERT_TRUE(ticks_until(FAULT_STANDSTILL_LEFT, 0.1f, 0.1f, 300) > 100);
}

/* --- direction ---------------------------------------------------------------------------------------------------- */

static void monitor_direction(void) {
  b.limits.direction_rad = 0.05f;
  b.in.reference_rad_s = 0.2f;
}

/* The motor has 40 Nm. Wind moves an axis that pushes with less than a quarter of them. */
static void test_a_path_against_the_set_point_without_torque_is_a_speed_error(void) {
  const float torques_nm[] = {0.0f, 9.9f};
  for (int i = 0; i < 2; ++i) {
    setUp();
    monitor_direction();
    b.in.torque_nm = torques_nm[i];
    float rate_rad_s = 0.0f;
    int ticks = 0;
    fault_set found = 0;
    for (; found == 0 && ticks < 1000; ++ticks) {
      rate_rad_s -= 0.002f;
      found = step(rate_rad_s, rate_rad_s);
    }
    TEST_ASSERT_EQUAL_HEX64(fault_bit(FAULT_SPEED_ERROR), found);
    CHECK_NEAR("ticks to 0.05 rad", 224.0, ticks, 10.0);
    for (int more = 0; more < 500; ++more) {
      rate_rad_s -= 0.002f;
      TEST_ASSERT_EQUAL_HEX64(fault_bit(FAULT_SPEED_ERROR), step(rate_rad_s, rate_rad_s));
    }
  }
}

/* It has turned towards its set-point. Then 28 ms of a strong torque, and the path: from the seventh window of 4 ms on,
 * 20 of them to 0.05 rad. */
static void test_a_path_against_a_strong_torque_is_a_runaway(void) {
  monitor_direction();
  b.in.torque_nm = 10.1f;
  run(0.2f, 2 * SLOW_MONITOR_TICKS);
  float rate_rad_s = -0.52f;
  int ticks = 0;
  fault_set found = 0;
  for (; (found & fault_bit(FAULT_RUNAWAY)) == 0 && ticks < 1000; ++ticks) {
    rate_rad_s -= 0.002f;
    found = step(rate_rad_s, rate_rad_s);
  }
  TEST_ASSERT_EQUAL_HEX64(fault_bit(FAULT_RUNAWAY) | fault_bit(FAULT_SPEED_ERROR), found);
  TEST_ASSERT_EQUAL((6 + 20) * SLOW_MONITOR_TICKS, ticks);
}

/* A torque offset moves the axis outwards most of the time, and back now and then: 3 ticks of 4 in each phase, or 12 of
 * 20. The acceleration is that of 6 kg m^2. */
static void test_no_pattern_of_the_torque_is_a_runaway(void) {
  const int periods[] = {4, 20};
  for (int row = 0; row < 8; ++row) {
    setUp();
    monitor_direction();
    const int period = periods[row / 4];
    float rate_rad_s = -0.2f;
    for (int i = row % 4; i < 1000; ++i) {
      b.in.torque_nm = i % period < period * 3 / 5 + 1 ? -40.0f : 20.0f;
      rate_rad_s += b.in.torque_nm / 6.0f * DT_S;
      TEST_ASSERT_EQUAL_HEX64(0, step(rate_rad_s, rate_rad_s) & fault_bit(FAULT_RUNAWAY));
    }
  }
}

/* Wind has moved it, and its master then gives the torque back: it slows down. */
static void test_a_torque_that_comes_after_a_speed_error_is_no_runaway(void) {
  monitor_direction();
  float rate_rad_s = 0.0f;
  fault_set found = 0;
  for (int i = 0; i < 1000 && found == 0; ++i) {
    rate_rad_s -= 0.002f;
    found = step(rate_rad_s, rate_rad_s);
  }
  b.in.torque_nm = 40.0f;
  for (; rate_rad_s < -0.01f; rate_rad_s += 0.005f) {
    TEST_ASSERT_EQUAL_HEX64(fault_bit(FAULT_SPEED_ERROR), step(rate_rad_s, rate_rad_s));
  }
}

/* A torque offset moves it there: no sensor has the wrong sign. */
static void test_a_path_that_the_torque_explains_is_no_fault(void) {
  monitor_direction();
  b.in.torque_nm = -30.0f;
  for (float rate_rad_s = 0.0f; rate_rad_s > -1.0f; rate_rad_s -= 0.002f) {
    TEST_ASSERT_EQUAL_HEX64(0, step(rate_rad_s, rate_rad_s));
  }
}

/* Its decelerations between them do not shorten the path, and do not lengthen it. */
static void test_two_accelerations_against_the_set_point_add_up(void) {
  monitor_direction();
  run(-0.001f, 8);
  float rate_rad_s = 0.0f;
  for (int i = 0; i < 160; ++i) { /* 0.026 rad */
    rate_rad_s -= 0.002f;
    run(rate_rad_s, 1);
  }
  for (int i = 0; i < 80; ++i) {
    rate_rad_s += 0.002f;
    run(rate_rad_s, 1);
  }
  int ticks = 0;
  for (fault_set found = 0; found == 0 && ticks < 1000; ++ticks) {
    rate_rad_s -= 0.002f;
    found = step(rate_rad_s, rate_rad_s);
  }
  CHECK_NEAR("ticks to the other 0.024 rad", 93.0, ticks, 12.0);
}

static void test_braking_after_a_step_of_the_set_point_is_no_runaway(void) {
  b.in.reference_rad_s = -1.0f;
  run(-1.0f, 100);
  monitor_direction();
  for (float rate_rad_s = -1.0f; rate_rad_s < 0.2f; rate_rad_s += 0.002f) { /* over 0.25 rad */
    TEST_ASSERT_EQUAL_HEX64(0, step(rate_rad_s, rate_rad_s));
  }
}

static void test_no_direction_is_monitored_without_a_loop_of_speed_or_a_window(void) {
  for (int open = 0; open <= 1; ++open) {
    setUp();
    monitor_direction();
    b.in.speed_closed = open == 0;
    b.limits.direction_rad = open == 0 ? 0.0f : 0.05f;
    for (float rate_rad_s = 0.0f; rate_rad_s > -2.0f; rate_rad_s -= 0.002f) {
      TEST_ASSERT_EQUAL_HEX64(0, step(rate_rad_s, rate_rad_s));
    }
  }
}

/* --- reduced speed ------------------------------------------------------------------------------------------------ */

static void test_the_reduced_speed_counts_from_a_second_after_its_selection(void) {
  for (int sign = -1; sign <= 1; sign += 2) {
    setUp();
    const float fast_rad_s = 0.12f * (float)sign;
    run(fast_rad_s, 100);
    b.commands.reduced = true;
    run(fast_rad_s, 1000);
    const int ticks = ticks_until(FAULT_REDUCED_SPEED, fast_rad_s, fast_rad_s, 10);
    TEST_ASSERT_TRUE(ticks > 0 && ticks <= SLOW_MONITOR_TICKS);
    b.commands.reduced = false;
    for (int i = 0; i < SLOW_MONITOR_TICKS; ++i) {
      (void)step(fast_rad_s, fast_rad_s);
    }
    run(fast_rad_s, 100);
    b.commands.reduced = true;
    run(0.09f * (float)sign, 2000);
    TEST_ASSERT_TRUE(ticks_until(FAULT_REDUCED_SPEED, fast_rad_s, fast_rad_s, 2 * SLOW_MONITOR_TICKS) > 0);
    b.in.closed = false;
    for (int i = 0; i < SLOW_MONITOR_TICKS; ++i) {
      (void)step(fast_rad_s, fast_rad_s);
    }
    run(fast_rad_s, 2000);
  }
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_a_creep_below_the_base_rate_is_a_drift_of_either_sensor);
  RUN_TEST(test_a_base_that_moves_has_no_drift);
  RUN_TEST(test_a_drift_that_is_reported_begins_anew);
  RUN_TEST(test_a_large_difference_counts_as_the_largest_that_is_no_disagreement);
  RUN_TEST(test_what_a_broken_or_missing_sensor_adds_is_no_drift);
  RUN_TEST(test_an_axis_that_stands_and_is_moved_leaves_its_standstill_only_on_a_fixed_base);
  RUN_TEST(test_without_an_angle_no_motion_is_seen);
  RUN_TEST(test_an_axis_whose_loops_are_open_may_be_moved);
  RUN_TEST(test_a_path_against_the_set_point_without_torque_is_a_speed_error);
  RUN_TEST(test_a_path_against_a_strong_torque_is_a_runaway);
  RUN_TEST(test_no_pattern_of_the_torque_is_a_runaway);
  RUN_TEST(test_a_torque_that_comes_after_a_speed_error_is_no_runaway);
  RUN_TEST(test_a_path_that_the_torque_explains_is_no_fault);
  RUN_TEST(test_two_accelerations_against_the_set_point_add_up);
  RUN_TEST(test_braking_after_a_step_of_the_set_point_is_no_runaway);
  RUN_TEST(test_no_direction_is_monitored_without_a_loop_of_speed_or_a_window);
  RUN_TEST(test_the_reduced_speed_counts_from_a_second_after_its_selection);
  return UNITY_END();
}
