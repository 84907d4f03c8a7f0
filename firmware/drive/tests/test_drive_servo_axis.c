/* SPDX-License-Identifier: Apache-2.0 */
/* The servo axis as the drive uses it, connected as the node connects them. */
#include "drive/drive_axis.h"
#include "servo/servo_axis.h"
#include "support/check.h"
#include "support/servo_bench.h"

void setUp(void) {}
void tearDown(void) {}

typedef struct {
  bench b;
  drive_axis drive;
  drive_objects o;
  drive_axis_inputs in;
} node;

static void node_tick(node *n) {
  n->b.samples.sensors.joint_angle_turn32 = (angle_turn32)(uint64_t)((n->b.turns - floor(n->b.turns)) * 4294967296.0);
  drive_axis_sense(&n->in, &n->b.axis, &n->b.params, &n->b.samples);
  n->b.command = *drive_axis_step(&n->drive, &n->o, &n->in, dt_s);
  drive_axis_report(&n->drive, &n->o, &n->in, dt_s);
  const drive_machine machine = {.margin = 0};
  drive_axis_prepare(&n->drive, &n->o, &machine, dt_s);
  n->in.setpoint_arrived = false;
  tick(&n->b);
}

static void node_ticks(node *n, int count) {
  for (int i = 0; i < count; ++i) {
    node_tick(n);
  }
}

static node node_enabled(int8_t mode) {
  node n = {.b = bench_at_rest()};
  n.o.state.option = drive_options_default();
  n.o.state.mode = mode;
  n.o.position.following_error_window = 100000;
  n.o.position.following_error_ms = 10;
  n.o.position.window = 100;
  n.o.position.window_ms = 20;
  n.o.velocity.window = 500;
  n.o.velocity.window_ms = 20;
  n.o.torque.rated_mnm = 40000;
  n.o.torque.maximum = n.o.torque.positive_limit = n.o.torque.negative_limit = 1000;
  n.o.limit = (drive_limit_objects){.maximum_velocity = 800000,
                                    .profile_velocity = 500000,
                                    .acceleration = 1000000,
                                    .deceleration = 1000000,
                                    .quick_stop_deceleration = 1500000,
                                    .jerk = 20000000,
                                    .interpolation_period = 10,
                                    .interpolation_exponent = -3};
  n.in.ready = n.in.voltage_present = n.in.may_enable = n.in.remote = true;
  drive_axis_reset(&n.drive, 0u);
  const uint16_t words[] = {0x00, 0x06, 0x07, 0x0F};
  for (unsigned i = 0; i < 4; ++i) {
    n.o.state.controlword = words[i];
    node_ticks(&n, 2);
  }
  TEST_ASSERT_EQUAL_HEX16(0x27, n.o.state.statusword & 0x6F);
  return n;
}

static void test_pv_turns_the_axis_at_1_deg_s(void) {
  node n = node_enabled(DRIVE_PROFILE_VELOCITY);
  n.o.velocity.target = 17453;
  double fastest_rad_s = 0.0;
  for (int i = 0; i < 1000; ++i) {
    node_tick(&n);
    fastest_rad_s = fmax(fastest_rad_s, n.b.rate_rad_s);
  }
  LOG_VALUE("fastest, rad/s", fastest_rad_s);
  CHECK_NEAR("rate, rad/s", 0.017453, n.b.rate_rad_s, 1e-6);
  CHECK_NEAR("606C", 17453, n.o.velocity.actual, 3);
  CHECK_AT_MOST("fastest, rad/s", 0.01746 * 1.05, fastest_rad_s);
  TEST_ASSERT_TRUE((n.o.state.statusword & DRIVE_STATUS_TARGET_REACHED) != 0);
}

static void test_pp_carries_the_axis_along_its_ramp(void) {
  node n = node_enabled(DRIVE_PROFILE_POSITION);
  n.o.position.target = 7000000;
  n.o.state.controlword = 0x1F;
  double worst_error = 0.0;
  double farthest_rad = 0.0;
  int count = 0;
  node_ticks(&n, 3);
  while ((n.o.state.statusword & DRIVE_STATUS_TARGET_REACHED) == 0) {
    node_tick(&n);
    worst_error = fmax(worst_error, fabs((double)n.o.position.following_error));
    farthest_rad = fmax(farthest_rad, n.b.turns * 6.283185307179586);
    TEST_ASSERT_TRUE(++count < 5000);
  }
  LOG_VALUE("ticks in motion", count);
  LOG_VALUE("largest following error, 1e-7 rad", worst_error);
  CHECK_AT_MOST("following error, 1e-7 rad", 20000, worst_error);
  CHECK_AT_MOST("farthest, rad", 0.7 + 1e-4, farthest_rad);
  CHECK_NEAR("position, rad", 0.7, n.b.turns * 6.283185307179586, 1e-5);
}

static void test_modes_change_on_the_moving_axis_without_a_step_of_the_torque(void) {
  node n = node_enabled(DRIVE_PROFILE_VELOCITY);
  n.b.load_nm = 3.0;
  n.o.velocity.target = 200000;
  n.o.torque.target = 75; /* 3 Nm: holds the load */
  n.o.torque.slope_per_s = 500;
  node_ticks(&n, 2000);
  const int8_t modes[] = {DRIVE_CYCLIC_TORQUE,   DRIVE_CYCLIC_VELOCITY, DRIVE_CYCLIC_POSITION, DRIVE_PROFILE_VELOCITY,
                          DRIVE_CYCLIC_VELOCITY, DRIVE_CYCLIC_TORQUE,   DRIVE_PROFILE_VELOCITY};
  n.b.worst_step_nm = 0.0;
  for (unsigned m = 0; m < sizeof modes / sizeof modes[0]; ++m) {
    n.o.state.mode = modes[m];
    for (int i = 0; i < 500; ++i) {
      n.in.setpoint_arrived = i % 10 == 0;
      if (i % 10 == 0) { /* csp: continues at 0.2 rad/s from the present position of the axis */
        n.o.position.target = i == 0 ? n.o.position.actual + 22000 : n.o.position.target + 20000;
      }
      node_tick(&n);
    }
    CHECK_NEAR("rate, rad/s", 0.2, n.b.rate_rad_s, 2e-3);
  }
  LOG_VALUE("largest step of the torque, Nm of 40", n.b.worst_step_nm);
  CHECK_AT_MOST("largest step of the torque, Nm of 40", 0.4, n.b.worst_step_nm);
}

static void test_one_implausible_sample_is_a_fault_7300_and_stays_one(void) {
  node n = node_enabled(DRIVE_PROFILE_VELOCITY);
  n.o.velocity.target = 100000;
  node_ticks(&n, 500);
  n.b.samples.sensors.gyro_valid = true;
  n.b.samples.sensors.gyro_rad_s = 1e38f;
  node_tick(&n);
  CHECK_SAME("torque in the tick of the sample, Nm", 0.0, n.b.axis.commanded_nm);
  n.b.samples.sensors.gyro_valid = false;
  node_ticks(&n, 200);
  TEST_ASSERT_EQUAL_HEX16(fault_table[FAULT_IMPLAUSIBLE].code, n.o.state.error_code);
  TEST_ASSERT_EQUAL_HEX16(0x08, n.o.state.statusword & 0x4F);
  CHECK_SAME("torque, Nm", 0.0, n.b.axis.commanded_nm);
}

static void test_a_quick_stop_takes_the_torque_away_from_an_axis_that_stands(void) {
  node n = node_enabled(DRIVE_PROFILE_VELOCITY);
  n.o.velocity.threshold = 500;
  n.o.velocity.target = 200000;
  node_ticks(&n, 1500);
  n.o.state.controlword = 0x02;
  double last_rad_s = n.b.rate_rad_s;
  int count = 0;
  while (n.b.command.mode != SERVO_OFF) {
    last_rad_s = n.b.rate_rad_s;
    node_tick(&n);
    TEST_ASSERT_TRUE(++count < 2000);
  }
  LOG_VALUE("rate when the torque goes, mrad/s", 1e3 * last_rad_s);
  LOG_VALUE("ticks to there", count);
  CHECK_AT_MOST("rate, rad/s", 1e-3, fabs(last_rad_s));
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_pv_turns_the_axis_at_1_deg_s);
  RUN_TEST(test_pp_carries_the_axis_along_its_ramp);
  RUN_TEST(test_modes_change_on_the_moving_axis_without_a_step_of_the_torque);
  RUN_TEST(test_one_implausible_sample_is_a_fault_7300_and_stays_one);
  RUN_TEST(test_a_quick_stop_takes_the_torque_away_from_an_axis_that_stands);
  return UNITY_END();
}
