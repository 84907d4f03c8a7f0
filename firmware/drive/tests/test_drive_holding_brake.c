/* SPDX-License-Identifier: Apache-2.0 */
/* The holding brake: alone, and as the drive of an axis commands it. */
#include "drive/holding_brake.h"

#include "drive/drive_axis.h"
#include "support/check.h"

void setUp(void) {}
void tearDown(void) {}

static const float dt_s = 1e-3f;
static const holding_brake_times with_contact = {.release_s = 0.02f, .engage_s = 0.03f, .feedback_used = true};

/* --- the brake --- */

/* A brake whose contact follows its coil after `delay_ticks`; returns the ticks until `done`, or 1000. */
typedef struct {
  holding_brake brake;
  int delay_ticks;
  int left_ticks;
  bool open;
} real_brake;

static void step(real_brake *b, const holding_brake_times *times, bool hold) {
  const bool before = b->brake.coil_on;
  holding_brake_step(&b->brake, times, hold, b->open, dt_s);
  b->left_ticks = before == b->brake.coil_on ? b->left_ticks - 1 : b->delay_ticks;
  b->open = b->left_ticks > 0 ? b->open : b->brake.coil_on;
}

static void test_it_opens_after_its_release_time_and_engages_after_its_engage_time(void) {
  real_brake b = {.delay_ticks = 15};
  step(&b, &with_contact, true);
  TEST_ASSERT_TRUE(b.brake.coil_on && !b.brake.opened);
  int ticks = 0;
  while (!b.brake.opened && ticks < 1000) {
    step(&b, &with_contact, true);
    ++ticks;
  }
  TEST_ASSERT_EQUAL_INT(20, ticks);
  step(&b, &with_contact, false);
  TEST_ASSERT_TRUE(!b.brake.coil_on && !b.brake.opened);
  TEST_ASSERT_TRUE(!holding_brake_has_engaged(&b.brake, &with_contact));
  ticks = 0;
  while (!holding_brake_has_engaged(&b.brake, &with_contact) && ticks < 1000) {
    step(&b, &with_contact, false);
    ++ticks;
  }
  TEST_ASSERT_EQUAL_INT(30, ticks);
  TEST_ASSERT_TRUE(!b.brake.failed);
}

static void test_an_axis_without_a_brake_never_waits(void) {
  const holding_brake_times none = {0};
  holding_brake brake = {0};
  holding_brake_step(&brake, &none, true, false, dt_s);
  TEST_ASSERT_TRUE(brake.coil_on && brake.opened);
  holding_brake_step(&brake, &none, false, false, dt_s);
  TEST_ASSERT_TRUE(holding_brake_has_engaged(&brake, &none));
  for (int i = 0; i < 30000; ++i) {
    holding_brake_step(&brake, &none, i < 15000, false, dt_s);
    TEST_ASSERT_TRUE(!brake.failed);
  }
  TEST_ASSERT_TRUE(holding_brake_has_engaged(&brake, &none));
}

/* Its own time and 100 ms, in both directions. */
static void test_a_contact_that_contradicts_the_coil_is_a_failure(void) {
  holding_brake sticks = {0};
  int ticks = 0;
  while (!sticks.failed && ticks < 1000) {
    holding_brake_step(&sticks, &with_contact, true, false, dt_s);
    ++ticks;
  }
  TEST_ASSERT_INT_WITHIN(2, 121, ticks);
  holding_brake_step(&sticks, &with_contact, true, true, dt_s);
  TEST_ASSERT_TRUE(!sticks.failed);
  ticks = 0;
  while (!sticks.failed && ticks < 1000) {
    holding_brake_step(&sticks, &with_contact, false, true, dt_s);
    ++ticks;
  }
  TEST_ASSERT_INT_WITHIN(2, 131, ticks);
}

/* --- the drive --- */

typedef struct {
  drive_axis axis;
  drive_objects o;
  drive_axis_inputs in;
  servo_axis_command command;
} bench;

static void tick(bench *b) {
  b->command = *drive_axis_step(&b->axis, &b->o, &b->in, dt_s);
  drive_axis_report(&b->axis, &b->o, &b->in, dt_s);
  const drive_machine machine = {0};
  drive_axis_prepare(&b->axis, &b->o, &machine, dt_s);
  b->in.rate_rad_s = servo_mode_closes(b->command.mode) ? b->command.speed.rate_rad_s : 0.0f;
  b->in.reference_rad_s = b->in.rate_rad_s;
  b->in.brake_contact_open = b->in.brake.feedback_used && b->axis.brake.coil_on;
}

static void ticks(bench *b, int count) {
  for (int i = 0; i < count; ++i) {
    tick(b);
  }
}

static bench bench_ready(void) {
  bench b = {0};
  b.o.state.option = drive_options_default();
  b.o.state.mode = DRIVE_CYCLIC_VELOCITY;
  b.o.limit.maximum_velocity = 1000000;
  b.o.limit.acceleration = b.o.limit.deceleration = b.o.limit.quick_stop_deceleration = 5000000;
  b.o.limit.jerk = 500000000;
  b.o.limit.interpolation_period = 1;
  b.o.limit.interpolation_exponent = -3;
  b.o.torque.rated_mnm = 40000;
  b.o.torque.maximum = b.o.torque.positive_limit = b.o.torque.negative_limit = 1000;
  b.o.velocity.threshold = 500;
  b.o.position.following_error_window = UINT32_MAX;
  b.in = (drive_axis_inputs){
      .ready = true, .voltage_present = true, .may_enable = true, .remote = true, .brake = with_contact};
  drive_axis_reset(&b.axis, 0);
  ticks(&b, 2);
  b.o.state.controlword = 0x06;
  ticks(&b, 2);
  b.o.state.controlword = 0x07;
  ticks(&b, 2);
  return b;
}

static void move(bench *b) {
  b->o.velocity.target = 100000;
  b->in.setpoint_arrived = true;
}

static bench bench_moving(void) {
  bench b = bench_ready();
  b.o.state.controlword = 0x0F;
  for (int i = 0; i < 300; ++i) {
    move(&b);
    tick(&b);
  }
  TEST_ASSERT_TRUE(b.axis.brake.coil_on && b.command.speed.rate_rad_s > 0.05f);
  return b;
}

static void test_an_axis_stands_with_torque_until_its_brake_has_opened(void) {
  bench b = bench_ready();
  TEST_ASSERT_TRUE(!b.axis.brake.coil_on);
  b.o.state.controlword = 0x0F;
  for (int i = 0; i < 20; ++i) {
    move(&b);
    tick(&b);
    TEST_ASSERT_TRUE(servo_mode_closes(b.command.mode));
    TEST_ASSERT_TRUE(b.axis.brake.coil_on);
    CHECK_SAME("rate", 0.0, b.command.speed.rate_rad_s);
  }
  for (int i = 0; i < 100; ++i) {
    move(&b);
    tick(&b);
  }
  TEST_ASSERT_TRUE(b.command.speed.rate_rad_s > 0.05f);
}

/* The torque stands while the brake engages: for 30 ms after the stop, and no longer. As the brake takes the load, the
 * axis slips at 10 mrad/s, which is above 606F (0.5 mrad/s): the coil stays off. */
static void expect_engage_before_torque_off(bench *b) {
  int stopping = 0;
  while (b->axis.brake.coil_on && stopping < 1000) {
    tick(b);
    ++stopping;
    TEST_ASSERT_TRUE(servo_mode_closes(b->command.mode));
  }
  TEST_ASSERT_TRUE(stopping > 1 && stopping < 1000);
  CHECK_NEAR("rate", 0.0, b->command.speed.rate_rad_s, 1e-3);
  int held = 0;
  while (servo_mode_closes(b->command.mode) && held < 1000) {
    b->in.rate_rad_s = 0.01f;
    tick(b);
    ++held;
    TEST_ASSERT_TRUE(!b->axis.brake.coil_on);
  }
  TEST_ASSERT_INT_WITHIN(2, 31, held);
}

static void test_a_stop_that_ends_without_torque_waits_for_the_brake(void) {
  bench disabled = bench_moving();
  disabled.o.state.controlword = 0x07;
  expect_engage_before_torque_off(&disabled);
  bench quick = bench_moving();
  quick.o.state.controlword = 0x02;
  expect_engage_before_torque_off(&quick);
  bench fault = bench_moving();
  fault.in.faults = fault_bit(FAULT_HEARTBEAT_LOST);
  expect_engage_before_torque_off(&fault);
  TEST_ASSERT_EQUAL_INT(DRIVE_FAULT, fault.axis.state.power);
}

static void test_a_halt_and_a_quick_stop_that_holds_keep_the_brake_open(void) {
  bench halted = bench_moving();
  halted.o.state.controlword = 0x10F;
  ticks(&halted, 500);
  TEST_ASSERT_TRUE(halted.axis.brake.coil_on && servo_mode_closes(halted.command.mode));
  bench quick = bench_moving();
  quick.o.state.option.quick_stop = 6;
  quick.o.state.controlword = 0x0B;
  ticks(&quick, 500);
  TEST_ASSERT_TRUE(quick.axis.brake.coil_on && servo_mode_closes(quick.command.mode));
}

/* Protection brakes with torque: the brake engages when the axis is at rest, or stays engaged when it coasted. */
static void test_a_protective_stop_ends_with_the_brake_engaged(void) {
  bench b = bench_moving();
  b.in.faults = fault_bit(FAULT_OVER_SPEED);
  b.in.turns = true;
  ticks(&b, 200);
  TEST_ASSERT_EQUAL_INT(SERVO_PROTECTIVE_STOP, b.command.mode);
  TEST_ASSERT_TRUE(b.axis.brake.coil_on);
  b.in.at_rest = true;
  int held = 0;
  while (b.command.mode == SERVO_PROTECTIVE_STOP && held < 1000) {
    tick(&b);
    ++held;
    TEST_ASSERT_TRUE(!b.axis.brake.coil_on);
  }
  TEST_ASSERT_INT_WITHIN(2, 31, held);

  bench coasts = bench_moving();
  coasts.o.state.controlword = 0x00;
  ticks(&coasts, 100);
  coasts.in.faults = fault_bit(FAULT_OVER_SPEED);
  coasts.in.turns = true;
  for (int i = 0; i < 200; ++i) {
    tick(&coasts);
    TEST_ASSERT_EQUAL_INT(SERVO_PROTECTIVE_STOP, coasts.command.mode);
    TEST_ASSERT_TRUE(!coasts.axis.brake.coil_on);
  }
  coasts.in.at_rest = true;
  coasts.in.turns = false;
  ticks(&coasts, 2);
  TEST_ASSERT_EQUAL_INT(SERVO_OFF, coasts.command.mode);
}

/* The bridge cannot be trusted, or shorts the motor without a loop: the brake engages in this tick. */
static void test_the_brake_engages_at_once_where_no_loop_is_closed(void) {
  const fault_id without_loop[] = {FAULT_SAFE_TORQUE_OFF, FAULT_POWER_STAGE, FAULT_ENCODER_JUMP};
  for (unsigned i = 0; i < sizeof without_loop / sizeof without_loop[0]; ++i) {
    bench b = bench_moving();
    b.in.faults = fault_bit(without_loop[i]);
    tick(&b);
    TEST_ASSERT_TRUE(!b.axis.brake.coil_on);
    TEST_ASSERT_TRUE(!servo_mode_closes(b.command.mode));
  }
  bench voltage = bench_moving();
  voltage.o.state.controlword = 0;
  tick(&voltage);
  TEST_ASSERT_TRUE(!voltage.axis.brake.coil_on && voltage.command.mode == SERVO_OFF);
}

static void test_a_brake_that_sticks_stops_the_axis_with_its_own_fault(void) {
  bench b = bench_moving();
  for (int i = 0; i < 1000 && b.axis.state.power != DRIVE_FAULT; ++i) {
    b.in.brake_contact_open = false;
    b.command = *drive_axis_step(&b.axis, &b.o, &b.in, dt_s);
    b.in.rate_rad_s = servo_mode_closes(b.command.mode) ? b.command.speed.rate_rad_s : 0.0f;
    b.in.reference_rad_s = b.in.rate_rad_s;
  }
  TEST_ASSERT_EQUAL_INT(DRIVE_FAULT, b.axis.state.power);
  TEST_ASSERT_EQUAL_INT(FAULT_HOLDING_BRAKE, b.axis.fault);
  TEST_ASSERT_TRUE(!b.axis.brake.coil_on);
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_it_opens_after_its_release_time_and_engages_after_its_engage_time);
  RUN_TEST(test_an_axis_without_a_brake_never_waits);
  RUN_TEST(test_a_contact_that_contradicts_the_coil_is_a_failure);
  RUN_TEST(test_an_axis_stands_with_torque_until_its_brake_has_opened);
  RUN_TEST(test_a_stop_that_ends_without_torque_waits_for_the_brake);
  RUN_TEST(test_a_halt_and_a_quick_stop_that_holds_keep_the_brake_open);
  RUN_TEST(test_a_protective_stop_ends_with_the_brake_engaged);
  RUN_TEST(test_the_brake_engages_at_once_where_no_loop_is_closed);
  RUN_TEST(test_a_brake_that_sticks_stops_the_axis_with_its_own_fault);
  return UNITY_END();
}
