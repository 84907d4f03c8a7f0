/* SPDX-License-Identifier: Apache-2.0 */
/* The whole drive on an ideal axis: an integrator that follows its speed loop exactly, so that only the drive is
 * measured. Written from the view of a client on the bus: objects in, objects out. */
#include "drive/drive_axis.h"

#include <string.h>

#include "support/check.h"
#include "support/random.h"

void setUp(void) {}
void tearDown(void) {}

static const float dt_s = 1e-3f;
static const double rad_per_unit = 6.283185307179586 / 4294967296.0;
static const double inertia_kg_m2 = 20.0;

typedef struct {
  drive_axis axis;
  drive_objects o;
  drive_axis_inputs in;
  drive_machine machine;
  servo_axis_command command;
  double angle_rad;
  double rate_rad_s;
  double held_rad_s; /* keeps the axis from following: a brake */
  bool braked;
  double worst_step_rad_s; /* of the commanded rate from tick to tick */
  double worst_jump_rad;   /* of the commanded position beyond what its rate has moved the axis */
} bench;

static drive_objects objects_default(void) {
  drive_objects o = {0};
  o.state.option = drive_options_default();
  o.position.following_error_window = 100000; /* 10 mrad */
  o.position.following_error_ms = 10;
  o.position.window = 1000;
  o.position.window_ms = 5;
  o.velocity.window = 500;
  o.velocity.window_ms = 5;
  o.velocity.threshold = 500;
  o.velocity.threshold_ms = 5;
  o.torque.rated_mnm = 40000;
  o.torque.maximum = 1000;
  o.torque.positive_limit = 1000;
  o.torque.negative_limit = 1000;
  o.limit.maximum_velocity = 1000000;
  o.limit.profile_velocity = 500000;
  o.limit.acceleration = 2000000;
  o.limit.deceleration = 2000000;
  o.limit.quick_stop_deceleration = 5000000;
  o.limit.jerk = 50000000;
  o.limit.interpolation_period = 10;
  o.limit.interpolation_exponent = -3;
  return o;
}

static angle_turn32 encoder(double rad) { return (angle_turn32)(uint64_t)llrint(rad / rad_per_unit); }

/* From the command to the next tick. */
static void plant(bench *b) {
  const double before_rad_s = b->rate_rad_s;
  const servo_axis_command *c = &b->command;
  double correction_rad = 0.0;
  b->in.torque_demand_nm = 0.0f;
  if (c->mode == SERVO_TORQUE) {
    b->in.torque_demand_nm = c->torque_nm;
    b->rate_rad_s += (double)c->torque_nm / inertia_kg_m2 * 1e-3;
  } else if (c->mode != SERVO_OFF) {
    b->in.torque_demand_nm = (float)inertia_kg_m2 * c->speed.acceleration_rad_s2;
    b->rate_rad_s = (double)c->speed.rate_rad_s + (double)c->speed.acceleration_rad_s2 * 1e-3;
    correction_rad = c->mode == SERVO_POSITION ? (double)angle_difference_rad(c->position, encoder(b->angle_rad)) : 0.0;
    b->worst_jump_rad = fmax(b->worst_jump_rad, fabs(correction_rad));
  }
  if (b->braked) {
    b->rate_rad_s = b->held_rad_s;
    correction_rad = 0.0;
  }
  b->angle_rad += correction_rad + 0.5 * (before_rad_s + b->rate_rad_s) * 1e-3;
  b->in.joint_angle = encoder(b->angle_rad);
  b->in.rate_rad_s = (float)b->rate_rad_s;
  b->in.reference_rad_s = c->speed.rate_rad_s;
  b->in.torque_nm = b->in.torque_demand_nm;
}

static void tick(bench *b) {
  const servo_axis_command last = b->command;
  b->command = *drive_axis_step(&b->axis, &b->o, &b->in, dt_s);
  drive_axis_report(&b->axis, &b->o, &b->in, dt_s);
  drive_axis_prepare(&b->axis, &b->o, &b->machine, dt_s);
  if (last.mode != SERVO_OFF && b->command.mode != SERVO_OFF) {
    b->worst_step_rad_s =
        fmax(b->worst_step_rad_s, fabs((double)b->command.speed.rate_rad_s - (double)last.speed.rate_rad_s));
  }
  b->in.setpoint_arrived = false;
  plant(b);
}

static void ticks(bench *b, int count) {
  for (int i = 0; i < count; ++i) {
    tick(b);
  }
}

static bench bench_off(double angle_rad) {
  bench b = {.o = objects_default(), .angle_rad = angle_rad};
  b.in = (drive_axis_inputs){
      .joint_angle = encoder(angle_rad), .ready = true, .voltage_present = true, .may_enable = true, .remote = true};
  drive_axis_reset(&b.axis, b.in.joint_angle);
  return b;
}

static bench bench_in(int8_t mode) {
  bench b = bench_off(0.25);
  b.o.state.mode = mode;
  const uint16_t words[] = {0x00, 0x06, 0x07, 0x0F};
  for (unsigned i = 0; i < 4; ++i) {
    b.o.state.controlword = words[i];
    ticks(&b, 2);
  }
  TEST_ASSERT_EQUAL_HEX16(0x27, b.o.state.statusword & 0x6F);
  TEST_ASSERT_EQUAL_INT8(mode, b.o.state.mode_display);
  return b;
}

static bool bit(const bench *b, uint16_t mask) { return (b->o.state.statusword & mask) != 0; }

/* Ticks until the bits are as given. */
static int until(bench *b, uint16_t mask, uint16_t value, int limit) {
  int count = 0;
  while ((b->o.state.statusword & mask) != value) {
    tick(b);
    TEST_ASSERT_TRUE(++count < limit);
  }
  return count;
}

static void new_setpoint(bench *b, int32_t target, uint16_t bits) {
  b->o.position.target = target;
  b->o.state.controlword = (uint16_t)(0x1F | bits);
  ticks(b, 2);
  TEST_ASSERT_TRUE(bit(b, DRIVE_STATUS_MODE_12));
  b->o.state.controlword = 0x0F;
  tick(b);
}

/* --- state and modes --- */

static void test_the_axis_is_off_and_reports_its_position_before_it_is_enabled(void) {
  bench b = bench_off(-1.5);
  tick(&b);
  TEST_ASSERT_EQUAL_INT(SERVO_OFF, b.command.mode);
  CHECK_NEAR("position, 1e-7 rad", -15000000, b.o.position.actual, 1);
  TEST_ASSERT_EQUAL_INT32(b.o.position.actual, b.o.position.demand);
  TEST_ASSERT_EQUAL_INT32(0, b.o.position.following_error);
  TEST_ASSERT_EQUAL_HEX16(DRIVE_STATUS_REMOTE | DRIVE_STATUS_VOLTAGE_ENABLED | 0x60, b.o.state.statusword);
}

static void test_every_supported_mode_is_shown_within_a_tick_and_others_leave_the_one_in_force(void) {
  bench b = bench_in(DRIVE_PROFILE_VELOCITY);
  for (int mode = -128; mode < 128; ++mode) {
    const int8_t before = b.o.state.mode_display;
    b.o.state.mode = (int8_t)mode;
    tick(&b);
    const int bit_of_mode = mode > 0 && mode <= 16 ? mode - 1 : mode < 0 && mode >= -16 ? 15 - mode : 31;
    const bool listed = mode == 0 || ((DRIVE_SUPPORTED_MODES >> bit_of_mode) & 1) != 0;
    TEST_ASSERT_EQUAL_INT8(listed ? mode : before, b.o.state.mode_display);
  }
}

static void test_without_a_mode_the_axis_stands_still(void) {
  bench b = bench_in(DRIVE_NO_MODE);
  b.o.velocity.target = 100000;
  ticks(&b, 100);
  TEST_ASSERT_EQUAL_INT(SERVO_SPEED, b.command.mode);
  CHECK_SAME("rate", 0.0, b.command.speed.rate_rad_s);
  TEST_ASSERT_FALSE(bit(&b, DRIVE_STATUS_MODE_12));
}

/* --- profile velocity --- */

static void test_pv_reaches_1_deg_s_and_reads_it_back(void) {
  bench b = bench_in(DRIVE_PROFILE_VELOCITY);
  TEST_ASSERT_TRUE(bit(&b, DRIVE_STATUS_MODE_12)); /* speed is 0 */
  b.o.velocity.target = 17453;
  const int count = until(&b, DRIVE_STATUS_TARGET_REACHED | DRIVE_STATUS_MODE_12, DRIVE_STATUS_TARGET_REACHED, 1000);
  LOG_VALUE("ticks until the target is reached", count);
  ticks(&b, 50);
  TEST_ASSERT_EQUAL_INT32(17453, b.o.velocity.actual);
  TEST_ASSERT_EQUAL_INT32(17453, b.o.velocity.demand);
}

/* 606F is 500e-6 rad/s, for 5 ms. */
static void test_an_axis_moves_from_a_speed_above_606f_on(void) {
  static const int32_t speeds[] = {500, -500, 502, -502};
  for (unsigned i = 0; i < 4; ++i) {
    bench b = bench_in(DRIVE_PROFILE_VELOCITY);
    b.o.velocity.target = speeds[i];
    ticks(&b, 100);
    TEST_ASSERT_EQUAL_INT32(speeds[i], b.o.velocity.actual);
    TEST_ASSERT_EQUAL(i < 2, bit(&b, DRIVE_STATUS_MODE_12)); /* speed is 0 */
  }
}

/* 606D is 500e-6 rad/s: the window's edge is in it. The target is 0.01 rad/s, and something drags the axis along. */
static void test_pv_has_reached_its_target_within_606d(void) {
  static const struct {
    int32_t dragged; /* 1e-6 rad/s */
    bool reached;
  } cases[] = {{9499, false}, {9500, true}, {10500, true}, {10501, false}};
  for (unsigned i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
    bench b = bench_in(DRIVE_PROFILE_VELOCITY);
    b.o.velocity.target = 10000;
    b.braked = true;
    b.held_rad_s = 1e-6 * cases[i].dragged;
    ticks(&b, 100);
    TEST_ASSERT_EQUAL_INT32(cases[i].dragged, b.o.velocity.actual);
    TEST_ASSERT_EQUAL(cases[i].reached, bit(&b, DRIVE_STATUS_TARGET_REACHED));
  }
}

static void test_pv_is_held_to_607f_and_says_so(void) {
  bench b = bench_in(DRIVE_PROFILE_VELOCITY);
  b.o.velocity.target = -3000000;
  ticks(&b, 1500);
  TEST_ASSERT_EQUAL_INT32(-1000000, b.o.velocity.actual);
  TEST_ASSERT_TRUE(bit(&b, DRIVE_STATUS_INTERNAL_LIMIT));
  TEST_ASSERT_FALSE(bit(&b, DRIVE_STATUS_TARGET_REACHED));
}

static void test_pv_stops_at_a_software_position_limit_and_leaves_it_in_the_other_direction(void) {
  bench b = bench_in(DRIVE_PROFILE_VELOCITY);
  b.o.limit.position_minimum = -5000000;
  b.o.limit.position_maximum = 10000000;
  b.o.velocity.target = 800000;
  for (int i = 0; i < 4000; ++i) {
    const double before_rad_s = (double)b.command.speed.rate_rad_s;
    tick(&b);
    CHECK_AT_MOST("position, rad", 1.0 + 1e-6, b.angle_rad);
    if (bit(&b, DRIVE_STATUS_INTERNAL_LIMIT)) {
      CHECK_AT_MOST("rate while it brakes, rad/s", before_rad_s + 1e-7, b.command.speed.rate_rad_s);
    }
  }
  CHECK_NEAR("position, rad", 1.0, b.angle_rad, 2e-6);
  CHECK_AT_MOST("jump of the position, rad", 1e-6, b.worst_jump_rad);
  TEST_ASSERT_EQUAL_INT(SERVO_POSITION, b.command.mode); /* a rate of 0 would drift with the base */
  TEST_ASSERT_TRUE(bit(&b, DRIVE_STATUS_INTERNAL_LIMIT));
  b.o.velocity.target = -800000;
  ticks(&b, 6000);
  CHECK_NEAR("position, rad", -0.5, b.angle_rad, 2e-6);
}

/* The motor surely brakes with 0.5 rad/s^2, 6084 is 2 rad/s^2: the first counts before a limit, the second elsewhere.
 */
static void test_pv_brakes_before_a_limit_with_what_the_motor_surely_has(void) {
  for (int limited = 0; limited <= 1; ++limited) {
    bench b = bench_in(DRIVE_PROFILE_VELOCITY);
    b.machine.torque_nm = 40.0f;
    b.machine.deceleration_rad_s2 = 0.5f / 0.62f; /* ramps use 62 % of it */
    b.o.limit.position_minimum = -50000000;
    b.o.limit.position_maximum = limited ? 10000000 : 50000000;
    b.o.velocity.target = 500000;
    ticks(&b, 500);
    b.o.velocity.target = limited ? 500000 : 100000;
    double hardest_rad_s2 = 0.0;
    for (int ms = 0; ms < 4000; ++ms) {
      tick(&b);
      hardest_rad_s2 = fmax(hardest_rad_s2, -(double)b.command.speed.acceleration_rad_s2);
    }
    CHECK_NEAR("hardest braking, rad/s^2", limited ? 0.5 : 2.0, hardest_rad_s2, 1e-3);
    CHECK_AT_MOST("position, rad", 1.0 + 1e-6, b.angle_rad);
  }
}

/* At rest, half a milliradian before the limit: there is room for a move. */
static void test_pv_goes_on_at_once_after_a_halt_close_to_the_limit(void) {
  bench b = bench_in(DRIVE_PROFILE_VELOCITY);
  b.o.limit.position_minimum = -50000000;
  b.o.limit.position_maximum = 50000000;
  b.o.velocity.target = 1000000;
  ticks(&b, 1000);
  b.o.state.controlword = 0x10F;
  ticks(&b, 1500);
  CHECK_SAME("rate, rad/s", 0.0, b.command.speed.rate_rad_s);
  b.o.limit.position_maximum = b.o.position.actual + 5000;
  tick(&b);
  b.o.state.controlword = 0x0F;
  tick(&b);
  CHECK_AT_LEAST("acceleration, rad/s^2", 0.01, b.command.speed.acceleration_rad_s2);
  ticks(&b, 300);
  CHECK_NEAR("position, counts", b.o.limit.position_maximum, b.o.position.actual, 20);
}

static void test_the_acceleration_given_brings_exactly_the_next_rate(void) {
  bench b = bench_in(DRIVE_PROFILE_VELOCITY);
  b.o.velocity.target = 600000;
  for (int i = 0; i < 800; ++i) {
    const servo_axis_command now = b.command;
    tick(&b);
    const double next = (double)now.speed.rate_rad_s + 1e-3 * (double)now.speed.acceleration_rad_s2;
    CHECK_NEAR("next rate", next, b.command.speed.rate_rad_s, 1e-7);
  }
}

/* The speed loop gets the acceleration with the rate: they must fit while the mode changes, too. */
static void test_a_ramp_goes_on_through_a_change_from_pv_to_pp_without_a_lost_tick(void) {
  bench b = bench_in(DRIVE_PROFILE_VELOCITY);
  b.o.velocity.target = 600000;
  b.o.position.target = 50000000;
  for (int i = 0; i < 300; ++i) {
    if (i == 150) {
      b.o.state.mode = DRIVE_PROFILE_POSITION;
      b.o.state.controlword |= DRIVE_CONTROL_NEW_SETPOINT;
    }
    const servo_axis_command now = b.command;
    tick(&b);
    const double next = (double)now.speed.rate_rad_s + 1e-3 * (double)now.speed.acceleration_rad_s2;
    CHECK_NEAR("next rate", next, b.command.speed.rate_rad_s, 1e-7);
  }
  CHECK_AT_LEAST("rate at the end, rad/s", 0.4, b.command.speed.rate_rad_s);
  CHECK_AT_MOST("jump of the position, rad", 1e-8, b.worst_jump_rad); /* 7 units of the encoder angle */
}

/* pv holds it at a limit, csv leads it away, pv takes it over, then csv again. Each mode comes with its set-point. */
static void test_pv_and_csv_take_an_axis_over_from_each_other_at_its_rate(void) {
  static const struct {
    int8_t mode;
    int32_t target; /* 1e-6 rad/s */
    double first_rad_s;
  } turns[] = {{DRIVE_CYCLIC_VELOCITY, -100000, 0.0},
               {DRIVE_PROFILE_VELOCITY, -300000, -0.1},
               {DRIVE_CYCLIC_VELOCITY, -300000, -0.3}};
  bench b = bench_in(DRIVE_PROFILE_VELOCITY);
  b.o.limit.position_minimum = -50000000;
  b.o.limit.position_maximum = 5000000;
  b.o.velocity.target = 400000;
  ticks(&b, 2000);
  TEST_ASSERT_EQUAL_INT(SERVO_POSITION, b.command.mode);
  for (unsigned i = 0; i < sizeof turns / sizeof turns[0]; ++i) {
    b.o.state.mode = turns[i].mode;
    b.o.velocity.target = turns[i].target;
    for (int ms = 0; ms < 500; ++ms) {
      b.in.setpoint_arrived = ms % 10 == 0;
      tick(&b);
      TEST_ASSERT_EQUAL_INT(SERVO_SPEED, b.command.mode);
      if (ms == 0) {
        CHECK_NEAR("first rate, rad/s", turns[i].first_rad_s, b.command.speed.rate_rad_s, 1e-6);
      }
    }
    CHECK_NEAR("rate, rad/s", 1e-6 * turns[i].target, b.command.speed.rate_rad_s, 1e-6);
  }
}

/* csp stands; its position loop moves the axis back with 0.02 rad/s. */
static void test_pv_and_hm_begin_at_the_speed_that_the_position_loop_has_demanded(void) {
  static const int8_t modes[] = {DRIVE_PROFILE_VELOCITY, DRIVE_HOMING};
  for (unsigned i = 0; i < 2; ++i) {
    bench b = bench_in(DRIVE_CYCLIC_POSITION);
    b.o.position.target = b.o.position.actual;
    b.in.setpoint_arrived = true;
    ticks(&b, 5);
    TEST_ASSERT_EQUAL_INT(SERVO_POSITION, b.command.mode);
    b.in.reference_rad_s = 0.02f;
    b.o.state.mode = modes[i];
    tick(&b);
    TEST_ASSERT_EQUAL_INT(SERVO_SPEED, b.command.mode);
    CHECK_NEAR("rate, rad/s", 0.02, b.command.speed.rate_rad_s, 1e-9);
  }
}

/* --- profile position --- */

static void test_pp_goes_to_its_target_acknowledges_and_arrives_exactly(void) {
  bench b = bench_in(DRIVE_PROFILE_POSITION);
  new_setpoint(&b, 8000000, 0);
  TEST_ASSERT_FALSE(bit(&b, DRIVE_STATUS_MODE_12));
  TEST_ASSERT_FALSE(bit(&b, DRIVE_STATUS_TARGET_REACHED));
  double fastest = 0.0;
  while (!bit(&b, DRIVE_STATUS_TARGET_REACHED)) {
    tick(&b);
    fastest = fmax(fastest, fabs((double)b.o.velocity.actual));
    CHECK_AT_MOST("overshoot, counts", 8000001, b.o.position.actual);
    CHECK_AT_MOST("following error, counts", 1, fabs((double)b.o.position.following_error));
  }
  TEST_ASSERT_EQUAL_INT32(8000000, b.o.position.demand);
  TEST_ASSERT_EQUAL_INT32(8000000, b.o.position.actual);
  CHECK_NEAR("fastest, 1e-6 rad/s", 500000, fastest, 1);
}

static void test_pp_takes_a_waiting_set_point_and_changes_immediately_when_reported(void) {
  bench b = bench_in(DRIVE_PROFILE_POSITION);
  new_setpoint(&b, 4000000, 0);
  new_setpoint(&b, 1000000, DRIVE_CONTROL_RELATIVE);
  TEST_ASSERT_TRUE(bit(&b, DRIVE_STATUS_MODE_12)); /* no room for a third */
  (void)until(&b, DRIVE_STATUS_TARGET_REACHED, DRIVE_STATUS_TARGET_REACHED, 10000);
  TEST_ASSERT_EQUAL_INT32(5000000, b.o.position.actual);
  new_setpoint(&b, 9000000, 0);
  ticks(&b, 200);
  new_setpoint(&b, -3000000, DRIVE_CONTROL_CHANGE_IMMEDIATELY);
  (void)until(&b, DRIVE_STATUS_TARGET_REACHED, DRIVE_STATUS_TARGET_REACHED, 10000);
  TEST_ASSERT_EQUAL_INT32(-3000000, b.o.position.actual);
  CHECK_AT_MOST("largest step of the rate, rad/s", 0.0021, b.worst_step_rad_s);
}

/* RPDO1 carries controlword and mode in one frame. */
static void test_pp_takes_a_set_point_whose_bit_4_rises_with_the_mode(void) {
  const int8_t modes_before[] = {DRIVE_NO_MODE, DRIVE_PROFILE_VELOCITY};
  for (unsigned i = 0; i < sizeof modes_before / sizeof modes_before[0]; ++i) {
    bench b = bench_in(modes_before[i]);
    ticks(&b, 20);
    b.o.position.target = 2000000;
    b.o.state.mode = DRIVE_PROFILE_POSITION;
    b.o.state.controlword |= DRIVE_CONTROL_NEW_SETPOINT;
    ticks(&b, 2);
    TEST_ASSERT_TRUE(bit(&b, DRIVE_STATUS_MODE_12));
    (void)until(&b, DRIVE_STATUS_TARGET_REACHED, DRIVE_STATUS_TARGET_REACHED, 10000);
    TEST_ASSERT_EQUAL_INT32(2000000, b.o.position.actual);
  }
}

static void test_a_bit_4_that_enables_or_was_set_in_another_mode_moves_nothing(void) {
  bench b = bench_in(DRIVE_NO_MODE);
  const int32_t before = b.o.position.actual;
  b.o.position.target = 2000000;
  b.o.state.controlword |= DRIVE_CONTROL_NEW_SETPOINT;
  ticks(&b, 20);
  b.o.state.mode = DRIVE_PROFILE_POSITION;
  ticks(&b, 200);
  TEST_ASSERT_FALSE(bit(&b, DRIVE_STATUS_MODE_12));
  TEST_ASSERT_EQUAL_INT32(before, b.o.position.actual);
  const uint16_t commands[] = {0x0006, 0x0007, 0x001F};
  for (unsigned i = 0; i < sizeof commands / sizeof commands[0]; ++i) {
    b.o.state.controlword = commands[i];
    ticks(&b, 400);
  }
  TEST_ASSERT_FALSE(bit(&b, DRIVE_STATUS_MODE_12));
  TEST_ASSERT_EQUAL_INT32(before, b.o.position.actual);
}

static void test_pp_turns_many_times_round(void) {
  bench b = bench_in(DRIVE_PROFILE_POSITION);
  b.o.limit.maximum_velocity = 20000000;
  b.o.limit.profile_velocity = 20000000;
  b.o.limit.acceleration = 20000000;
  b.o.limit.deceleration = 20000000;
  new_setpoint(&b, 2000000000, 0); /* 31.8 turns */
  (void)until(&b, DRIVE_STATUS_TARGET_REACHED, DRIVE_STATUS_TARGET_REACHED, 30000);
  TEST_ASSERT_EQUAL_INT32(2000000000, b.o.position.actual);
  CHECK_NEAR("true angle, rad", 200.0, b.angle_rad, 1e-6);
}

static const double turn_rad = 6.283185307179586;

/* Of this angle, on the bus: whole ranges of 64 turns less. */
static double wrapped_counts(double angle_rad) {
  return 1e7 * (angle_rad - 64 * turn_rad * round(angle_rad / (64 * turn_rad)));
}

static void check_position(const bench *b) {
  const double counts = wrapped_counts(b->angle_rad);
  const bool at_edge = fabs(fabs(counts) - DRIVE_RANGE_END) < 2.0;
  CHECK_NEAR("6064", at_edge ? fabs(counts) : counts,
             at_edge ? fabs((double)b->o.position.actual) : b->o.position.actual, 1.0);
}

static bench bench_at_turns(int8_t mode, double turns) {
  bench b = bench_in(mode);
  const double whole = round(turns);
  const drive_axis before = b.axis;
  drive_axis_shift(&b.axis, (int)whole);
  const drive_angle by = (drive_angle)whole * (INT64_C(1) << 32);
  TEST_ASSERT_EQUAL_INT64(before.position + by, b.axis.position);
  TEST_ASSERT_EQUAL_INT64(before.setpoint.position + by, b.axis.setpoint.position);
  b.angle_rad = turns * turn_rad; /* in the same revolution, a few degrees on */
  b.o.position.following_error_window = UINT32_MAX;
  b.in.joint_angle = encoder(b.angle_rad);
  b.o.state.controlword = 0x06; /* the axis has moved while it was off */
  ticks(&b, 300);
  b.o.state.controlword = 0x0F;
  b.o.state.mode = mode;
  ticks(&b, 5);
  return b;
}

static void fast(bench *b) {
  b->o.limit.maximum_velocity = 20000000;
  b->o.limit.profile_velocity = 20000000;
  b->o.limit.acceleration = 20000000;
  b->o.limit.deceleration = 20000000;
}

static void test_a_thousand_turns_wrap_by_whole_turns_in_both_directions(void) {
  for (int side = -1; side <= 1; side += 2) {
    bench b = bench_in(DRIVE_PROFILE_VELOCITY);
    fast(&b);
    b.o.velocity.target = side * 20000000;
    while (fabs(b.angle_rad) < 1000 * turn_rad) {
      const double counts = wrapped_counts(b.angle_rad); /* at the tick's begin */
      const bool wrapped = fabs(b.angle_rad) > 32 * turn_rad;
      tick(&b);
      if (fabs(counts) < DRIVE_RANGE_END - 2) {
        CHECK_NEAR("6064", counts, b.o.position.actual, 1.0);
        TEST_ASSERT_EQUAL(wrapped, (b.o.state.statusword & DRIVE_STATUS_WRAPPED) != 0);
      }
    }
    b.o.velocity.target = 0;
    ticks(&b, 3000);
    check_position(&b);
    TEST_ASSERT_EQUAL_INT32(-DRIVE_RANGE_END, b.o.position.range_minimum);
    TEST_ASSERT_EQUAL_INT32(DRIVE_RANGE_END, b.o.position.range_maximum);
  }
}

/* What the axis turned in truth, in every mode that takes positions, wherever it starts. */
static void test_moves_are_as_ordered_after_many_turns(void) {
  static const double starts[] = {0, 33, -33, 34.18, -34.18, 68.4, -68.4, 1000, -1000, 31.99, -31.99};
  for (unsigned i = 0; i < sizeof starts / sizeof starts[0]; ++i) {
    bench b = bench_at_turns(DRIVE_PROFILE_POSITION, starts[i]);
    check_position(&b);
    fast(&b);
    double from_rad = b.angle_rad;
    static const int32_t moves[] = {-1745329, 1745329, 314159265, -628318531};
    for (unsigned k = 0; k < 4; ++k) {
      new_setpoint(&b, moves[k], DRIVE_CONTROL_RELATIVE);
      (void)until(&b, DRIVE_STATUS_TARGET_REACHED, DRIVE_STATUS_TARGET_REACHED, 20000);
      CHECK_NEAR("relative move, rad", 1e-7 * moves[k], b.angle_rad - from_rad, 1.1e-7);
      from_rad = b.angle_rad;
      check_position(&b);
    }
    b.o.position.option = SETPOINT_SHORTER;
    new_setpoint(&b, drive_position_from_angle(drive_angle_wrap(b.axis.position + (INT64_C(3) << 32))), 0);
    (void)until(&b, DRIVE_STATUS_TARGET_REACHED, DRIVE_STATUS_TARGET_REACHED, 20000);
    CHECK_NEAR("3 turns on, rad", 3 * turn_rad, b.angle_rad - from_rad, 2e-7);
    from_rad = b.angle_rad;
    b.o.state.mode = DRIVE_CYCLIC_POSITION;
    b.o.limit.interpolation_period = 1;
    const drive_angle begin = b.axis.position;
    for (int k = 0; k <= 10000; ++k) {
      const double on_rad = k < 9000 ? 1e-3 * k : 9.0;
      b.o.position.target = drive_position_from_angle(drive_angle_wrap(begin + llrint(on_rad / rad_per_unit)));
      b.in.setpoint_arrived = true;
      tick(&b);
    }
    CHECK_NEAR("csp, rad", 9.0, b.angle_rad - from_rad, 2e-7);
    check_position(&b);
  }
}

/* From now on 607D limits the travel, where 6064 has shown the axis; nothing wraps, and nothing moves. */
static void test_a_travel_that_becomes_limited_refers_to_the_position_shown(void) {
  bench b = bench_at_turns(DRIVE_PROFILE_POSITION, 130.0); /* two ranges and two turns */
  const double from_rad = b.angle_rad;
  CHECK_NEAR("6064, turns", 2.0, b.o.position.actual / 62831853.0718, 1e-7);
  b.o.limit.position_minimum = -2100000000; /* 33.4 turns */
  b.o.limit.position_maximum = 2100000000;
  ticks(&b, 100);
  CHECK_NEAR("6064, turns", 2.0, b.o.position.actual / 62831853.0718, 1e-7);
  CHECK_NEAR("moved, rad", 0.0, b.angle_rad - from_rad, 1e-9);
  TEST_ASSERT_EQUAL_INT32(0, b.o.position.range_minimum);
  TEST_ASSERT_EQUAL_INT32(0, b.o.position.range_maximum);
  TEST_ASSERT_EQUAL_HEX16(0, b.o.state.statusword & DRIVE_STATUS_WRAPPED);
  fast(&b);
  new_setpoint(&b, 2090000000, 0);
  (void)until(&b, DRIVE_STATUS_TARGET_REACHED, DRIVE_STATUS_TARGET_REACHED, 20000);
  TEST_ASSERT_EQUAL_INT32(2090000000, b.o.position.actual);
  CHECK_NEAR("moved, rad", 209.0 - 2 * turn_rad, b.angle_rad - from_rad, 3e-7);
}

/* 1e-6 rad/s are 0.7 units of the encoder angle in a tick: what a tick cannot move is kept for the next one. */
static void test_the_slowest_move_of_pp_has_its_rate_exactly(void) {
  bench b = bench_in(DRIVE_PROFILE_POSITION);
  b.o.limit.profile_velocity = 1;
  new_setpoint(&b, 4000000, 0);
  const int32_t start = b.o.position.demand;
  ticks(&b, 20000);
  CHECK_NEAR("moved in 20 s, 1e-7 rad", 200, b.o.position.demand - start, 1);
}

static void test_a_relative_move_after_cst_or_csv_counts_from_where_the_axis_is(void) {
  static const int8_t modes[] = {DRIVE_CYCLIC_TORQUE, DRIVE_CYCLIC_VELOCITY};
  for (unsigned mode = 0; mode < 2; ++mode) {
    bench b = bench_in(modes[mode]);
    for (int i = 0; i < 1000; ++i) {
      b.o.torque.target = i < 500 ? 100 : -100;
      b.o.velocity.target = i < 500 ? 200000 : 0;
      b.in.setpoint_arrived = true;
      tick(&b);
    }
    const int32_t from = b.o.position.actual;
    CHECK_AT_LEAST("moved before, 1e-7 rad", 100000, from - 2500000);
    b.o.state.mode = DRIVE_PROFILE_POSITION;
    tick(&b);
    new_setpoint(&b, 1000000, DRIVE_CONTROL_RELATIVE);
    (void)until(&b, DRIVE_STATUS_TARGET_REACHED, DRIVE_STATUS_TARGET_REACHED, 10000);
    CHECK_NEAR("position, 1e-7 rad", from + 1000000, b.o.position.actual, 1000);
  }
}

static void test_pp_ends_at_the_software_position_limit(void) {
  bench b = bench_in(DRIVE_PROFILE_POSITION);
  b.o.limit.position_minimum = -1000000;
  b.o.limit.position_maximum = 6000000;
  new_setpoint(&b, 9000000, 0);
  TEST_ASSERT_TRUE(bit(&b, DRIVE_STATUS_INTERNAL_LIMIT));
  (void)until(&b, DRIVE_STATUS_TARGET_REACHED, DRIVE_STATUS_TARGET_REACHED, 10000);
  TEST_ASSERT_EQUAL_INT32(6000000, b.o.position.actual);
  TEST_ASSERT_TRUE(bit(&b, DRIVE_STATUS_INTERNAL_LIMIT));
  new_setpoint(&b, 5000000, 0);
  (void)until(&b, DRIVE_STATUS_TARGET_REACHED, DRIVE_STATUS_TARGET_REACHED, 10000);
  TEST_ASSERT_FALSE(bit(&b, DRIVE_STATUS_INTERNAL_LIMIT));
  new_setpoint(&b, -9000000, 0);
  (void)until(&b, DRIVE_STATUS_TARGET_REACHED, DRIVE_STATUS_TARGET_REACHED, 10000);
  TEST_ASSERT_EQUAL_INT32(-1000000, b.o.position.actual);
}

/* The motor surely brakes with 0.5 rad/s^2, 6084 is 2 rad/s^2. A move from 0.5 rad/s that ends within 0.25 rad before
 * the limit must not rely on 6084. */
/* 607D:2 moves below an axis that stands: it stays, beyond its target as limited, and says that it has not reached it.
 */
static void test_a_limit_that_moves_past_a_standing_axis_is_no_target_reached(void) {
  bench b = bench_in(DRIVE_PROFILE_POSITION);
  b.o.limit.position_minimum = -20000000;
  b.o.limit.position_maximum = 20000000;
  new_setpoint(&b, 10000000, 0);
  (void)until(&b, DRIVE_STATUS_TARGET_REACHED, DRIVE_STATUS_TARGET_REACHED, 10000);
  b.o.limit.position_maximum = 5000000;
  ticks(&b, 500);
  CHECK_NEAR("it stays, rad", 1.0, b.angle_rad, 1e-5);
  TEST_ASSERT_FALSE(bit(&b, DRIVE_STATUS_TARGET_REACHED));
  TEST_ASSERT_TRUE(bit(&b, DRIVE_STATUS_INTERNAL_LIMIT));
}

/* 2010:2 is 0.4 rad/s, 607F and 6081 are faster: the demand of pp and csp is no faster than the loop can follow. */
static void test_no_position_demand_is_faster_than_the_position_loop(void) {
  static const int8_t modes[] = {DRIVE_PROFILE_POSITION, DRIVE_CYCLIC_POSITION};
  for (unsigned i = 0; i < 2; ++i) {
    bench b = bench_in(modes[i]);
    b.machine.position_rad_s = 0.4f;
    ticks(&b, 2);
    b.o.position.target = 15000000;
    b.o.state.controlword = 0x1F;
    double fastest_rad_s = 0.0;
    for (int ms = 0; ms < 2000; ++ms) {
      b.in.setpoint_arrived = ms % 10 == 0;
      tick(&b);
      fastest_rad_s = fmax(fastest_rad_s, fabs((double)b.command.speed.rate_rad_s));
    }
    CHECK_NEAR("fastest, rad/s", 0.4, fastest_rad_s, 1e-3);
  }
}

static void test_a_relative_move_from_the_limit_leads_back_at_once(void) {
  bench b = bench_in(DRIVE_PROFILE_POSITION);
  b.o.limit.position_minimum = -1000000;
  b.o.limit.position_maximum = 3000000;
  new_setpoint(&b, 900000, DRIVE_CONTROL_RELATIVE);
  (void)until(&b, DRIVE_STATUS_TARGET_REACHED, DRIVE_STATUS_TARGET_REACHED, 10000);
  TEST_ASSERT_EQUAL_INT32(3000000, b.o.position.actual);
  TEST_ASSERT_TRUE(bit(&b, DRIVE_STATUS_INTERNAL_LIMIT));
  for (int i = 1; i <= 2; ++i) {
    new_setpoint(&b, -200000, DRIVE_CONTROL_RELATIVE);
    TEST_ASSERT_FALSE(bit(&b, DRIVE_STATUS_TARGET_REACHED));
    (void)until(&b, DRIVE_STATUS_TARGET_REACHED, DRIVE_STATUS_TARGET_REACHED, 10000);
    TEST_ASSERT_EQUAL_INT32(3000000 - i * 200000, b.o.position.actual);
    TEST_ASSERT_FALSE(bit(&b, DRIVE_STATUS_INTERNAL_LIMIT));
  }
}

static void test_pp_brakes_with_what_the_motor_surely_has_when_its_target_is_near_the_limit(void) {
  static const struct {
    int32_t limit; /* 0: none */
    int32_t target;
    double braking_rad_s2;
  } cases[] = {{30000000, 29900000, 0.5}, {30000000, 28000000, 0.5}, {30000000, 27000000, 2.0},
               {30000000, 10000000, 2.0}, {0, 28000000, 2.0},        {0, 100000, 2.0}};
  for (unsigned i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
    bench b = bench_in(DRIVE_PROFILE_POSITION);
    b.machine.torque_nm = 40.0f;
    b.machine.deceleration_rad_s2 = 0.5f / 0.62f; /* ramps use 62 % of it */
    b.o.limit.position_minimum = -cases[i].limit;
    b.o.limit.position_maximum = cases[i].limit;
    new_setpoint(&b, cases[i].target, 0);
    double hardest_rad_s2 = 0.0;
    for (int t = 0; t < 20000 && !bit(&b, DRIVE_STATUS_TARGET_REACHED); ++t) {
      tick(&b);
      const float ahead = b.command.speed.rate_rad_s < 0.0f ? -1.0f : 1.0f;
      hardest_rad_s2 = fmax(hardest_rad_s2, -(double)(ahead * b.command.speed.acceleration_rad_s2));
    }
    TEST_ASSERT_EQUAL_INT32(cases[i].target, b.o.position.actual);
    CHECK_NEAR("hardest braking, rad/s^2", cases[i].braking_rad_s2, hardest_rad_s2, 1e-3);
  }
}

/* 607D wider than the hard travel, off, within it, and where the two have nothing in common. */
static void test_no_software_limit_leads_beyond_the_hard_travel(void) {
  static const struct {
    int32_t minimum, maximum; /* 607D */
    int32_t lowest, highest;  /* reached */
  } cases[] = {{-9000000, 9000000, -2000000, 6000000},
               {0, 0, -2000000, 6000000},
               {-1000000, 9000000, -1000000, 6000000},
               {-1000000, 3000000, -1000000, 3000000},
               {7000000, 9000000, -2000000, 6000000}};
  for (unsigned i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
    bench b = bench_in(DRIVE_PROFILE_POSITION);
    b.machine.hard = (drive_travel){-2000000, 6000000};
    b.o.limit.position_minimum = cases[i].minimum;
    b.o.limit.position_maximum = cases[i].maximum;
    new_setpoint(&b, 20000000, 0);
    (void)until(&b, DRIVE_STATUS_TARGET_REACHED, DRIVE_STATUS_TARGET_REACHED, 10000);
    TEST_ASSERT_EQUAL_INT32(cases[i].highest, b.o.position.actual);
    new_setpoint(&b, -20000000, 0);
    (void)until(&b, DRIVE_STATUS_TARGET_REACHED, DRIVE_STATUS_TARGET_REACHED, 10000);
    TEST_ASSERT_EQUAL_INT32(cases[i].lowest, b.o.position.actual);
  }
}

static void test_halt_holds_a_move_and_lets_it_go_on_to_its_target(void) {
  bench b = bench_in(DRIVE_PROFILE_POSITION);
  new_setpoint(&b, 8000000, 0);
  ticks(&b, 300);
  b.o.state.controlword = 0x10F;
  (void)until(&b, DRIVE_STATUS_TARGET_REACHED, DRIVE_STATUS_TARGET_REACHED, 2000); /* with halt: stands still */
  CHECK_SAME("rate", 0, b.o.velocity.demand);
  TEST_ASSERT_FALSE(bit(&b, DRIVE_STATUS_INTERNAL_LIMIT));
  TEST_ASSERT_TRUE(b.o.position.actual < 8000000);
  b.o.state.controlword = 0x0F;
  ticks(&b, 2);
  (void)until(&b, DRIVE_STATUS_TARGET_REACHED, DRIVE_STATUS_TARGET_REACHED, 10000);
  TEST_ASSERT_EQUAL_INT32(8000000, b.o.position.actual);
  CHECK_AT_MOST("largest step of the rate, rad/s", 0.0021, b.worst_step_rad_s);
}

/* --- stops --- */

static int quick_stop_ticks(int16_t option, bench *b) {
  *b = bench_in(DRIVE_PROFILE_VELOCITY);
  b->o.state.option.quick_stop = option;
  b->o.velocity.target = 1000000;
  ticks(b, 1500);
  b->o.state.controlword = 0x02;
  int count = 0;
  while (b->command.speed.rate_rad_s != 0.0f) {
    tick(b);
    ++count;
    TEST_ASSERT_TRUE(count < 5000);
  }
  return count;
}

static void test_quick_stop_brakes_with_6085_and_switches_off_or_stays(void) {
  bench b;
  /* v/a + a/j, and the ticks of the state and of the last set-point */
  CHECK_NEAR("ticks with 6085", 1000.0 / 5.0 + 100.0, quick_stop_ticks(2, &b), 3);
  ticks(&b, 2);
  TEST_ASSERT_EQUAL_HEX16(0x40, b.o.state.statusword & 0x4F);
  TEST_ASSERT_EQUAL_INT(SERVO_OFF, b.command.mode);
  CHECK_NEAR("ticks with 6084", 1000.0 / 2.0 + 40.0, quick_stop_ticks(5, &b), 3);
  ticks(&b, 100);
  TEST_ASSERT_EQUAL_HEX16(0x07, b.o.state.statusword & 0x6F);
  TEST_ASSERT_EQUAL_INT(SERVO_SPEED, b.command.mode);
  b.o.state.controlword = 0x0F;
  ticks(&b, 1000);
  TEST_ASSERT_EQUAL_INT32(1000000, b.o.velocity.actual);
}

static void test_a_fault_brakes_then_switches_off_and_its_code_stays_until_reset(void) {
  bench b = bench_in(DRIVE_PROFILE_VELOCITY);
  b.o.velocity.target = 500000;
  ticks(&b, 1000);
  b.in.faults = fault_bit(FAULT_HEARTBEAT_LOST);
  tick(&b);
  TEST_ASSERT_EQUAL_HEX16(0x0F, b.o.state.statusword & 0x4F);
  TEST_ASSERT_EQUAL_HEX16(0x8130, b.o.state.error_code);
  b.in.faults = 0;
  const int count = until(&b, 0x4F, 0x08, 1000);
  LOG_VALUE("ticks from the fault to standstill and off", count);
  CHECK_NEAR("rate, rad/s", 0.0, b.rate_rad_s, 1e-9);
  TEST_ASSERT_EQUAL_HEX16(0x8130, b.o.state.error_code);
  TEST_ASSERT_EQUAL_INT(SERVO_OFF, b.command.mode);
  b.o.state.controlword = 0x80;
  tick(&b);
  TEST_ASSERT_EQUAL_HEX16(0x40, b.o.state.statusword & 0x4F);
  TEST_ASSERT_EQUAL_HEX16(0, b.o.state.error_code);
}

static void test_samples_that_are_not_finite_cut_the_torque_and_no_nan_comes_out(void) {
  for (int which = 0; which < 4; ++which) {
    bench b = bench_in(DRIVE_PROFILE_VELOCITY);
    b.o.velocity.target = 500000;
    ticks(&b, 500);
    float *const samples[] = {&b.in.rate_rad_s, &b.in.reference_rad_s, &b.in.torque_nm, &b.in.torque_demand_nm};
    *samples[which] = which % 2 == 0 ? NAN : INFINITY;
    b.command = *drive_axis_step(&b.axis, &b.o, &b.in, dt_s);
    drive_axis_report(&b.axis, &b.o, &b.in, dt_s);
    drive_axis_prepare(&b.axis, &b.o, &b.machine, dt_s);
    TEST_ASSERT_EQUAL_INT(SERVO_OFF, b.command.mode);
    TEST_ASSERT_EQUAL_HEX16(fault_table[FAULT_IMPLAUSIBLE].code, b.o.state.error_code);
    TEST_ASSERT_TRUE(isfinite(b.command.speed.rate_rad_s) && isfinite(b.command.torque_nm));
  }
}

static void test_a_blocked_axis_is_a_following_error_and_a_fault(void) {
  bench b = bench_in(DRIVE_PROFILE_POSITION);
  b.braked = true;
  new_setpoint(&b, 12000000, 0);
  const int count = until(&b, 0x4F, 0x0F, 2000);
  LOG_VALUE("ticks from the move to the fault", count);
  TEST_ASSERT_EQUAL_HEX16(fault_table[FAULT_FOLLOWING_ERROR].code, b.o.state.error_code);
  CHECK_AT_LEAST("following error, counts", 100000, b.o.position.following_error);
  (void)until(&b, 0x4F, 0x08, 2000);
}

static void test_an_unmonitored_following_error_is_cut_at_a_quarter_turn(void) {
  bench b = bench_in(DRIVE_PROFILE_POSITION);
  b.o.position.following_error_window = UINT32_MAX;
  b.braked = true;
  new_setpoint(&b, -90000000, 0);
  (void)until(&b, 0x4F, 0x0F, 20000);
  CHECK_NEAR("following error, rad", -1.5708, (double)b.o.position.following_error * 1e-7, 2e-3);
  CHECK_NEAR("6062 less 6064, counts", b.o.position.following_error, b.o.position.demand - b.o.position.actual, 1);
}

/* --- cyclic modes --- */

static void test_csv_interpolates_between_set_points_and_adds_the_offset(void) {
  bench b = bench_in(DRIVE_CYCLIC_VELOCITY);
  for (int i = 0; i < 1000; ++i) {
    if (i % 10 == 0) {
      b.o.velocity.target = 300 * i;
      b.o.velocity.offset = -5000;
      b.in.setpoint_arrived = true;
    }
    tick(&b);
    if (i > 20) {
      CHECK_NEAR("rate, rad/s", 3e-4 * (i - 10) - 5e-3, b.command.speed.rate_rad_s, 1e-7);
      CHECK_NEAR("acceleration, rad/s^2", 0.3, b.command.speed.acceleration_rad_s2, 1e-3);
      TEST_ASSERT_TRUE(bit(&b, DRIVE_STATUS_MODE_12));
      TEST_ASSERT_FALSE(bit(&b, DRIVE_STATUS_INTERNAL_LIMIT));
    }
  }
  b.o.velocity.target = (int32_t)b.o.limit.maximum_velocity + 10000;
  b.in.setpoint_arrived = true;
  ticks(&b, 2);
  TEST_ASSERT_TRUE(bit(&b, DRIVE_STATUS_INTERNAL_LIMIT));
}

static void test_set_points_that_stop_are_held_and_then_the_axis_ramps_down(void) {
  const int8_t modes[] = {DRIVE_CYCLIC_POSITION, DRIVE_CYCLIC_VELOCITY, DRIVE_CYCLIC_TORQUE};
  for (int m = 0; m < 3; ++m) {
    bench b = bench_in(modes[m]);
    b.o.torque.target = 100;
    const int32_t start = b.o.position.actual;
    for (int i = 0; i <= 500; ++i) {
      if (i % 10 == 0) {
        b.o.position.target = start + 2000 * i;
        b.o.velocity.target = 200000;
        b.in.setpoint_arrived = true;
      }
      tick(&b);
    }
    const double rate_rad_s = b.rate_rad_s;
    CHECK_AT_LEAST("rate, rad/s", 0.09, rate_rad_s);
    ticks(&b, 28);
    TEST_ASSERT_TRUE(bit(&b, DRIVE_STATUS_MODE_12));
    CHECK_AT_LEAST("rate held, rad/s", rate_rad_s - 1e-3, b.rate_rad_s);
    b.worst_step_rad_s = 0.0;
    ticks(&b, 5);
    TEST_ASSERT_FALSE(bit(&b, DRIVE_STATUS_MODE_12));
    ticks(&b, 400);
    CHECK_NEAR("rate, rad/s", 0.0, b.rate_rad_s, 1e-6);
    CHECK_AT_MOST("largest step of the rate, rad/s", m == 2 ? 0.2 : 0.0021, b.worst_step_rad_s);
    TEST_ASSERT_EQUAL_HEX16(0x27, b.o.state.statusword & 0x6F);
    b.in.setpoint_arrived = true; /* they come back */
    b.o.position.target = b.o.position.actual;
    ticks(&b, 5);
    TEST_ASSERT_TRUE(bit(&b, DRIVE_STATUS_MODE_12));
  }
}

/* 60C2 from 10 ms to 100 ms, by its exponent and by its value: set-points may then be missing for 300 ms. */
static void test_a_longer_period_of_60c2_holds_set_points_longer(void) {
  static const struct {
    uint8_t period;
    int8_t exponent;
  } periods[] = {{10, -2}, {100, -3}};
  for (unsigned i = 0; i < 2; ++i) {
    bench b = bench_in(DRIVE_CYCLIC_VELOCITY);
    b.o.velocity.target = 100000;
    for (int ms = 0; ms < 100; ++ms) {
      b.in.setpoint_arrived = ms % 10 == 0;
      tick(&b);
    }
    b.o.limit.interpolation_period = periods[i].period;
    b.o.limit.interpolation_exponent = periods[i].exponent;
    b.in.setpoint_arrived = true;
    ticks(&b, 298);
    TEST_ASSERT_TRUE(bit(&b, DRIVE_STATUS_MODE_12));
    CHECK_NEAR("rate held, rad/s", 0.1, b.rate_rad_s, 1e-6);
    ticks(&b, 5);
    TEST_ASSERT_FALSE(bit(&b, DRIVE_STATUS_MODE_12));
  }
}

/* 60C2 = 200 s and 0 s, which a dictionary refuses: each tick is a period. */
static void test_a_period_that_cannot_be_is_one_tick(void) {
  static const uint8_t periods_s[] = {200, 0};
  for (unsigned i = 0; i < 2; ++i) {
    bench b = bench_in(DRIVE_NO_MODE);
    b.o.limit.interpolation_period = periods_s[i];
    b.o.limit.interpolation_exponent = 0;
    b.o.state.mode = DRIVE_CYCLIC_VELOCITY;
    for (int ms = 0; ms < 100; ++ms) {
      b.o.velocity.target = 1000 * ms;
      b.in.setpoint_arrived = true;
      tick(&b);
      CHECK_NEAR("rate, rad/s", 1e-3 * (ms > 0 ? ms - 1 : 0), b.command.speed.rate_rad_s, 1e-7);
    }
  }
}

/* The turn of the encoder is found under way: the axis stops where it is, a turn farther. */
static void test_a_move_ends_when_the_axis_is_found_on_another_turn(void) {
  bench b = bench_in(DRIVE_PROFILE_POSITION);
  new_setpoint(&b, 50000000, 0);
  ticks(&b, 300);
  const int32_t before = b.o.position.actual;
  drive_axis_shift(&b.axis, 1);
  b.angle_rad += turn_rad;
  tick(&b);
  CHECK_NEAR("moved on, counts", before + 62831853, b.o.position.actual, 10000);
  CHECK_NEAR("following error, counts", 0, b.o.position.following_error, 5);
  ticks(&b, 1500);
  CHECK_SAME("rate, rad/s", 0.0, b.command.speed.rate_rad_s);
  CHECK_NEAR("path of the stop, counts", before + 62831853, b.o.position.actual, 2000000);
}

/* Found between a tick and the preparation of the next one, one turn higher. The axis turns down with 0.3 rad/s; the
 * lower end of its travel, at -1 rad, is farther away than before. */
static void test_pv_goes_on_when_the_axis_is_found_on_another_turn(void) {
  bench b = bench_in(DRIVE_PROFILE_VELOCITY);
  b.o.limit.position_minimum = -10000000;
  b.o.limit.position_maximum = 1000000000;
  b.o.velocity.target = -300000;
  ticks(&b, 500);
  b.command = *drive_axis_step(&b.axis, &b.o, &b.in, dt_s);
  drive_axis_report(&b.axis, &b.o, &b.in, dt_s);
  drive_axis_shift(&b.axis, 1);
  drive_axis_prepare(&b.axis, &b.o, &b.machine, dt_s);
  b.angle_rad += turn_rad;
  plant(&b);
  for (int ms = 0; ms < 10; ++ms) {
    tick(&b);
    CHECK_NEAR("rate, rad/s", -0.3, b.command.speed.rate_rad_s, 1e-6);
    CHECK_SAME("acceleration, rad/s^2", 0.0, b.command.speed.acceleration_rad_s2);
  }
}

static void test_an_axis_that_is_held_stays_when_it_is_found_on_another_turn(void) {
  bench b = bench_in(DRIVE_PROFILE_VELOCITY);
  b.o.limit.position_minimum = -1000000000;
  b.o.limit.position_maximum = 3000000;
  b.o.velocity.target = 500000;
  ticks(&b, 2000);
  b.o.velocity.target = 0;
  b.o.limit.position_maximum = 1000000000;
  ticks(&b, 10);
  TEST_ASSERT_EQUAL_INT(SERVO_POSITION, b.command.mode);
  drive_axis_shift(&b.axis, 1);
  b.angle_rad += turn_rad;
  for (int ms = 0; ms < 100; ++ms) {
    tick(&b);
    CHECK_NEAR("6064, counts", 3000000 + 62831853, b.o.position.actual, 30);
    CHECK_NEAR("following error, counts", 0, b.o.position.following_error, 5);
  }
}

static void test_csp_follows_a_parabola_one_period_late_with_position_and_rate(void) {
  bench b = bench_in(DRIVE_CYCLIC_POSITION);
  const double start = 0.25;
  for (int i = 0; i < 1000; ++i) {
    if (i % 5 == 0) {
      b.o.limit.interpolation_period = 5;
      b.o.position.target = (int32_t)lrint(1e7 * (start + 0.1 * (i * 1e-3) * (i * 1e-3)));
      b.in.setpoint_arrived = true;
    }
    tick(&b);
    if (i > 20) {
      const double then_s = (i - 5) * 1e-3;
      CHECK_NEAR("demand, counts", 1e7 * (start + 0.1 * then_s * then_s), b.o.position.demand, 2);
      CHECK_NEAR("rate, rad/s", 0.2 * then_s, b.command.speed.rate_rad_s, 1e-4);
      CHECK_AT_MOST("following error, counts", 5, fabs((double)b.o.position.following_error));
    }
  }
}

static void test_csp_does_not_move_before_its_first_set_point_whatever_607a_was(void) {
  bench b = bench_in(DRIVE_CYCLIC_POSITION);
  b.o.position.target = 9000000;
  ticks(&b, 200);
  TEST_ASSERT_EQUAL_INT32(2500000, b.o.position.actual);
  TEST_ASSERT_FALSE(bit(&b, DRIVE_STATUS_MODE_12));
  TEST_ASSERT_FALSE(bit(&b, DRIVE_STATUS_TARGET_REACHED)); /* it has none */
}

/* One frame carries the mode and its first set-point, 1 mrad ahead of an axis that moves. */
/* 607A still holds what it held before csv, and csv has had its set-points until now. */
static void test_csp_after_csv_does_not_move_before_its_first_set_point(void) {
  bench b = bench_in(DRIVE_CYCLIC_VELOCITY);
  b.o.position.target = 20000000;
  for (int ms = 0; ms < 100; ++ms) {
    b.in.setpoint_arrived = ms % 10 == 0;
    tick(&b);
  }
  b.o.state.mode = DRIVE_CYCLIC_POSITION;
  for (int ms = 0; ms < 100; ++ms) {
    tick(&b);
    TEST_ASSERT_FALSE(bit(&b, DRIVE_STATUS_MODE_12));
    CHECK_SAME("rate, rad/s", 0.0, b.command.speed.rate_rad_s);
  }
}

/* Until the turn of the encoder is known, a position means nothing, and a speed what it always means. */
static void test_an_unknown_position_stops_the_modes_of_positions_alone(void) {
  static const int8_t modes[] = {DRIVE_PROFILE_VELOCITY, DRIVE_CYCLIC_VELOCITY, DRIVE_PROFILE_POSITION,
                                 DRIVE_CYCLIC_POSITION};
  for (unsigned i = 0; i < 4; ++i) {
    bench b = bench_in(modes[i]);
    b.machine.position_unknown = true;
    ticks(&b, 2);
    b.o.velocity.target = 100000;
    b.o.position.target = 20000000;
    b.o.state.controlword = 0x1F;
    for (int ms = 0; ms < 500; ++ms) {
      b.in.setpoint_arrived = ms % 10 == 0;
      tick(&b);
    }
    CHECK_NEAR("rate, rad/s", i < 2 ? 0.1 : 0.0, b.rate_rad_s, 1e-6);
    TEST_ASSERT_EQUAL(i >= 2, bit(&b, DRIVE_STATUS_INTERNAL_LIMIT));
  }
}

/* As the torque of cst: none at 1.1 times the limit of the speed. */
static void test_at_an_unknown_position_the_torque_offset_speeds_up_no_axis(void) {
  for (int unknown = 0; unknown < 2; ++unknown) {
    bench b = bench_in(DRIVE_CYCLIC_VELOCITY);
    b.machine.position_unknown = unknown != 0;
    b.o.torque.offset = 100;
    b.o.velocity.target = 10000000;
    for (int ms = 0; ms < 3000; ++ms) {
      b.in.setpoint_arrived = true;
      tick(&b);
    }
    const double full_nm = (double)drive_torque_from_permille(100, b.o.torque.rated_mnm);
    CHECK_NEAR("offset at the limit, N m", full_nm, b.command.torque_nm, 1e-3 * full_nm);
    b.in.rate_rad_s = 1.2f * b.command.speed.rate_rad_s;
    tick(&b);
    CHECK_NEAR("beyond it, N m", unknown != 0 ? 0.0 : full_nm, b.command.torque_nm, 1e-3 * full_nm);
  }
}

/* Nothing is prepared for a tick that changes the mode. */
static void test_a_mode_that_changes_in_each_tick_stops_the_axis(void) {
  bench b = bench_in(DRIVE_PROFILE_VELOCITY);
  b.o.velocity.target = 1000000;
  ticks(&b, 100);
  const float begun_rad_s = b.command.speed.rate_rad_s;
  TEST_ASSERT_TRUE(begun_rad_s > 0.0f);
  b.o.velocity.target = 0;
  for (int ms = 0; ms < 1000; ++ms) {
    b.o.state.mode = ms % 2 == 0 ? DRIVE_HOMING : DRIVE_PROFILE_VELOCITY;
    tick(&b);
    CHECK_AT_MOST("rate, rad/s", (double)begun_rad_s + 0.05, b.command.speed.rate_rad_s);
  }
  CHECK_SAME("rate, rad/s", 0.0, b.command.speed.rate_rad_s);
}

static void test_csp_holds_a_position_from_the_tick_in_which_it_is_entered(void) {
  static const int8_t modes_before[] = {DRIVE_PROFILE_VELOCITY, DRIVE_CYCLIC_VELOCITY, DRIVE_CYCLIC_TORQUE};
  for (unsigned i = 0; i < sizeof modes_before / sizeof modes_before[0]; ++i) {
    bench b = bench_in(modes_before[i]);
    b.o.velocity.target = 100000;
    b.o.torque.target = 100;
    for (int ms = 0; ms < 500; ++ms) {
      b.in.setpoint_arrived = true;
      tick(&b);
    }
    TEST_ASSERT_NOT_EQUAL_INT(SERVO_POSITION, b.command.mode);
    b.o.state.mode = DRIVE_CYCLIC_POSITION;
    b.o.position.target = b.o.position.actual + 10000;
    b.in.setpoint_arrived = true;
    tick(&b);
    TEST_ASSERT_EQUAL_INT(SERVO_POSITION, b.command.mode);
    CHECK_AT_MOST("jump of the position, rad", 1e-6, b.worst_jump_rad);
  }
}

static void test_csp_approaches_a_far_set_point_at_607f_and_stays_inside_607d(void) {
  bench b = bench_in(DRIVE_CYCLIC_POSITION);
  b.o.limit.position_minimum = -1000000;
  b.o.limit.position_maximum = 5000000;
  b.o.position.following_error_window = UINT32_MAX;
  b.o.velocity.offset = 700000; /* rate offset, limited with the rest */
  for (int i = 0; i < 1000; ++i) {
    b.o.position.target = 9000000;
    b.in.setpoint_arrived = i % 10 == 0;
    tick(&b);
    CHECK_AT_MOST("rate, rad/s", 1.0 + 1e-6, fabs((double)b.command.speed.rate_rad_s));
    TEST_ASSERT_TRUE(bit(&b, DRIVE_STATUS_INTERNAL_LIMIT));
  }
  CHECK_NEAR("demand, counts", 5000000, b.o.position.demand, 20000);
}

/* The master does not brake. The motor surely brakes with 0.5 rad/s^2. */
static void test_csp_brakes_before_the_limit_when_its_set_points_do_not(void) {
  for (int side = -1; side <= 1; side += 2) {
    bench b = bench_in(DRIVE_CYCLIC_POSITION);
    b.machine.torque_nm = 40.0f;
    b.machine.deceleration_rad_s2 = 0.5f / 0.62f; /* ramps use 62 % of it */
    b.o.limit.position_minimum = -10000000;
    b.o.limit.position_maximum = 10000000;
    b.o.position.following_error_window = UINT32_MAX;
    double moved_before_rad = 0.0;
    double hardest_rad_s2 = 0.0;
    double farthest_rad_s = 0.0;
    for (int i = 0; i < 6000; ++i) {
      b.in.setpoint_arrived = i % 10 == 0;
      if (b.in.setpoint_arrived) { /* up to 0.4 rad/s in a second, then on */
        const double travel_rad = i < 1000 ? 0.2e-6 * i * i : 0.4e-3 * i - 0.2;
        b.o.position.target = 2500000 + (int32_t)lrint(side * 1e7 * travel_rad);
      }
      const int32_t before = b.o.position.demand;
      tick(&b);
      const double moved_rad = 1e-7 * side * (double)(b.o.position.demand - before);
      hardest_rad_s2 = fmax(hardest_rad_s2, i > 20 ? 1e6 * (moved_before_rad - moved_rad) : 0.0);
      moved_before_rad = moved_rad;
      if (i > 20) { /* the rate is the demand's, also while it is held back */
        const double behind_rad_s = fabs(1e3 * moved_rad - side * (double)b.command.speed.rate_rad_s);
        farthest_rad_s = fmax(farthest_rad_s, behind_rad_s);
      }
      CHECK_AT_MOST("position, rad", 1.0 + 1e-6, side * b.angle_rad);
    }
    CHECK_NEAR("position, rad", side * 1.0, b.angle_rad, 1e-3);
    CHECK_AT_MOST("hardest braking of the demand, rad/s^2", 1.2, hardest_rad_s2); /* a stop at once: 400 */
    LOG_VALUE("largest difference between commanded rate and demand, rad/s", farthest_rad_s);
    CHECK_AT_MOST("difference between commanded rate and demand, rad/s", 0.01, farthest_rad_s);
    TEST_ASSERT_TRUE(bit(&b, DRIVE_STATUS_INTERNAL_LIMIT));
  }
}

static void test_csp_reports_a_rate_offset_beyond_607f_as_limited(void) {
  for (int side = -1; side <= 1; side += 2) {
    bench b = bench_in(DRIVE_CYCLIC_POSITION);
    b.o.position.following_error_window = UINT32_MAX;
    b.o.position.target = b.o.position.actual;
    b.in.setpoint_arrived = true;
    tick(&b);
    TEST_ASSERT_FALSE(bit(&b, DRIVE_STATUS_INTERNAL_LIMIT));
    b.o.velocity.offset = side * 1100000;
    tick(&b);
    TEST_ASSERT_TRUE(bit(&b, DRIVE_STATUS_INTERNAL_LIMIT));
    CHECK_SAME("rate, rad/s", side * 1.0, b.command.speed.rate_rad_s);
  }
}

static void test_csv_stops_before_a_position_limit_and_stays_there_until_turned_round(void) {
  for (int side = -1; side <= 1; side += 2) {
    bench b = bench_in(DRIVE_CYCLIC_VELOCITY);
    b.o.limit.position_minimum = -5000000;
    b.o.limit.position_maximum = 10000000;
    b.o.velocity.target = side * 700000;
    for (int i = 0; i < 4000; ++i) {
      const servo_axis_command now = b.command;
      b.in.setpoint_arrived = i % 10 == 0;
      tick(&b);
      if (b.command.mode == SERVO_SPEED) {
        const double next_rad_s = (double)now.speed.rate_rad_s + 1e-3 * (double)now.speed.acceleration_rad_s2;
        CHECK_NEAR("rate that the acceleration brings, rad/s", next_rad_s, b.command.speed.rate_rad_s, 1e-6);
      }
      CHECK_AT_MOST("beyond the limit, rad", 1e-3, side > 0 ? b.angle_rad - 1.0 : -0.5 - b.angle_rad);
    }
    CHECK_NEAR("before the limit, rad", 0.0, side > 0 ? 1.0 - b.angle_rad : b.angle_rad + 0.5, 1e-5);
    CHECK_NEAR("rate, rad/s", 0.0, b.rate_rad_s, 1e-6);
    TEST_ASSERT_TRUE(bit(&b, DRIVE_STATUS_INTERNAL_LIMIT));
    TEST_ASSERT_FALSE(bit(&b, DRIVE_STATUS_MODE_12));
    b.o.velocity.target = 0; /* no way out: it stays held */
    for (int i = 0; i < 100; ++i) {
      b.in.setpoint_arrived = i % 10 == 0;
      tick(&b);
    }
    TEST_ASSERT_EQUAL_INT(SERVO_POSITION, b.command.mode);
    TEST_ASSERT_TRUE(bit(&b, DRIVE_STATUS_INTERNAL_LIMIT));
    b.o.velocity.target = -side * 100000;
    for (int i = 0; i < 100; ++i) {
      b.in.setpoint_arrived = i % 10 == 0;
      tick(&b);
    }
    CHECK_NEAR("rate, rad/s", -0.1 * side, b.rate_rad_s, 1e-5);
  }
}

/* A rate of 0 refers to inertial space: the base has turned the axis 0.1 rad out of its travel. */
static void test_csv_with_rate_0_holds_an_axis_outside_its_travel(void) {
  for (int side = -1; side <= 1; side += 2) {
    bench b = bench_in(DRIVE_CYCLIC_VELOCITY);
    b.o.limit.position_minimum = -10000000;
    b.o.limit.position_maximum = 10000000;
    for (int ms = 0; ms < 100; ++ms) {
      b.in.setpoint_arrived = ms % 10 == 0;
      tick(&b);
    }
    TEST_ASSERT_EQUAL_INT(SERVO_SPEED, b.command.mode);
    TEST_ASSERT_FALSE(bit(&b, DRIVE_STATUS_INTERNAL_LIMIT));
    b.angle_rad = 1.1 * side;
    b.in.joint_angle = encoder(b.angle_rad);
    tick(&b);
    TEST_ASSERT_EQUAL_INT(SERVO_POSITION, b.command.mode);
    TEST_ASSERT_EQUAL_HEX32(encoder(1.1 * side), b.command.position);
    TEST_ASSERT_TRUE(bit(&b, DRIVE_STATUS_INTERNAL_LIMIT));
  }
}

/* A master that brakes by itself in front of a limit is still obeyed: the drive takes over only where it must. */
static void test_csv_obeys_a_lower_rate_while_it_brakes_before_a_limit(void) {
  bench b = bench_in(DRIVE_CYCLIC_VELOCITY);
  b.o.limit.position_minimum = -5000000;
  b.o.limit.position_maximum = 10000000;
  b.o.velocity.target = 700000;
  for (int i = 0; i < 4000 && (i < 200 || b.rate_rad_s > 0.5); ++i) {
    b.in.setpoint_arrived = i % 10 == 0;
    tick(&b);
  }
  b.o.velocity.target = 100000;
  for (int i = 0; i < 100; ++i) {
    b.in.setpoint_arrived = i % 10 == 0;
    tick(&b);
  }
  CHECK_NEAR("rate, rad/s", 0.1, b.rate_rad_s, 1e-4);
  TEST_ASSERT_TRUE(bit(&b, DRIVE_STATUS_MODE_12));
}

static void test_cst_gives_target_and_offset_along_the_slope(void) {
  bench b = bench_in(DRIVE_CYCLIC_TORQUE);
  b.o.torque.target = 200;
  b.o.torque.offset = 50;
  b.o.torque.slope_per_s = 1000;
  for (int i = 0; i < 300; ++i) {
    b.in.setpoint_arrived = true;
    tick(&b);
    TEST_ASSERT_EQUAL_INT(SERVO_TORQUE, b.command.mode);
    CHECK_NEAR("torque, Nm", fmin(10.0, 0.04 * (i + 1)), b.command.torque_nm, 1e-4);
  }
  TEST_ASSERT_EQUAL_INT16(250, b.o.torque.actual);
  TEST_ASSERT_EQUAL_INT16(250, b.o.torque.demand);
  TEST_ASSERT_EQUAL_INT32(b.o.position.actual, b.o.position.demand);
  CHECK_NEAR("limit", 40.0, b.command.limits.maximum_nm, 1e-5);
}

static void test_cst_is_stopped_by_the_position_limit_and_held(void) {
  bench b = bench_in(DRIVE_CYCLIC_TORQUE);
  b.o.limit.position_minimum = -5000000;
  b.o.limit.position_maximum = 10000000;
  b.o.torque.target = 300;
  for (int i = 0; i < 4000; ++i) {
    b.in.setpoint_arrived = true;
    tick(&b);
    CHECK_AT_MOST("position, rad", 1.0 + 2e-3, b.angle_rad);
  }
  CHECK_NEAR("rate, rad/s", 0.0, b.rate_rad_s, 1e-6);
  TEST_ASSERT_EQUAL_INT(SERVO_POSITION, b.command.mode); /* held */
  b.o.torque.target = -10;
  b.in.setpoint_arrived = true;
  tick(&b);
  TEST_ASSERT_EQUAL_INT(SERVO_TORQUE, b.command.mode);
}

static void test_cst_at_full_torque_stops_within_the_travel(void) {
  for (int side = -1; side <= 1; side += 2) {
    bench b = bench_in(DRIVE_CYCLIC_TORQUE);
    b.o.limit.position_minimum = -5000000;
    b.o.limit.position_maximum = 10000000;
    b.o.limit.maximum_velocity = 3000000;
    b.o.limit.jerk = 4000000000u;
    b.o.torque.target = (int16_t)(side * 1000);
    double farthest_rad = -10.0;
    for (int i = 0; i < 4000; ++i) {
      b.in.setpoint_arrived = true;
      tick(&b);
      farthest_rad = fmax(farthest_rad, side > 0 ? b.angle_rad - 1.0 : -0.5 - b.angle_rad);
    }
    CHECK_NEAR("farthest, rad beyond the limit", -1e-3, farthest_rad, 0.9e-3);
    CHECK_NEAR("rate, rad/s", 0.0, b.rate_rad_s, 1e-6);
  }
}

/* Something strikes the standing axis 45 mrad before its limit: 0.4 rad/s within a ms. The gentle stop (6084 with 60A4)
 * would take 48 mrad, so the braking begins without a gentle start, and in this tick. */
static void test_cst_brakes_an_axis_that_is_struck_before_its_limit_at_once(void) {
  bench b = bench_in(DRIVE_CYCLIC_TORQUE);
  b.o.limit.position_minimum = -10000000;
  b.o.limit.position_maximum = 2500000 + 450000;
  b.o.torque.target = 1;
  for (int ms = 0; ms < 10; ++ms) {
    b.in.setpoint_arrived = true;
    tick(&b);
    TEST_ASSERT_EQUAL_INT(SERVO_TORQUE, b.command.mode);
  }
  b.rate_rad_s = 0.4;
  b.in.rate_rad_s = 0.4f;
  b.in.setpoint_arrived = true;
  tick(&b);
  CHECK_NEAR("rate, rad/s", 0.4, b.command.speed.rate_rad_s, 1e-6);
  CHECK_AT_MOST("acceleration, rad/s^2", -1.0, b.command.speed.acceleration_rad_s2);
  for (int ms = 0; ms < 1000; ++ms) {
    b.in.setpoint_arrived = true;
    tick(&b);
    CHECK_AT_MOST("position, rad", 0.295 + 1e-6, b.angle_rad);
  }
  CHECK_SAME("rate, rad/s", 0.0, b.command.speed.rate_rad_s);
}

/* The limits of a motion are known from its first preparation on. */
static void test_cst_gives_no_torque_before_a_limit_of_the_speed_is_known(void) {
  drive_objects o = objects_default();
  o.state.mode = DRIVE_CYCLIC_TORQUE;
  o.torque.target = 500;
  const drive_feedback feedback = {.setpoint_arrived = true};
  const drive_machine machine = {0};
  drive_motion motion = {0};
  drive_motion_reset(&motion, 0);
  const drive_setpoint before = drive_motion_step(&motion, &o, DRIVE_RUN, &feedback, dt_s);
  TEST_ASSERT_EQUAL_INT(SERVO_TORQUE, before.command.mode);
  CHECK_SAME("torque, Nm", 0.0, before.command.torque_nm);
  drive_motion_prepare(&motion, &o, &machine, dt_s);
  const drive_setpoint after = drive_motion_step(&motion, &o, DRIVE_RUN, &feedback, dt_s);
  CHECK_NEAR("torque, Nm", 20.0, after.command.torque_nm, 1e-4);
}

/* A held axis: the ramp of pv turned away from the limit, the axis did not. What counts is the axis. */
static void test_cst_is_not_blocked_by_the_rate_that_the_mode_before_has_demanded(void) {
  bench b = bench_in(DRIVE_PROFILE_VELOCITY);
  b.o.limit.position_minimum = -50000000;
  b.o.limit.position_maximum = 3500000; /* 0.1 rad ahead */
  b.braked = true;
  b.o.velocity.target = -1000000;
  ticks(&b, 800);
  TEST_ASSERT_EQUAL_INT32(b.o.position.actual, b.o.position.demand); /* pv has no other */
  b.o.state.mode = DRIVE_CYCLIC_TORQUE;
  b.o.torque.target = 100;
  for (int i = 0; i < 5; ++i) {
    b.in.setpoint_arrived = true;
    tick(&b);
    TEST_ASSERT_EQUAL_INT(SERVO_TORQUE, b.command.mode);
    CHECK_SAME("rate with which the speed loop follows, rad/s", 0.0, b.command.speed.rate_rad_s);
  }
}

/* --- an experiment */

static void test_an_experiment_moves_the_axis_within_its_limits_and_ends_at_them(void) {
  static const struct {
    servo_mode mode;
    double position_rad, rate_rad_s;
    bool obeyed;
  } cases[] = {{SERVO_POSITION, 0.26, 0.0, true},   {SERVO_POSITION, 1.01, 0.0, false},
               {SERVO_POSITION, -0.51, 0.0, false}, {SERVO_SPEED, 2.0, 0.5, true},
               {SERVO_SPEED, 2.0, 1.2, true},       {SERVO_TORQUE, 2.0, 0.0, true}};
  for (unsigned i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
    bench b = bench_in(DRIVE_NO_MODE);
    b.o.limit.position_minimum = -5000000;
    b.o.limit.position_maximum = 10000000;
    ticks(&b, 3);
    const servo_axis_command stimulus = {.mode = cases[i].mode,
                                         .position = encoder(cases[i].position_rad),
                                         .speed = {.rate_rad_s = (float)cases[i].rate_rad_s},
                                         .torque_nm = 2.0f};
    b.in.stimulus = &stimulus;
    TEST_ASSERT_TRUE(drive_axis_obeys_stimulus(&b.axis));
    tick(&b);
    TEST_ASSERT_EQUAL_INT(cases[i].obeyed, drive_axis_obeys_stimulus(&b.axis));
    TEST_ASSERT_FALSE(bit(&b, DRIVE_STATUS_MODE_12)); /* no mode, so no meaning */
    if (cases[i].obeyed) {
      TEST_ASSERT_EQUAL_INT(cases[i].mode, b.command.mode);
      CHECK_NEAR("rate within 607F, rad/s", fmin(cases[i].rate_rad_s, 1.0), b.command.speed.rate_rad_s, 1e-6);
      CHECK_SAME("torque, Nm", 2.0, b.command.torque_nm);
      TEST_ASSERT_EQUAL_HEX32(stimulus.position, b.command.position);
      const double demand = cases[i].mode == SERVO_POSITION ? 1e7 * cases[i].position_rad : b.o.position.actual;
      CHECK_NEAR("6062", demand, b.o.position.demand, 1);
    } else {
      TEST_ASSERT_TRUE(bit(&b, DRIVE_STATUS_INTERNAL_LIMIT));
      CHECK_SAME("rate, rad/s", 0.0, b.command.speed.rate_rad_s);
    }
  }
}

/* An experiment that ends at 0.3 rad/s, also by its torque, leaves an axis that slows down from there. */
static void test_an_axis_slows_down_from_the_rate_at_which_an_experiment_ends(void) {
  static const servo_mode modes[] = {SERVO_SPEED, SERVO_TORQUE};
  for (unsigned i = 0; i < 2; ++i) {
    bench b = bench_in(DRIVE_NO_MODE);
    const servo_axis_command stimulus = {
        .mode = modes[i], .speed = {.rate_rad_s = modes[i] == SERVO_SPEED ? 0.3f : 0.0f}, .torque_nm = 20.0f};
    b.in.stimulus = &stimulus;
    ticks(&b, 300); /* 20 Nm on 20 kg m2 */
    CHECK_NEAR("rate of the axis, rad/s", 0.3, b.rate_rad_s, 0.002);
    b.in.stimulus = NULL;
    tick(&b);
    CHECK_NEAR("first set-point of the stop, rad/s", 0.3, b.command.speed.rate_rad_s, 0.002);
    ticks(&b, 100); /* 6084: 2 rad/s2, reached at 50 rad/s3 */
    CHECK_NEAR("100 ms later, rad/s", 0.3 - 2.0 * (0.1 - 0.02), b.command.speed.rate_rad_s, 0.004);
  }
}

static void test_no_mode_of_operation_obeys_an_experiment(void) {
  static const int8_t modes[] = {DRIVE_TRACKING,        DRIVE_PROFILE_POSITION, DRIVE_PROFILE_VELOCITY, DRIVE_HOMING,
                                 DRIVE_CYCLIC_POSITION, DRIVE_CYCLIC_VELOCITY,  DRIVE_CYCLIC_TORQUE};
  const servo_axis_command stimulus = {.mode = SERVO_SPEED, .speed = {.rate_rad_s = 0.3f}};
  for (unsigned i = 0; i < sizeof modes / sizeof modes[0]; ++i) {
    bench b = bench_in(modes[i]);
    b.in.stimulus = &stimulus;
    tick(&b);
    TEST_ASSERT_FALSE(drive_axis_obeys_stimulus(&b.axis));
    CHECK_SAME("rate, rad/s", 0.0, b.command.speed.rate_rad_s);
  }
}

/* An experiment leaves the axis at 0.5 rad with 0.2 rad/s: once from rest, once after a broken off move of pp, whose
 * demand has a remainder below its last digit. */
static void test_the_stop_after_an_experiment_is_the_same_whatever_was_before(void) {
  const servo_axis_command stimulus = {.mode = SERVO_POSITION, .position = encoder(0.5), .speed = {.rate_rad_s = 0.2f}};
  angle_turn32 path[200] = {0};
  for (int moved = 0; moved <= 1; ++moved) {
    bench b = bench_in(DRIVE_NO_MODE);
    if (moved != 0) {
      b.o.state.mode = DRIVE_PROFILE_POSITION;
      tick(&b);
      new_setpoint(&b, 9000000, 0);
      ticks(&b, 137);
      b.o.state.mode = DRIVE_NO_MODE;
      ticks(&b, 500);
    }
    b.in.stimulus = &stimulus;
    tick(&b);
    b.in.stimulus = NULL;
    for (int ms = 0; ms < 200; ++ms) {
      tick(&b);
      path[ms] = moved == 0 ? b.command.position : path[ms];
      TEST_ASSERT_EQUAL_HEX32(path[ms], b.command.position);
    }
    CHECK_SAME("rate, rad/s", 0.0, b.command.speed.rate_rad_s);
  }
}

/* 20 Nm on 20 kg m2: after 2 s it would be 2 rad/s; 607F is 1 rad/s. */
static void test_the_torque_of_an_experiment_cannot_drive_the_axis_faster_than_110_percent_of_607f(void) {
  for (int sign = -1; sign <= 1; sign += 2) {
    bench b = bench_in(DRIVE_NO_MODE);
    const servo_axis_command stimulus = {.mode = SERVO_TORQUE, .torque_nm = 20.0f * (float)sign};
    b.in.stimulus = &stimulus;
    ticks(&b, 500);
    CHECK_SAME("torque below 607F, Nm", 20.0 * sign, b.command.torque_nm);
    for (int ms = 500; ms < 2000; ++ms) {
      tick(&b);
      CHECK_AT_MOST("rate, rad/s", 1.1, sign * b.rate_rad_s);
    }
  }
}

/* --- homing */

static bench bench_homing(uint16_t enabling) {
  bench b = bench_off(0.25);
  b.o.state.mode = DRIVE_HOMING;
  b.o.homing = (drive_homing_objects){
      .method = HOMING_UP_FIRST, .first_speed = 100000, .second_speed = 100000, .acceleration = 2000000};
  b.in.contact_s = 0.1f;
  const uint16_t words[] = {0x00, 0x06, 0x07, enabling};
  for (unsigned i = 0; i < 4; ++i) {
    b.o.state.controlword = words[i];
    ticks(&b, 2);
  }
  TEST_ASSERT_EQUAL_HEX16(0x27, b.o.state.statusword & 0x6F);
  return b;
}

static void test_a_bit_4_that_enables_starts_no_homing(void) {
  bench b = bench_homing(0x1F);
  for (int ms = 0; ms < 300; ++ms) {
    tick(&b);
    CHECK_SAME("rate, rad/s", 0.0, b.command.speed.rate_rad_s);
  }
}

/* An axis that needs all its torque to move, in wind or uphill, is not at an end stop; one that stands is, after
 * 0.1 s. */
static void test_homing_turns_round_where_the_axis_stands_and_nowhere_else(void) {
  bench b = bench_homing(0x0F);
  b.in.torque_limited = true;
  b.o.state.controlword = 0x1F;
  ticks(&b, 150);
  for (int ms = 0; ms < 1000; ++ms) {
    tick(&b);
    CHECK_NEAR("rate, rad/s", 0.1, b.command.speed.rate_rad_s, 1e-6);
  }
  b.braked = true;
  ticks(&b, 95);
  CHECK_NEAR("rate, rad/s", 0.1, b.command.speed.rate_rad_s, 1e-6);
  ticks(&b, 25);
  b.braked = false;
  ticks(&b, 300);
  CHECK_NEAR("rate, rad/s", -0.1, b.command.speed.rate_rad_s, 1e-6);
}

/* --- tracking */

static bench bench_tracking(const servo_target *target, double angle_rad) {
  bench b = bench_in(DRIVE_TRACKING);
  b.o.limit.position_minimum = -10000000;
  b.o.limit.position_maximum = 10000000;
  b.o.limit.maximum_velocity = 300000;
  b.angle_rad = angle_rad;
  b.in.joint_angle = encoder(angle_rad);
  b.in.target = target;
  tick(&b);
  tick(&b); /* with the bounds of this travel */
  return b;
}

/* Mode -1 begins at 0.25 rad, then 607D becomes 1 to 2 rad, and the target is lost: a start that must not be reached is
 * no reason to move to the end of the travel, 0.75 rad away. */
static void test_an_axis_outside_its_travel_does_not_return_after_a_loss(void) {
  servo_target target = {.known = true, .at_loss = TARGET_LOSS_RETURN};
  bench b = bench_in(DRIVE_TRACKING);
  b.o.limit.position_minimum = 10000000;
  b.o.limit.position_maximum = 20000000;
  b.in.target = &target;
  ticks(&b, 100);
  target.known = false;
  for (int ms = 0; ms < 2000; ++ms) {
    tick(&b);
    CHECK_AT_MOST("demanded rate, rad/s", 1e-3, fabs((double)b.command.speed.rate_rad_s));
  }
  CHECK_NEAR("angle, rad", 0.25, b.angle_rad, 1e-3);
}

/* Mode -1 begins at 0.25 rad, and the target leads away at 0.2 rad/s until it is lost. Bit 12 says that the drive
 * follows the target: not on the way back. */
static void test_an_axis_that_returns_after_a_loss_does_not_say_that_it_follows(void) {
  servo_target target = {.known = true, .at_loss = TARGET_LOSS_RETURN, .reference = {.rate_rad_s = 0.2f}};
  bench b = bench_tracking(&target, 0.25);
  ticks(&b, 1000);
  TEST_ASSERT_TRUE(bit(&b, 0x1000));
  CHECK_AT_LEAST("angle, rad", 0.35, b.angle_rad);
  target.known = false;
  for (int ms = 0; ms < 5000; ++ms) {
    tick(&b);
    TEST_ASSERT_FALSE(bit(&b, 0x1000));
  }
  CHECK_NEAR("angle, rad", 0.25, b.angle_rad, 1e-3);
}

/* 607D at +-1 rad. At 1.1 rad the axis is turned on in pv while it moves outwards at 0.3 rad/s, and something holds it:
 * the ramp ends 20 mrad further out. The held position must be 1 mrad back from where the axis stands. */
static void test_an_axis_that_is_blocked_outside_its_travel_backs_off(void) {
  for (int side = -1; side <= 1; side += 2) {
    bench b = bench_off(1.1 * side);
    b.o.limit.position_minimum = -10000000;
    b.o.limit.position_maximum = 10000000;
    b.o.position.following_error_window = UINT32_MAX;
    b.o.state.mode = DRIVE_PROFILE_VELOCITY;
    b.rate_rad_s = 0.3 * side;
    b.in.rate_rad_s = (float)b.rate_rad_s;
    const uint16_t words[] = {0x00, 0x06, 0x07, 0x0F};
    for (unsigned i = 0; i < 4; ++i) {
      b.o.state.controlword = words[i];
      tick(&b);
    }
    b.braked = true;
    ticks(&b, 50);
    TEST_ASSERT_EQUAL_INT(SERVO_POSITION, b.command.mode);
    const double ahead_rad = side * (double)angle_difference_rad(b.command.position, b.in.joint_angle);
    CHECK_AT_MOST("ahead of the axis while the ramp runs, rad", 20e-3, ahead_rad);
    CHECK_AT_LEAST("ahead of the axis while the ramp runs, rad", 5e-3, ahead_rad);
    int blocked_ms = 0; /* at the end of the ramp */
    while (side * (double)angle_difference_rad(b.command.position, b.in.joint_angle) > 0.0) {
      tick(&b);
      blocked_ms += b.command.speed.rate_rad_s == 0.0f ? 1 : 0;
      TEST_ASSERT_TRUE(blocked_ms < 1000);
    }
    TEST_ASSERT_EQUAL_INT(100, blocked_ms);
    ticks(&b, 200);
    CHECK_SAME("rate, rad/s", 0.0, b.command.speed.rate_rad_s);
    CHECK_NEAR("back from the axis, rad", 1e-3,
               side * -(double)angle_difference_rad(b.command.position, b.in.joint_angle), 1e-6);
    b.braked = false;
    ticks(&b, 500);
    CHECK_NEAR("angle, rad", side * 1.1, b.angle_rad, 2e-3);
    CHECK_SAME("rate, rad/s", 0.0, b.command.speed.rate_rad_s);
  }
}

/* pv holds it at 1.1 rad, outside 607D of +-1 rad. */
static bench bench_held_outside(void) {
  bench b = bench_off(1.1);
  b.o.limit.position_minimum = -10000000;
  b.o.limit.position_maximum = 10000000;
  b.o.state.mode = DRIVE_PROFILE_VELOCITY;
  const uint16_t words[] = {0x00, 0x06, 0x07, 0x0F};
  for (unsigned i = 0; i < 4; ++i) {
    b.o.state.controlword = words[i];
    ticks(&b, 2);
  }
  ticks(&b, 10);
  TEST_ASSERT_EQUAL_INT(SERVO_POSITION, b.command.mode);
  TEST_ASSERT_EQUAL_HEX32(encoder(1.1), b.command.position);
  return b;
}

static void push(bench *b, double angle_rad, int time_ms) {
  for (int ms = 0; ms < time_ms; ++ms) {
    b->angle_rad = angle_rad;
    b->in.joint_angle = encoder(angle_rad);
    tick(b);
  }
}

/* By 0.25 mrad for 20 ms each second, and at last for 99 ms. */
static void test_an_axis_that_is_pushed_inwards_outside_its_travel_stays(void) {
  bench b = bench_held_outside();
  for (int second = 0; second < 20; ++second) {
    ticks(&b, 980);
    push(&b, 1.1 - 0.25e-3, 20);
  }
  ticks(&b, 100);
  push(&b, 1.1 - 0.25e-3, 99);
  ticks(&b, 100);
  CHECK_NEAR("angle, rad", 1.1, b.angle_rad, 1e-6);
  TEST_ASSERT_EQUAL_HEX32(encoder(1.1), b.command.position);
}

/* By 0.25 mrad for 100 ms: then it is held 1 mrad further in. Thrown inwards by 2 mrad more, for 20 ms, it stays. */
static void test_an_axis_gives_way_once_to_a_push_of_100_ms_outside_its_travel(void) {
  bench b = bench_held_outside();
  push(&b, 1.1 - 0.25e-3, 100);
  push(&b, 1.1 - 2.25e-3, 20);
  ticks(&b, 10);
  CHECK_NEAR("angle, rad", 1.1 - 1.25e-3, b.angle_rad, 1e-6);
}

/* 607D becomes +-0.2 rad while pv turns the axis outwards at 0.3 rad/s, at 0.25 rad; then a stop is ordered. It must
 * end outside, as a ramp that never turns back, however gentle the jerk (60A4) of other ramps is. */
static void test_a_stop_outside_the_travel_does_not_turn_back(void) {
  const uint32_t jerks[] = {1000, 1000000, 50000000, 2000000000};
  for (unsigned i = 0; i < sizeof jerks / sizeof jerks[0]; ++i) {
    bench b = bench_in(DRIVE_PROFILE_VELOCITY);
    b.machine.torque_nm = 40.0f;
    b.machine.deceleration_rad_s2 = 2.0f;
    b.o.velocity.target = 300000;
    ticks(&b, 1500);
    CHECK_NEAR("rate, rad/s", 0.3, b.rate_rad_s, 1e-3);
    b.o.limit.jerk = jerks[i];
    b.o.limit.position_minimum = -2000000;
    b.o.limit.position_maximum = 2000000;
    b.o.state.controlword = 0x02; /* quick stop */
    const double from_rad = b.angle_rad;
    for (int ms = 0; ms < 1000; ++ms) {
      tick(&b);
      CHECK_AT_LEAST("rate, rad/s", -1e-6, b.command.speed.rate_rad_s);
    }
    CHECK_NEAR("rate, rad/s", 0.0, b.rate_rad_s, 1e-9);
    CHECK_AT_LEAST("way, rad", 0.3 * 0.3 / (2.0 * 5.0), b.angle_rad - from_rad);
    CHECK_AT_MOST("way, rad", 0.3 * 0.3 / 2.0, b.angle_rad - from_rad);
  }
}

/* With 607D at +-1 rad and 607F at 0.3 rad/s, away from an end and 0.1 mrad before it, where no rate is left. Towards
 * the target the axis must be able to stop; away from it the rate limit holds. */
static void test_a_target_is_followed_no_faster_than_the_axis_can_stop_within_the_travel(void) {
  static const struct {
    double angle_rad;
    float target_rad_s, minimum_rad_s, maximum_rad_s;
  } cases[] = {{0.0, 0.1f, -0.3f, 0.3f},      {0.0, -0.1f, -0.3f, 0.3f},     {0.9999, 0.1f, -0.3f, 0.0f},
               {0.9999, -0.1f, -0.3f, 0.3f},  {-0.9999, -0.1f, 0.0f, 0.3f},  {-0.9999, 0.1f, -0.3f, 0.3f},
               {0.9999, 0.001f, -0.3f, 0.0f}, {-0.9999, -0.001f, 0.0f, 0.3f}};
  for (unsigned i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
    const servo_target target = {.known = true, .reference = {.rate_rad_s = cases[i].target_rad_s}};
    const bench b = bench_tracking(&target, cases[i].angle_rad);
    TEST_ASSERT_EQUAL_INT(SERVO_SPEED, b.command.mode);
    TEST_ASSERT_EQUAL_PTR(&target, b.axis.motion.followed);
    const drive_tracking_limits *limits = &b.axis.motion.tracking;
    CHECK_NEAR("minimum, rad/s", cases[i].minimum_rad_s, limits->minimum_rad_s, 0.02);
    CHECK_NEAR("maximum, rad/s", cases[i].maximum_rad_s, limits->maximum_rad_s, 0.02);
    CHECK_SAME("6083, rad/s2", 2.0, limits->acceleration_rad_s2);
    CHECK_SAME("60A4, rad/s3", 50.0, limits->jerk_rad_s3);
  }
}

/* An axis at its end waits for a target beyond it: bit 11 and bit 12 stay, and it comes back with the target. */
static void test_an_axis_at_the_end_of_its_travel_waits_for_its_target(void) {
  servo_target target = {.known = true, .reference = {.rate_rad_s = 0.1f}};
  bench b = bench_tracking(&target, 0.999);
  for (int i = 0; i < 2000; ++i) {
    tick(&b);
    TEST_ASSERT_TRUE(bit(&b, DRIVE_STATUS_INTERNAL_LIMIT));
    TEST_ASSERT_TRUE(bit(&b, DRIVE_STATUS_MODE_12));
  }
  CHECK_NEAR("at the end, rad", 1.0, b.angle_rad, 1e-3);
  target.reference.rate_rad_s = -0.1f;
  ticks(&b, 500);
  TEST_ASSERT_TRUE(b.angle_rad < 0.98);
  TEST_ASSERT_FALSE(bit(&b, DRIVE_STATUS_INTERNAL_LIMIT));
}

/* Bit 11 while a limit keeps the axis from the target's rate. */
static void test_a_target_that_is_too_fast_is_reported_as_limited(void) {
  for (int side = -1; side <= 1; side += 2) {
    servo_target target = {.known = true};
    bench b = bench_tracking(&target, 0.0);
    TEST_ASSERT_FALSE(bit(&b, DRIVE_STATUS_INTERNAL_LIMIT));
    target.reference.rate_rad_s = 3.0f * (float)side;
    ticks(&b, 500);
    CHECK_NEAR("rate within 607F, rad/s", 0.3 * side, b.command.speed.rate_rad_s, 1e-6);
    TEST_ASSERT_TRUE(bit(&b, DRIVE_STATUS_INTERNAL_LIMIT));
  }
}

/* 6067 is 0.1 mrad, 6068 5 ms. A target that was lost, or not seen for a while, counts from the beginning. */
static void test_a_target_found_again_is_acquired_before_it_counts_as_reached(void) {
  servo_target target = {.known = true};
  bench b = bench_tracking(&target, 0.0);
  ticks(&b, 10);
  TEST_ASSERT_EQUAL_INT(DRIVE_ON_TARGET, b.axis.tracking);
  target.known = false;
  ticks(&b, 20);
  TEST_ASSERT_EQUAL_INT(DRIVE_TARGET_LOST, b.axis.tracking);
  target.known = true;
  for (int ms = 0; ms < 5; ++ms) {
    tick(&b);
    TEST_ASSERT_EQUAL_INT(DRIVE_ACQUIRING, b.axis.tracking);
    TEST_ASSERT_FALSE(bit(&b, DRIVE_STATUS_TARGET_REACHED));
  }
  ticks(&b, 2);
  TEST_ASSERT_EQUAL_INT(DRIVE_ON_TARGET, b.axis.tracking);
  TEST_ASSERT_TRUE(bit(&b, DRIVE_STATUS_TARGET_REACHED));
  target.frame_age_ticks = DRIVE_COASTS_AFTER + 1;
  ticks(&b, 20);
  TEST_ASSERT_EQUAL_INT(DRIVE_COASTING, b.axis.tracking);
  target.frame_age_ticks = 0;
  target.error_rad = 1e-3f; /* the estimate was wrong */
  tick(&b);
  TEST_ASSERT_EQUAL_INT(DRIVE_ACQUIRING, b.axis.tracking);
  TEST_ASSERT_FALSE(bit(&b, DRIVE_STATUS_TARGET_REACHED));
}

/* Rate, acceleration and torque of a target within the limits are those of the axis; a rate that jumps is reached at
 * 6083 and fed forward within 60A4; one that ends leaves an axis that slows down. */
static void test_a_target_is_followed_as_given_and_within_the_limits(void) {
  servo_target target = {
      .known = true, .reference = {.rate_rad_s = 0.0f, .acceleration_rad_s2 = 0.02f}, .torque_nm = 1.5f};
  bench b = bench_tracking(&target, 0.0);
  CHECK_SAME("rate, rad/s", 0.0, b.command.speed.rate_rad_s);
  CHECK_NEAR("acceleration, rad/s2", 0.02, b.command.speed.acceleration_rad_s2, 1e-6);
  CHECK_SAME("torque, Nm", 1.5, b.command.torque_nm);
  target.reference = (speed_reference){.rate_rad_s = 0.2f};
  double rate_rad_s = 0.0, acceleration_rad_s2 = 0.02;
  for (int i = 0; i < 100; ++i) {
    tick(&b);
    CHECK_NEAR("rate, rad/s", rate_rad_s + 0.002, b.command.speed.rate_rad_s, 1e-5);
    CHECK_AT_MOST("change, rad/s2", 0.0501, fabs((double)b.command.speed.acceleration_rad_s2 - acceleration_rad_s2));
    rate_rad_s = (double)b.command.speed.rate_rad_s;
    acceleration_rad_s2 = (double)b.command.speed.acceleration_rad_s2;
  }
  CHECK_NEAR("reached, rad/s", 0.2, rate_rad_s, 1e-5);
  target.known = false;
  tick(&b);
  TEST_ASSERT_NULL(b.axis.motion.followed);
  CHECK_NEAR("the stop begins, rad/s", 0.2, b.command.speed.rate_rad_s, 0.003);
  ticks(&b, 300);
  CHECK_SAME("at rest, rad/s", 0.0, b.command.speed.rate_rad_s);
}

static void test_torque_limits_are_the_smaller_of_6072_and_60e0_or_60e1(void) {
  bench b = bench_in(DRIVE_PROFILE_VELOCITY);
  b.o.torque.maximum = 500;
  b.o.torque.positive_limit = 250;
  b.o.torque.negative_limit = 800;
  b.o.torque.offset = 100;
  tick(&b);
  TEST_ASSERT_TRUE(b.command.torque_limited);
  CHECK_NEAR("highest, Nm", 10.0, b.command.limits.maximum_nm, 1e-5);
  CHECK_NEAR("lowest, Nm", -20.0, b.command.limits.minimum_nm, 1e-5);
  CHECK_SAME("no offset in pv", 0.0, b.command.torque_nm);
  b.o.state.mode = DRIVE_CYCLIC_VELOCITY;
  tick(&b);
  CHECK_NEAR("offset in csv, Nm", 4.0, b.command.torque_nm, 1e-5);
}

static void test_a_torque_at_its_limit_and_a_warning_are_seen_in_the_statusword(void) {
  bench b = bench_in(DRIVE_PROFILE_VELOCITY);
  b.in.torque_limited = true;
  b.in.warning = true;
  tick(&b);
  TEST_ASSERT_TRUE(bit(&b, DRIVE_STATUS_INTERNAL_LIMIT));
  TEST_ASSERT_TRUE(bit(&b, DRIVE_STATUS_WARNING));
}

/* --- from mode to mode --- */

static void test_any_mode_takes_over_a_moving_axis_without_a_step(void) {
  const int8_t modes[] = {DRIVE_PROFILE_POSITION, DRIVE_PROFILE_VELOCITY, DRIVE_CYCLIC_POSITION, DRIVE_CYCLIC_VELOCITY,
                          DRIVE_CYCLIC_TORQUE,    DRIVE_NO_MODE,          DRIVE_TRACKING};
  random_source random = {.state = 7};
  bench b = bench_in(DRIVE_PROFILE_VELOCITY);
  servo_target target = {0};
  b.in.target = &target;
  b.o.position.following_error_window = UINT32_MAX;
  b.o.torque.slope_per_s = 2000;
  double worst_torque_nm = 0.0;
  for (int change = 0; change < 3000; ++change) {
    const int8_t mode = modes[random_bits(&random) % (sizeof modes / sizeof *modes)];
    b.o.state.mode = mode;
    b.o.velocity.target = (int32_t)random_uniform(&random, -400000, 400000);
    target = (servo_target){.known = random_bits(&random) % 4 != 0,
                            .reference = {.rate_rad_s = (float)random_uniform(&random, -0.4, 0.4)},
                            .at_loss = random_bits(&random) % 2 != 0 ? TARGET_LOSS_RETURN : TARGET_LOSS_STAND};
    b.o.torque.target = (int16_t)random_uniform(&random, -50, 50);
    b.o.state.controlword = 0x0F;
    const int count = (int)random_decades(&random, 2, 300);
    for (int i = 0; i < count; ++i) {
      target.known = target.known && i < 200;
      b.o.position.target = drive_add(b.o.position.actual, mode == DRIVE_PROFILE_POSITION ? 1000000 : 0);
      b.in.setpoint_arrived = mode == DRIVE_CYCLIC_TORQUE;
      b.o.state.controlword = (uint16_t)(0x0F | (i > 1 ? 0x10 : 0));
      const servo_axis_command last = b.command;
      tick(&b);
      if (last.mode == SERVO_TORQUE && b.command.mode == SERVO_TORQUE) {
        worst_torque_nm = fmax(worst_torque_nm, fabs((double)(b.command.torque_nm - last.torque_nm)));
      }
    }
    TEST_ASSERT_EQUAL_HEX16(0x27, b.o.state.statusword & 0x6F);
  }
  LOG_VALUE("largest step of the rate, rad/s", b.worst_step_rad_s);
  LOG_VALUE("largest step of the torque, Nm", worst_torque_nm);
  CHECK_AT_MOST("largest step of the rate, rad/s", 0.0041, b.worst_step_rad_s);
  CHECK_AT_MOST("largest step of the torque, Nm", 0.081, worst_torque_nm);
}

static void test_an_axis_that_turns_when_it_is_enabled_is_caught_at_its_speed(void) {
  bench b = bench_off(0.0);
  b.o.state.mode = DRIVE_PROFILE_POSITION;
  b.rate_rad_s = 0.3;
  b.in.rate_rad_s = 0.3f;
  const uint16_t words[] = {0x00, 0x06, 0x07, 0x0F};
  for (unsigned i = 0; i < 4; ++i) {
    b.o.state.controlword = words[i];
    ticks(&b, 2);
  }
  CHECK_NEAR("rate, rad/s", 0.3, b.command.speed.rate_rad_s, 1e-3);
  ticks(&b, 500);
  CHECK_SAME("rate, rad/s", 0.0, b.command.speed.rate_rad_s);
  CHECK_AT_MOST("largest step of the rate, rad/s", 0.0021, b.worst_step_rad_s);
}

static void test_windows_that_are_not_monitored_are_always_reached(void) {
  bench b = bench_in(DRIVE_PROFILE_POSITION);
  b.o.position.window = UINT32_MAX;
  ticks(&b, 10);
  TEST_ASSERT_TRUE(bit(&b, DRIVE_STATUS_TARGET_REACHED));
}

/* 5 ms in the window, for the first time and after each time outside of it. */
static void test_a_dwell_timer_counts_its_time_anew_after_each_interruption(void) {
  dwell_timer timer = {0};
  for (int round = 0; round < 3; ++round) {
    for (int ms = 0; ms < 5; ++ms) {
      TEST_ASSERT_FALSE(dwell_timer_step(&timer, true, 5, dt_s));
    }
    TEST_ASSERT_TRUE(dwell_timer_step(&timer, true, 5, dt_s));
    TEST_ASSERT_FALSE(dwell_timer_step(&timer, false, 5, dt_s));
  }
  TEST_ASSERT_TRUE(dwell_timer_step(&timer, true, 0, dt_s)); /* time 0: at once */
}

static void test_a_dwell_timer_that_runs_for_minutes_does_not_wrap(void) {
  dwell_timer timer = {0};
  bool held = false;
  for (int i = 0; i < 200000; ++i) {
    held = dwell_timer_step(&timer, true, UINT16_MAX, dt_s);
    TEST_ASSERT_TRUE(!held || i >= 65000);
  }
  TEST_ASSERT_TRUE(held);
  TEST_ASSERT_FALSE(dwell_timer_step(&timer, false, 0, dt_s));
}

static void test_a_stop_is_over_when_the_axis_stands_not_when_its_ramp_does(void) {
  bench b = bench_in(DRIVE_PROFILE_VELOCITY);
  b.o.velocity.target = 1000000;
  ticks(&b, 1500);
  b.o.state.controlword = 0x02;
  ticks(&b, 200);
  b.braked = true; /* lags: still turns at 10 mrad/s, 606F is 0.5 mrad/s */
  b.held_rad_s = 0.01;
  ticks(&b, 200);
  CHECK_SAME("set-point, rad/s", 0.0, b.command.speed.rate_rad_s);
  TEST_ASSERT_EQUAL_HEX16(0x07, b.o.state.statusword & 0x6F);
  TEST_ASSERT_EQUAL_INT(SERVO_SPEED, b.command.mode);
  b.held_rad_s = 0.0004;
  ticks(&b, 2);
  TEST_ASSERT_EQUAL_HEX16(0x40, b.o.state.statusword & 0x4F);
  TEST_ASSERT_EQUAL_INT(SERVO_OFF, b.command.mode);
}

/* Each command that slows down with 6084 ends in its state, when the axis stands and not before: 2 rad/s^2 from 1 rad/s
 * takes half a second and the jerk. */
static void test_a_stop_by_slowing_down_ends_in_the_state_of_its_command(void) {
  static const struct {
    const char *what;
    uint16_t controlword;
    uint16_t state; /* of the statusword, without bit 4 */
  } stops[] = {{"shutdown, 605B = 1", 0x06, 0x21},
               {"disable operation, 605C = 1", 0x07, 0x23},
               {"quick stop, 605A = 1", 0x02, 0x40},
               {"fault, 605E = 1", 0x0F, 0x08}};
  for (unsigned i = 0; i < sizeof stops / sizeof stops[0]; ++i) {
    bench b = bench_in(DRIVE_PROFILE_VELOCITY);
    b.o.state.option = (drive_options){.quick_stop = 1, .shutdown = 1, .disable = 1, .halt = 1, .fault_reaction = 1};
    b.o.velocity.target = 1000000;
    ticks(&b, 1500);
    b.o.state.controlword = stops[i].controlword;
    b.in.faults = stops[i].controlword == 0x0F ? fault_bit(FAULT_HEARTBEAT_LOST) : 0;
    const uint16_t mask = (stops[i].state & 0x20) != 0 ? 0x6F : 0x4F;
    const int count = until(&b, mask, stops[i].state, 1000);
    CHECK_NEAR(stops[i].what, 1000.0 / 2.0 + 40.0, count, 4);
    CHECK_NEAR("rate then, rad/s", 0.0, b.rate_rad_s, 1e-9);
    TEST_ASSERT_EQUAL_INT(SERVO_OFF, b.command.mode);
  }
}

/* The waiting time of a stop starts anew with each stop. */
static void test_a_second_stop_waits_its_own_200_ms_for_an_axis_that_does_not_come_to_rest(void) {
  bench b = bench_in(DRIVE_PROFILE_VELOCITY);
  b.braked = true;
  b.held_rad_s = 0.01;
  for (int stop = 0; stop < 3; ++stop) {
    b.o.state.controlword = 0x02;
    int count = 0;
    do {
      tick(&b);
      TEST_ASSERT_TRUE(++count < 1000);
    } while (b.command.mode != SERVO_OFF);
    CHECK_NEAR("ticks until off", 230, count, 40);
    for (unsigned i = 0; i < 3; ++i) {
      b.o.state.controlword = ((const uint16_t[]){0x06, 0x07, 0x0F})[i];
      ticks(&b, 2);
    }
    TEST_ASSERT_EQUAL_HEX16(0x27, b.o.state.statusword & 0x6F);
  }
}

static void test_an_axis_that_does_not_come_to_rest_is_let_go_after_200_ms(void) {
  bench b = bench_in(DRIVE_PROFILE_VELOCITY);
  b.o.velocity.target = 1000000;
  ticks(&b, 1500);
  b.braked = true;
  b.held_rad_s = 0.01;
  b.o.state.controlword = 0x02;
  int at_rest = 0;
  int count = 0;
  while (b.command.mode != SERVO_OFF) {
    tick(&b);
    at_rest += b.command.mode != SERVO_OFF && b.command.speed.rate_rad_s == 0.0f;
    TEST_ASSERT_TRUE(++count < 5000);
  }
  CHECK_NEAR("ticks with set-point 0", 200, at_rest, 3);
}

static void test_a_torque_cannot_drive_the_axis_faster_than_110_percent_of_607f(void) {
  for (int sign = -1; sign <= 1; sign += 2) {
    bench b = bench_in(DRIVE_CYCLIC_TORQUE);
    b.o.limit.maximum_velocity = 500000;
    b.o.torque.target = (int16_t)(sign * 500); /* 20 Nm on 20 kg m^2: 1 rad/s^2 */
    double fastest_rad_s = 0.0;
    for (int i = 0; i < 4000; ++i) {
      b.in.setpoint_arrived = true;
      tick(&b);
      fastest_rad_s = fmax(fastest_rad_s, sign * b.rate_rad_s);
      if (sign * b.rate_rad_s < 0.499) {
        CHECK_NEAR("torque below the limit, Nm", sign * 20.0, b.command.torque_nm, i < 2 ? 20.0 : 1e-4);
      }
    }
    CHECK_NEAR("fastest, rad/s", 0.55, fastest_rad_s, 0.001);
    TEST_ASSERT_TRUE((b.o.state.statusword & DRIVE_STATUS_INTERNAL_LIMIT) != 0);
    b.o.torque.target = (int16_t)(-sign * 500); /* braking is not limited */
    for (int i = 0; i < 2; ++i) {
      b.in.setpoint_arrived = true;
      tick(&b);
    }
    CHECK_NEAR("braking torque, Nm", -sign * 20.0, b.command.torque_nm, 1e-4);
  }
}

/* 60A4 falls to one count while the axis brakes, or accelerates, with 2 rad/s2. Then it would take 23 days to end this
 * acceleration; the rate would pass 0, or the target. */
static void test_a_jerk_that_falls_during_a_ramp_does_not_carry_the_rate_past_its_target(void) {
  const int32_t targets[] = {0, -300000, 800000};
  const uint16_t words[] = {0x07, 0x02, 0x10F}; /* disable operation, quick stop, halt */
  for (unsigned i = 0; i < 3; ++i) {
    bench b = bench_in(DRIVE_PROFILE_VELOCITY);
    b.o.velocity.target = 500000;
    ticks(&b, 1000);
    b.o.velocity.target = targets[i];
    ticks(&b, 100);
    CHECK_AT_LEAST("acceleration, rad/s2", 1.9, fabs((double)b.command.speed.acceleration_rad_s2));
    b.o.limit.jerk = 1;
    const double target_rad_s = 1e-6 * targets[i];
    for (int tick_index = 0; tick_index < 2000; ++tick_index) {
      tick(&b);
      const double rate_rad_s = (double)b.command.speed.rate_rad_s;
      TEST_ASSERT_TRUE(targets[i] > 0 ? rate_rad_s < target_rad_s + 1e-6 : rate_rad_s > target_rad_s - 1e-6);
    }
    CHECK_NEAR("rate, rad/s", target_rad_s, (double)b.command.speed.rate_rad_s, 1e-6);
  }
  for (unsigned i = 0; i < 9; ++i) {
    const bool goes_on = i >= 3;     /* again before the stop has ended */
    const bool falls_early = i >= 6; /* before the stop has begun */
    bench b = bench_in(DRIVE_PROFILE_VELOCITY);
    b.machine.stop_deceleration_rad_s2 = 1.0f;
    b.o.state.option.quick_stop = 5;
    b.o.velocity.target = 500000;
    ticks(&b, 1000);
    b.o.velocity.target = goes_on ? 500000 : 0;
    ticks(&b, 100);
    b.o.limit.jerk = 1;
    ticks(&b, falls_early ? 2 : 0);
    b.o.state.controlword = words[i % 3];
    ticks(&b, goes_on ? 150 : 0);
    TEST_ASSERT_TRUE(!goes_on || b.command.speed.acceleration_rad_s2 < -0.3f);
    b.o.state.controlword = goes_on ? 0x0F : b.o.state.controlword;
    b.o.velocity.target = 0;
    for (int tick_index = 0; tick_index < 2000; ++tick_index) {
      tick(&b);
      TEST_ASSERT_TRUE(b.rate_rad_s > -1e-6);
    }
    CHECK_NEAR("rate, rad/s", 0.0, b.rate_rad_s, 1e-6);
  }
}

/* 60A4 falls from 50 rad/s3 to 0.05 rad/s3 while the axis turns at 0.1 rad/s. A ramp then gains j t^2 / 2. */
static void test_a_jerk_that_falls_between_two_ramps_counts_for_the_next_one(void) {
  bench b = bench_in(DRIVE_PROFILE_VELOCITY);
  b.o.velocity.target = 100000;
  ticks(&b, 500);
  CHECK_NEAR("rate, rad/s", 0.1, b.command.speed.rate_rad_s, 1e-6);
  b.o.limit.jerk = 50000;
  tick(&b);
  b.o.velocity.target = 1000000;
  ticks(&b, 1000);
  CHECK_NEAR("rate, rad/s", 0.1 + 0.5 * 0.05, b.command.speed.rate_rad_s, 2e-4);
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_the_axis_is_off_and_reports_its_position_before_it_is_enabled);
  RUN_TEST(test_every_supported_mode_is_shown_within_a_tick_and_others_leave_the_one_in_force);
  RUN_TEST(test_without_a_mode_the_axis_stands_still);
  RUN_TEST(test_pv_reaches_1_deg_s_and_reads_it_back);
  RUN_TEST(test_an_axis_moves_from_a_speed_above_606f_on);
  RUN_TEST(test_pv_has_reached_its_target_within_606d);
  RUN_TEST(test_pv_is_held_to_607f_and_says_so);
  RUN_TEST(test_pv_stops_at_a_software_position_limit_and_leaves_it_in_the_other_direction);
  RUN_TEST(test_pv_brakes_before_a_limit_with_what_the_motor_surely_has);
  RUN_TEST(test_pv_goes_on_at_once_after_a_halt_close_to_the_limit);
  RUN_TEST(test_the_acceleration_given_brings_exactly_the_next_rate);
  RUN_TEST(test_a_ramp_goes_on_through_a_change_from_pv_to_pp_without_a_lost_tick);
  RUN_TEST(test_pv_and_csv_take_an_axis_over_from_each_other_at_its_rate);
  RUN_TEST(test_pv_and_hm_begin_at_the_speed_that_the_position_loop_has_demanded);
  RUN_TEST(test_pp_goes_to_its_target_acknowledges_and_arrives_exactly);
  RUN_TEST(test_pp_takes_a_waiting_set_point_and_changes_immediately_when_reported);
  RUN_TEST(test_pp_takes_a_set_point_whose_bit_4_rises_with_the_mode);
  RUN_TEST(test_a_bit_4_that_enables_or_was_set_in_another_mode_moves_nothing);
  RUN_TEST(test_pp_turns_many_times_round);
  RUN_TEST(test_a_thousand_turns_wrap_by_whole_turns_in_both_directions);
  RUN_TEST(test_moves_are_as_ordered_after_many_turns);
  RUN_TEST(test_a_travel_that_becomes_limited_refers_to_the_position_shown);
  RUN_TEST(test_a_limit_that_moves_past_a_standing_axis_is_no_target_reached);
  RUN_TEST(test_no_position_demand_is_faster_than_the_position_loop);
  RUN_TEST(test_a_relative_move_from_the_limit_leads_back_at_once);
  RUN_TEST(test_the_slowest_move_of_pp_has_its_rate_exactly);
  RUN_TEST(test_a_relative_move_after_cst_or_csv_counts_from_where_the_axis_is);
  RUN_TEST(test_pp_ends_at_the_software_position_limit);
  RUN_TEST(test_pp_brakes_with_what_the_motor_surely_has_when_its_target_is_near_the_limit);
  RUN_TEST(test_no_software_limit_leads_beyond_the_hard_travel);
  RUN_TEST(test_halt_holds_a_move_and_lets_it_go_on_to_its_target);
  RUN_TEST(test_quick_stop_brakes_with_6085_and_switches_off_or_stays);
  RUN_TEST(test_a_fault_brakes_then_switches_off_and_its_code_stays_until_reset);
  RUN_TEST(test_samples_that_are_not_finite_cut_the_torque_and_no_nan_comes_out);
  RUN_TEST(test_a_blocked_axis_is_a_following_error_and_a_fault);
  RUN_TEST(test_an_unmonitored_following_error_is_cut_at_a_quarter_turn);
  RUN_TEST(test_csv_interpolates_between_set_points_and_adds_the_offset);
  RUN_TEST(test_set_points_that_stop_are_held_and_then_the_axis_ramps_down);
  RUN_TEST(test_a_longer_period_of_60c2_holds_set_points_longer);
  RUN_TEST(test_a_period_that_cannot_be_is_one_tick);
  RUN_TEST(test_a_move_ends_when_the_axis_is_found_on_another_turn);
  RUN_TEST(test_pv_goes_on_when_the_axis_is_found_on_another_turn);
  RUN_TEST(test_an_axis_that_is_held_stays_when_it_is_found_on_another_turn);
  RUN_TEST(test_csp_follows_a_parabola_one_period_late_with_position_and_rate);
  RUN_TEST(test_csp_does_not_move_before_its_first_set_point_whatever_607a_was);
  RUN_TEST(test_csp_after_csv_does_not_move_before_its_first_set_point);
  RUN_TEST(test_an_unknown_position_stops_the_modes_of_positions_alone);
  RUN_TEST(test_at_an_unknown_position_the_torque_offset_speeds_up_no_axis);
  RUN_TEST(test_a_mode_that_changes_in_each_tick_stops_the_axis);
  RUN_TEST(test_csp_holds_a_position_from_the_tick_in_which_it_is_entered);
  RUN_TEST(test_csp_approaches_a_far_set_point_at_607f_and_stays_inside_607d);
  RUN_TEST(test_csp_brakes_before_the_limit_when_its_set_points_do_not);
  RUN_TEST(test_csp_reports_a_rate_offset_beyond_607f_as_limited);
  RUN_TEST(test_csv_stops_before_a_position_limit_and_stays_there_until_turned_round);
  RUN_TEST(test_csv_with_rate_0_holds_an_axis_outside_its_travel);
  RUN_TEST(test_csv_obeys_a_lower_rate_while_it_brakes_before_a_limit);
  RUN_TEST(test_cst_gives_target_and_offset_along_the_slope);
  RUN_TEST(test_cst_is_stopped_by_the_position_limit_and_held);
  RUN_TEST(test_cst_at_full_torque_stops_within_the_travel);
  RUN_TEST(test_cst_brakes_an_axis_that_is_struck_before_its_limit_at_once);
  RUN_TEST(test_cst_gives_no_torque_before_a_limit_of_the_speed_is_known);
  RUN_TEST(test_cst_is_not_blocked_by_the_rate_that_the_mode_before_has_demanded);
  RUN_TEST(test_an_experiment_moves_the_axis_within_its_limits_and_ends_at_them);
  RUN_TEST(test_an_axis_slows_down_from_the_rate_at_which_an_experiment_ends);
  RUN_TEST(test_no_mode_of_operation_obeys_an_experiment);
  RUN_TEST(test_the_stop_after_an_experiment_is_the_same_whatever_was_before);
  RUN_TEST(test_the_torque_of_an_experiment_cannot_drive_the_axis_faster_than_110_percent_of_607f);
  RUN_TEST(test_a_bit_4_that_enables_starts_no_homing);
  RUN_TEST(test_homing_turns_round_where_the_axis_stands_and_nowhere_else);
  RUN_TEST(test_an_axis_outside_its_travel_does_not_return_after_a_loss);
  RUN_TEST(test_an_axis_that_returns_after_a_loss_does_not_say_that_it_follows);
  RUN_TEST(test_an_axis_that_is_blocked_outside_its_travel_backs_off);
  RUN_TEST(test_an_axis_that_is_pushed_inwards_outside_its_travel_stays);
  RUN_TEST(test_an_axis_gives_way_once_to_a_push_of_100_ms_outside_its_travel);
  RUN_TEST(test_a_stop_outside_the_travel_does_not_turn_back);
  RUN_TEST(test_a_target_is_followed_no_faster_than_the_axis_can_stop_within_the_travel);
  RUN_TEST(test_an_axis_at_the_end_of_its_travel_waits_for_its_target);
  RUN_TEST(test_a_target_that_is_too_fast_is_reported_as_limited);
  RUN_TEST(test_a_target_found_again_is_acquired_before_it_counts_as_reached);
  RUN_TEST(test_a_target_is_followed_as_given_and_within_the_limits);
  RUN_TEST(test_torque_limits_are_the_smaller_of_6072_and_60e0_or_60e1);
  RUN_TEST(test_a_torque_at_its_limit_and_a_warning_are_seen_in_the_statusword);
  RUN_TEST(test_any_mode_takes_over_a_moving_axis_without_a_step);
  RUN_TEST(test_an_axis_that_turns_when_it_is_enabled_is_caught_at_its_speed);
  RUN_TEST(test_windows_that_are_not_monitored_are_always_reached);
  RUN_TEST(test_a_dwell_timer_counts_its_time_anew_after_each_interruption);
  RUN_TEST(test_a_dwell_timer_that_runs_for_minutes_does_not_wrap);
  RUN_TEST(test_a_stop_is_over_when_the_axis_stands_not_when_its_ramp_does);
  RUN_TEST(test_a_stop_by_slowing_down_ends_in_the_state_of_its_command);
  RUN_TEST(test_a_second_stop_waits_its_own_200_ms_for_an_axis_that_does_not_come_to_rest);
  RUN_TEST(test_an_axis_that_does_not_come_to_rest_is_let_go_after_200_ms);
  RUN_TEST(test_a_torque_cannot_drive_the_axis_faster_than_110_percent_of_607f);
  RUN_TEST(test_a_jerk_that_falls_during_a_ramp_does_not_carry_the_rate_past_its_target);
  RUN_TEST(test_a_jerk_that_falls_between_two_ramps_counts_for_the_next_one);
  return UNITY_END();
}
