/* SPDX-License-Identifier: Apache-2.0 */
/* Experiments over the bus (0x2100): set up, started and monitored by a master, on an axis that moves like a
 * machine. */
#include "support/node_bench.h"

#include "support/check.h"

enum { EXPERIMENT = 0x2100, COMMAND = 1, STATE, PROGRESS, KIND, COUNT, DWELL, SPEED, RATIO, ACCELERATION, TORQUE };
enum { ANGLE = 11, LOW_HZ, HIGH_HZ, TRAVEL, SPEED_LIMIT, TORQUE_LIMIT, TIME_LIMIT, DURATION, FORWARD, BACKWARD = 22 };
enum { START = 1, ABORT = 2, PV = 3, NO_MODE = 0 };

#define DEVICE_STATE 0x08000022u
#define INCOMPATIBLE 0x06040043u

void setUp(void) { node_bench_start(); }
void tearDown(void) {}

static void set_up_sweep(uint32_t shift) {
  SET(EXPERIMENT + shift, KIND, STIMULUS_SWEEP);
  SET(EXPERIMENT + shift, COUNT, 2);
  SET_FLOAT(EXPERIMENT + shift, DWELL, 0.1f);
  SET_FLOAT(EXPERIMENT + shift, SPEED, 0.01f);
  SET_FLOAT(EXPERIMENT + shift, RATIO, 2.0f);
}

static void start_sweep(uint32_t shift) {
  enable(shift, NO_MODE);
  set_up_sweep(shift);
  SET(EXPERIMENT + shift, COMMAND, START);
  TEST_ASSERT_EQUAL(EXPERIMENT_RUNNING, get(EXPERIMENT + shift, STATE) & 0xFF);
}

static uint32_t state_of_experiment(void) { return get(EXPERIMENT, STATE) & 0xFF; }

static uint32_t wait_for_end(uint32_t max_ms) {
  for (uint32_t i = 0; i < max_ms && state_of_experiment() == EXPERIMENT_RUNNING; i += 10) {
    wait_ms(9);
  }
  return state_of_experiment();
}

static void test_a_sweep_runs_to_its_end_and_leaves_the_axis_at_rest(void) {
  start_sweep(0);
  wait_ms(60);
  CHECK_NEAR("rad/s", 0.01, fabs(machine.axis[0].rate_rad_s), 0.003);
  TEST_ASSERT_EQUAL(STIMULUS_SWEEP, get(0x2101, 2));
  TEST_ASSERT_EQUAL(1, get(0x2101, 3)); /* the first run */
  const uint32_t progress = get(EXPERIMENT, PROGRESS) & 0xFF;
  TEST_ASSERT_TRUE(progress > 0 && progress < 100);
  TEST_ASSERT_EQUAL(EXPERIMENT_DONE, wait_for_end(5000));
  TEST_ASSERT_EQUAL(100, get(EXPERIMENT, PROGRESS) & 0xFF);
  wait_ms(200);
  CHECK_NEAR("rad/s", 0.0, machine.axis[0].rate_rad_s, 1e-4);
  TEST_ASSERT_EQUAL(0, get(0x2101, 2));
  TEST_ASSERT_EQUAL_HEX32(STATE_ENABLED, state_of(0));
}

/* Both requests come in one ms: the axis has not had a tick with the command. */
static void test_a_command_shows_in_the_state_at_once(void) {
  enable(0, NO_MODE);
  set_up_sweep(0);
  sent_count = 0;
  give(0x600 + NODE_ID, 8, (const uint8_t[]){0x2F, 0x00, 0x21, COMMAND, START, 0, 0, 0});
  give(0x600 + NODE_ID, 8, (const uint8_t[]){0x40, 0x00, 0x21, STATE, 0, 0, 0, 0});
  wait_ms(1);
  TEST_ASSERT_EQUAL(2, sent_count);
  TEST_ASSERT_EQUAL_HEX8(0x60, sent[0].data[0]);
  TEST_ASSERT_EQUAL(EXPERIMENT_RUNNING, sent[1].data[4]);
}

static void test_the_duration_is_reported_before_anything_moves(void) {
  set_up_sweep(PITCH);
  const double ramps_s = 2.0 * (2.0 * 0.01 / 0.5 + 2.0 * 0.02 / 0.5);
  CHECK_NEAR("s", 2.0 * 2.0 * 0.1 + ramps_s, get_float(EXPERIMENT + PITCH, DURATION), 1e-4);
  TEST_ASSERT_EQUAL(0, get(EXPERIMENT + PITCH, PROGRESS) & 0xFF);
  CHECK_SAME("turns", 0.0, machine.axis[1].turns);
}

static void test_it_starts_only_in_operation_at_rest_and_without_a_mode(void) {
  set_up_sweep(0);
  TEST_ASSERT_EQUAL_HEX32(DEVICE_STATE, set(EXPERIMENT, COMMAND, START)); /* off */
  enable(0, PV);
  TEST_ASSERT_EQUAL_HEX32(DEVICE_STATE, set(EXPERIMENT, COMMAND, START)); /* a mode */
  SET(0x60FF, 0, 200000);
  wait_ms(500);
  SET(0x6060, 0, NO_MODE);
  wait_ms(2);
  TEST_ASSERT_EQUAL_HEX32(DEVICE_STATE, set(EXPERIMENT, COMMAND, START)); /* on its ramp to rest */
  wait_ms(500);
  SET(EXPERIMENT, COMMAND, START);
  TEST_ASSERT_EQUAL_HEX32(DEVICE_STATE, set(EXPERIMENT, COMMAND, START)); /* runs */
  TEST_ASSERT_EQUAL(EXPERIMENT_RUNNING, state_of_experiment());
}

static void test_a_set_up_beyond_its_limits_is_refused(void) {
  enable(0, NO_MODE);
  set_up_sweep(0);
  SET_FLOAT(EXPERIMENT, SPEED_LIMIT, 0.015f); /* the sweep goes to 0.02 */
  TEST_ASSERT_EQUAL_HEX32(INCOMPATIBLE, set(EXPERIMENT, COMMAND, START));
  SET_FLOAT(EXPERIMENT, SPEED_LIMIT, 0.1f);
  SET_FLOAT(EXPERIMENT, TIME_LIMIT, 0.3f);
  TEST_ASSERT_EQUAL_HEX32(INCOMPATIBLE, set(EXPERIMENT, COMMAND, START));
  SET_FLOAT(EXPERIMENT, TIME_LIMIT, 60.0f);
  SET(EXPERIMENT, KIND, STIMULUS_NONE);
  TEST_ASSERT_EQUAL_HEX32(INCOMPATIBLE, set(EXPERIMENT, COMMAND, START));
  TEST_ASSERT_EQUAL(EXPERIMENT_IDLE, state_of_experiment());
}

static void test_a_silent_master_ends_it(void) {
  enable(0, NO_MODE);
  set_up_sweep(0);
  SET_FLOAT(EXPERIMENT, DWELL, 2.0f);
  SET(EXPERIMENT, COMMAND, START);
  wait_ms(990);
  CHECK_NEAR("rad/s", 0.01, fabs(machine.axis[0].rate_rad_s), 0.003);
  wait_ms(15);
  wait_ms(300);
  CHECK_NEAR("rad/s", 0.0, machine.axis[0].rate_rad_s, 1e-3);
  TEST_ASSERT_EQUAL(EXPERIMENT_DRIVE_STOPPED, state_of_experiment());
  TEST_ASSERT_EQUAL(1, get(0x3041, 2));
}

static void test_a_master_can_abort_it(void) {
  start_sweep(0);
  wait_ms(60);
  SET(EXPERIMENT, COMMAND, ABORT);
  TEST_ASSERT_EQUAL(EXPERIMENT_ABORTED, state_of_experiment());
  wait_ms(300);
  CHECK_NEAR("rad/s", 0.0, machine.axis[0].rate_rad_s, 1e-4);
  SET(EXPERIMENT, COMMAND, 0);
  TEST_ASSERT_EQUAL(EXPERIMENT_ABORTED, state_of_experiment());
}

/* Its number is that of "abort", but it is written into another object. */
static void test_a_value_that_is_written_while_it_runs_is_no_command(void) {
  start_sweep(0);
  wait_ms(20);
  SET(EXPERIMENT, COUNT, 2);
  SET(EXPERIMENT, COUNT, START);
  TEST_ASSERT_EQUAL(EXPERIMENT_RUNNING, state_of_experiment());
  TEST_ASSERT_EQUAL(1, get(0x2101, 3));
}

static void test_a_joint_that_runs_away_ends_it(void) {
  start_sweep(0);
  wait_ms(50);
  machine.axis[0].rate_rad_s = 0.2;
  wait_ms(3);
  TEST_ASSERT_EQUAL(EXPERIMENT_TOO_FAST, state_of_experiment());
  start_sweep(PITCH);
  machine.axis[1].turns += 0.05; /* 0.3 rad: a knock, or an encoder that jumps */
  wait_ms(3);
  TEST_ASSERT_NOT_EQUAL(EXPERIMENT_RUNNING, get(EXPERIMENT + PITCH, STATE) & 0xFF);
}

static void test_an_axis_that_is_switched_off_ends_it(void) {
  start_sweep(0);
  wait_ms(50);
  command(0, 0x06);
  wait_ms(2);
  TEST_ASSERT_EQUAL(EXPERIMENT_DRIVE_STOPPED, state_of_experiment());
}

static void test_a_position_limit_in_its_path_ends_it(void) {
  SET(0x607D, 1, (uint32_t)-5000); /* 0.5 mrad to each side */
  SET(0x607D, 2, 5000);
  start_sweep(0);
  TEST_ASSERT_EQUAL(EXPERIMENT_DRIVE_STOPPED, wait_for_end(2000));
  wait_ms(300);
  CHECK_NEAR("rad", 0.0, 6.283185307 * machine.axis[0].turns, 0.002);
}

static void test_torque_ramps_push_as_they_say(void) {
  machine.axis[0].friction_nm = 5.0;
  enable(0, NO_MODE);
  SET(EXPERIMENT, KIND, STIMULUS_TORQUE_RAMPS);
  SET(EXPERIMENT, COUNT, 2);
  SET_FLOAT(EXPERIMENT, DWELL, 0.2f);
  SET_FLOAT(EXPERIMENT, TORQUE, 4.0f);
  SET(EXPERIMENT, COMMAND, START);
  double min_nm = 0.0;
  double max_nm = 0.0;
  for (int i = 0; i < 420; ++i) {
    wait_ms(1);
    const double torque_nm = 2.5 * (double)machine.axis[0].current_a;
    min_nm = fmin(min_nm, torque_nm);
    max_nm = fmax(max_nm, torque_nm);
  }
  CHECK_NEAR("N m", 4.0, max_nm, 0.1);
  CHECK_NEAR("N m", -4.0, min_nm, 0.1);
  TEST_ASSERT_EQUAL(EXPERIMENT_DONE, wait_for_end(1000));
  CHECK_SAME("turns", 0.0, machine.axis[0].turns);
}

static void test_a_hysteresis_loop_is_a_position_and_is_recorded_as_one(void) {
  enable(0, NO_MODE);
  SET(EXPERIMENT, KIND, STIMULUS_HYSTERESIS);
  SET(EXPERIMENT, COUNT, 2);
  SET_FLOAT(EXPERIMENT, DWELL, 0.4f);
  SET_FLOAT(EXPERIMENT, ANGLE, 1e-3f);
  SET(EXPERIMENT, COMMAND, START);
  wait_ms(100); /* a quarter of a period: the first tip */
  CHECK_NEAR("rad", 1e-3, fabs((double)get_float(0x2101, 8)), 5e-5);
  TEST_ASSERT_EQUAL(EXPERIMENT_DONE, wait_for_end(2000));
}

/* Aborted 45 mrad from where it began, near its tip: the axis comes to rest on its way, and does not go back. */
static void test_an_axis_whose_hysteresis_loop_is_aborted_stays_where_it_is(void) {
  enable(0, NO_MODE);
  SET(EXPERIMENT, KIND, STIMULUS_HYSTERESIS);
  SET_FLOAT(EXPERIMENT, DWELL, 4.0f);
  SET_FLOAT(EXPERIMENT, ANGLE, 0.05f);
  SET(EXPERIMENT, COMMAND, START);
  wait_ms(900);
  const double aborted_rad = 6.283185307 * machine.axis[0].turns;
  CHECK_NEAR("rad", 0.045, aborted_rad, 0.002);
  SET(EXPERIMENT, COMMAND, ABORT);
  TEST_ASSERT_EQUAL(EXPERIMENT_ABORTED, state_of_experiment());
  for (int ms = 0; ms < 900; ++ms) {
    wait_ms(1);
    const double on_rad = 6.283185307 * machine.axis[0].turns - aborted_rad;
    TEST_ASSERT_TRUE(on_rad > -5e-4 && on_rad < 5e-3);
  }
  TEST_ASSERT_EQUAL_HEX32(STATE_ENABLED, state_of(0));
}

static void test_a_hysteresis_loop_ends_at_a_position_limit(void) {
  SET(0x607D, 1, (uint32_t)-5000);
  SET(0x607D, 2, 5000);
  enable(0, NO_MODE);
  SET(EXPERIMENT, KIND, STIMULUS_HYSTERESIS);
  SET_FLOAT(EXPERIMENT, DWELL, 0.4f);
  SET_FLOAT(EXPERIMENT, ANGLE, 1e-3f);
  SET(EXPERIMENT, COMMAND, START);
  TEST_ASSERT_EQUAL(EXPERIMENT_DRIVE_STOPPED, wait_for_end(1000));
  CHECK_AT_MOST("rad", 0.6e-3, fabs(6.283185307 * machine.axis[0].turns));
}

static void test_a_chirp_shakes_a_turning_axis(void) {
  enable(0, NO_MODE);
  SET(EXPERIMENT, KIND, STIMULUS_CHIRP);
  SET(EXPERIMENT, COUNT, 1);
  SET_FLOAT(EXPERIMENT, DWELL, 0.5f);
  SET_FLOAT(EXPERIMENT, SPEED, 0.05f);
  SET_FLOAT(EXPERIMENT, TORQUE, 2.0f);
  SET(EXPERIMENT, COMMAND, START);
  wait_ms(350);
  CHECK_NEAR("rad/s", 0.05, fabs(machine.axis[0].rate_rad_s), 0.02);
  TEST_ASSERT_EQUAL(EXPERIMENT_DONE, wait_for_end(3000));
}

static void test_break_aways_find_the_torque_that_moves_the_axis(void) {
  machine.axis[0].friction_nm = 3.0;
  enable(0, NO_MODE);
  SET(EXPERIMENT, KIND, STIMULUS_BREAKAWAY);
  SET(EXPERIMENT, COUNT, 6);
  SET_FLOAT(EXPERIMENT, DWELL, 0.5f);
  SET_FLOAT(EXPERIMENT, TORQUE, 6.0f);
  SET_FLOAT(EXPERIMENT, ANGLE, 1e-4f);
  SET(EXPERIMENT, COMMAND, START);
  TEST_ASSERT_EQUAL(EXPERIMENT_DONE, wait_for_end(20000));
  TEST_ASSERT_EQUAL(3, get(EXPERIMENT, FORWARD));
  TEST_ASSERT_EQUAL(3, get(EXPERIMENT, BACKWARD));
  /* While 6 kg m^2 move 0.1 mrad under the torque above friction, t, torque keeps rising: x = 12 N m/s t^3 / (6 J). */
  const double found_nm = 3.0 + cbrt(6.0 * 6.0 * 1e-4 * 12.0 * 12.0);
  CHECK_NEAR("forward, N m", found_nm, get_float(EXPERIMENT, FORWARD + 1), 0.05);
  CHECK_NEAR("backward, N m", found_nm, get_float(EXPERIMENT, BACKWARD + 1), 0.05);
  CHECK_AT_MOST("spread, N m", 0.1, get_float(EXPERIMENT, FORWARD + 2));
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_a_sweep_runs_to_its_end_and_leaves_the_axis_at_rest);
  RUN_TEST(test_a_command_shows_in_the_state_at_once);
  RUN_TEST(test_the_duration_is_reported_before_anything_moves);
  RUN_TEST(test_it_starts_only_in_operation_at_rest_and_without_a_mode);
  RUN_TEST(test_a_set_up_beyond_its_limits_is_refused);
  RUN_TEST(test_a_silent_master_ends_it);
  RUN_TEST(test_a_master_can_abort_it);
  RUN_TEST(test_a_value_that_is_written_while_it_runs_is_no_command);
  RUN_TEST(test_a_joint_that_runs_away_ends_it);
  RUN_TEST(test_an_axis_that_is_switched_off_ends_it);
  RUN_TEST(test_a_position_limit_in_its_path_ends_it);
  RUN_TEST(test_torque_ramps_push_as_they_say);
  RUN_TEST(test_a_hysteresis_loop_is_a_position_and_is_recorded_as_one);
  RUN_TEST(test_an_axis_whose_hysteresis_loop_is_aborted_stays_where_it_is);
  RUN_TEST(test_a_hysteresis_loop_ends_at_a_position_limit);
  RUN_TEST(test_a_chirp_shakes_a_turning_axis);
  RUN_TEST(test_break_aways_find_the_torque_that_moves_the_axis);
  return UNITY_END();
}
