/* SPDX-License-Identifier: Apache-2.0 */
/* The whole node from a master's view: frames in, frames out, and the motion of its machine. */
#include "support/node_bench.h"

#include <stdio.h>

#include "canopen/object_dictionary_check.h"
#include "support/check.h"

enum { EMCY = 0x080 + NODE_ID, HEARTBEAT = 0x700 + NODE_ID, PV = 3, CSP = 8, CSV = 9, CST = 10, RESET_MS = 50 };

void setUp(void) { node_bench_start(); }
void tearDown(void) {}

/* Pre-defined error field, newest first: only the code. */
static uint32_t newest_error(void) { return get(0x1003, 1) & 0xFFFF; }

static void turn_azimuth_at_0_2_rad_s(void) {
  enable(0, PV);
  SET(0x60FF, 0, 200000);
  wait_ms(900);
  CHECK_NEAR("rad/s", 0.2, machine.axis[0].rate_rad_s, 0.002);
}

/* --- dictionary --------------------------------------------------------------------------------------------------- */

static void test_every_row_of_the_dictionary_keeps_the_rules(void) {
  const od_table_verdict verdict = od_check_dictionary(&node.canopen.dictionary);
  char row[32];
  (void)snprintf(row, sizeof row, "%04X:%u", (unsigned)verdict.index, (unsigned)verdict.sub);
  TEST_ASSERT_EQUAL_INT_MESSAGE(OD_TABLE_GOOD, verdict.fault, row);
}

/* --- motion ------------------------------------------------------------------------------------------------------- */

static void test_pdos_alone_enable_an_axis_and_turn_it(void) {
  nmt(1);
  for (uint8_t controlword = 6; controlword <= 7; ++controlword) {
    give(0x200 + NODE_ID, 3, (const uint8_t[]){controlword, 0, PV});
    wait_ms(2);
  }
  give(0x200 + NODE_ID, 3, (const uint8_t[]){0x0F, 0, PV});
  give(0x400 + NODE_ID, 8, (const uint8_t[]){0xC0, 0xD4, 0x01, 0, 0, 0, 0, 0}); /* 120000 for azimuth, 0 for pitch */
  sent_count = 0;
  wait_ms(1000);
  CHECK_NEAR("rad/s", 0.12, machine.axis[0].rate_rad_s, 0.001);
  CHECK_SAME("pitch, rad/s", 0.0, machine.axis[1].rate_rad_s);
  const can_frame *speeds = last_sent(0x380 + NODE_ID);
  TEST_ASSERT_NOT_NULL(speeds);
  CHECK_NEAR("rad/s on the bus", 0.12, 1e-6 * (double)(int32_t)u32_of(speeds->data), 0.001);
  const can_frame *state = last_sent(0x180 + NODE_ID);
  TEST_ASSERT_NOT_NULL(state);
  TEST_ASSERT_EQUAL_HEX32(STATE_ENABLED, state->data[0] & STATE_MASK);
  TEST_ASSERT_EQUAL(PV, state->data[2]);
}

/* One in which the last tick's commands count. */
static void pwm(void) { servo_board_pwm_period(&node.board, SERVO_TICK_LATENCY_PERIODS); }

static void test_the_bridge_pushes_only_where_an_axis_is_on(void) {
  for (int i = 0; i < SERVO_AXES; ++i) {
    const uint32_t shift = i == 0 ? 0 : PITCH;
    pwm();
    CHECK_SAME("duty, off", 0.0, machine.axis[i].duty);
    enable(shift, CST);
    machine.axis[i].load_nm = 4.0; /* holds against it */
    SET(0x6071 + shift, 0, 100);   /* 4 N m */
    wait_ms(5);
    CHECK_NEAR("A", 1.6, machine.axis[i].current_a, 1e-4);
    machine.axis[i].current_a = 1.5f; /* measured */
    pwm();
    CHECK_AT_LEAST("duty", 0.01, machine.axis[i].duty);
    CHECK_SAME("duty of the other one", 0.0, machine.axis[1 - i].duty);
    command(shift, 0);
    wait_ms(200);
    pwm();
    CHECK_SAME("duty, off again", 0.0, machine.axis[i].duty);
  }
}

static void test_the_brake_opens_where_an_axis_is_on(void) {
  for (int axis = 0; axis < SERVO_AXES; ++axis) {
    const uint32_t shift = axis == 0 ? 0 : PITCH;
    enable(shift, PV);
    TEST_ASSERT_TRUE(machine.axis[axis].brake_coil_on);
    TEST_ASSERT_FALSE(machine.axis[1 - axis].brake_coil_on);
    command(shift, 0);
    wait_ms(500);
    TEST_ASSERT_FALSE(machine.axis[axis].brake_coil_on);
  }
}

static void test_cyclic_setpoints_that_repeat_their_value_keep_the_axis_going(void) {
  SET(0x60C2, 1, 10);
  enable(0, CSV);
  for (int i = 0; i < 50; ++i) {
    SET(0x60FF, 0, 50000);
    wait_ms(9);
  }
  CHECK_NEAR("rad/s", 0.05, machine.axis[0].rate_rad_s, 0.001);
  wait_ms(500); /* no more arrive */
  CHECK_NEAR("rad/s", 0.0, machine.axis[0].rate_rad_s, 0.001);
}

/* csp: 607A is 0.5 mrad further every 10 ms, then it repeats its last value, then it stays away. */
static void test_cyclic_positions_move_the_axis_and_hold_it_while_they_come(void) {
  SET(0x60C2, 1, 10);
  SET(0x60C2, 2, (uint8_t)-3);
  enable(0, CSP);
  for (int i = 0; i < 200; ++i) {
    SET(0x607A, 0, (uint32_t)(5000 * (i < 100 ? i : 99)));
    wait_ms(9);
    TEST_ASSERT_EQUAL_HEX32(STATE_ENABLED, node.axis[0].objects.state.statusword & STATE_MASK);
    TEST_ASSERT_TRUE(i < 5 || (node.axis[0].objects.state.statusword & 1u << 12) != 0); /* follows */
    CHECK_NEAR("error for the search for oscillations, rad/s", 0.0, node.axis[0].monitor.swings.last_error_rad_s, 0.05);
  }
  CHECK_NEAR("rad", 99 * 5e-4, machine.axis[0].turns * 6.283185307, 1e-5);
  wait_ms(500);
  TEST_ASSERT_EQUAL(0, node.axis[0].objects.state.statusword & 1u << 12);
}

static void test_a_stop_in_rpdo1_is_obeyed_whatever_mode_it_carries(void) {
  static const uint16_t stops[] = {0x0002, 0x0000, 0x010F, 0x0006,
                                   0x0007}; /* quick stop, off, halt, shutdown, disable */
  for (uint32_t i = 0; i < sizeof stops / sizeof stops[0]; ++i) {
    node_bench_start();
    nmt(1);
    turn_azimuth_at_0_2_rad_s();
    sent_count = 0;
    give(0x200 + NODE_ID, 3, (const uint8_t[]){(uint8_t)stops[i], (uint8_t)(stops[i] >> 8), 2}); /* 2: not supported */
    wait_ms(3);
    const can_frame *reported = last_sent(EMCY);
    TEST_ASSERT_NOT_NULL(reported);
    TEST_ASSERT_EQUAL_HEX8_ARRAY(((const uint8_t[]){0x00, 0x82, 0x11, 1, 0, 0x60, 0x60, 0}), reported->data, 8);
    wait_ms(1000);
    CHECK_NEAR("rad/s", 0.0, stops[i] == 0 || stops[i] == 6 ? 0.0 : machine.axis[0].rate_rad_s, 0.002);
    TEST_ASSERT_NOT_EQUAL(STATE_ENABLED, stops[i] == 0x010F ? 0 : state_of(0));
    TEST_ASSERT_EQUAL(PV, get(0x6060, 0) & 0xFF);
  }
}

static void test_a_period_that_the_drive_cannot_have_is_refused_and_no_other(void) {
  SET(0x60C2, 1, 255);
  TEST_ASSERT_EQUAL_HEX32(0x06090030, set(0x60C2, 2, (uint8_t)-2)); /* 2.55 s */
  TEST_ASSERT_EQUAL_HEX32(0x06090030, set(0x60C2, 2, (uint8_t)-6)); /* 0.255 ms */
  SET(0x60C2, 2, (uint8_t)-4);
  SET(0x60C2, 2, (uint8_t)-3);
}

/* Options, methods and modes of the standard that this drive has not: within the ranges of their objects. */
static void test_what_the_drive_has_not_is_refused(void) {
  static const struct {
    uint16_t index;
    uint8_t value;
  } cases[] = {{0x605A, 3}, {0x605A, 4},  {0x60F2, 3}, {0x60F2, 0x10},
               {0x6098, 1}, {0x6098, 17}, {0x6060, 4}, {0x6060, 5}};
  for (uint32_t i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
    const uint32_t before = get(cases[i].index, 0);
    TEST_ASSERT_EQUAL_HEX32(0x06090030, set(cases[i].index, 0, cases[i].value));
    TEST_ASSERT_EQUAL_HEX32(before, get(cases[i].index, 0));
  }
}

static void test_the_time_out_of_cyclic_setpoints_follows_their_period(void) {
  SET(0x60C2, 1, 100);
  enable(0, CSV);
  for (int i = 0; i < 20; ++i) {
    SET(0x60FF, 0, 50000);
    wait_ms(99);
    CHECK_NEAR("rad/s", 0.05, i < 2 ? 0.05 : machine.axis[0].rate_rad_s, 0.001);
  }
  wait_ms(190);
  CHECK_NEAR("rad/s, within three periods", 0.05, machine.axis[0].rate_rad_s, 0.001);
  wait_ms(500);
  CHECK_NEAR("rad/s", 0.0, machine.axis[0].rate_rad_s, 0.001);
}

/* --- what the board finds
 * ------------------------------------------------------------------------------------------ */

static void test_each_fault_of_the_board_stops_its_axis_alone_and_is_reported(void) {
  static const struct {
    hal_health health;
    uint32_t code;
    bool cuts; /* otherwise the loop brakes */
  } rows[] = {{HAL_OVER_CURRENT, 0x2310, true},      {HAL_POWER_STAGE, 0x5410, true},
              {HAL_TOO_HOT, 0x4310, false},          {HAL_TIMING_LOST, 0x6100, true},
              {HAL_IMAGE_DAMAGED, 0x5520, false},    {HAL_SAFE_TORQUE_OFF, 0x5441, true},
              {HAL_SAFE_TORQUE_FAULT, 0x5442, true}, {HAL_CLOCK_WRONG, 0x5530, false}};
  for (uint32_t i = 0; i < sizeof rows / sizeof rows[0]; ++i) {
    node_bench_start();
    enable(PITCH, PV);
    turn_azimuth_at_0_2_rad_s();
    machine.axis[0].health = rows[i].health;
    sent_count = 0;
    wait_ms(2);
    TEST_ASSERT_EQUAL(rows[i].cuts, machine.axis[0].current_a == 0.0f);
    const can_frame *reported = last_sent(EMCY);
    TEST_ASSERT_NOT_NULL(reported);
    TEST_ASSERT_EQUAL_HEX32(rows[i].code, u32_of(reported->data) & 0xFFFF);
    TEST_ASSERT_EQUAL(1, reported->data[4]); /* azimuth */
    wait_ms(500);
    CHECK_SAME("A at last", 0.0, machine.axis[0].current_a);
    TEST_ASSERT_TRUE(is_in_fault(0));
    TEST_ASSERT_EQUAL_HEX32(rows[i].code, get(0x603F, 0));
    TEST_ASSERT_EQUAL_HEX32(STATE_ENABLED, state_of(PITCH));
    TEST_ASSERT_NOT_EQUAL(0, get(0x1001, 0));
    machine.axis[0].health = HAL_GOOD;
    sent_count = 0;
    give(0x600 + NODE_ID, 8, (const uint8_t[]){0x2B, 0x40, 0x60, 0, 0x80, 0, 0, 0});
    wait_ms(3);
    reported = last_sent(EMCY);
    TEST_ASSERT_NOT_NULL(reported);
    TEST_ASSERT_EQUAL_HEX32(0, u32_of(reported->data) & 0xFFFF);
    TEST_ASSERT_EQUAL(0, get(0x1001, 0));
    TEST_ASSERT_EQUAL_HEX32(STATE_DISABLED, get(0x6041, 0) & 0x4F);
  }
}

static void test_an_axis_whose_self_test_failed_is_never_ready(void) {
  rigid_machine_init(&machine);
  machine.axis[1].health = HAL_NOT_READY;
  TEST_ASSERT_TRUE(rigid_machine_start_node(&machine, &node, NODE_ID, (can_sender){node_bench_send, NULL}, NULL));
  wait_ms(100);
  TEST_ASSERT_EQUAL_HEX32(STATE_NOT_READY, get(0x6041 + PITCH, 0) & 0x4F);
  TEST_ASSERT_EQUAL_HEX32(STATE_DISABLED, get(0x6041, 0) & 0x4F);
  command(PITCH, 0x06);
  command(PITCH, 0x07);
  command(PITCH, 0x0F);
  TEST_ASSERT_EQUAL_HEX32(STATE_NOT_READY, get(0x6041 + PITCH, 0) & 0x4F);
}

static void test_below_its_limit_of_the_bus_the_drive_does_not_switch_on(void) {
  machine.bus_voltage_v = 35.9f;
  command(0, 0x06);
  command(0, 0x07);
  TEST_ASSERT_EQUAL_HEX32(STATE_READY, state_of(0));
  machine.bus_voltage_v = 36.1f;
  wait_ms(2);
  TEST_ASSERT_EQUAL_HEX32(STATE_SWITCHED_ON, state_of(0));
}

static void test_without_an_angle_the_motor_brakes_itself(void) {
  turn_azimuth_at_0_2_rad_s();
  machine.axis[0].encoder_failed = true;
  wait_ms(1);
  pwm();
  CHECK_SAME("duty: shorted", 0.0, machine.axis[0].duty);
  CHECK_NEAR("A, of its own voltage", -0.2 * 2.5 / 1.2, machine.axis[0].current_a, 0.01);
  wait_ms(3000);
  TEST_ASSERT_TRUE(is_in_fault(0));
  /* 2 s with J R / (Kt Ke) = 1.15 s, then off. */
  CHECK_NEAR("rad/s", 0.2 * exp(-2.0 * 2.5 * 2.5 / (6.0 * 1.2)), machine.axis[0].rate_rad_s, 0.001);
  TEST_ASSERT_EQUAL_HEX32(0x7300, get(0x603F, 0) & 0xFF00);
}

/* With an angle again, after 20 ms, the shorted motor brakes on, 0.17 rad/s^2 at most: that is no stop to be judged. */
static void test_an_angle_that_returns_does_not_judge_the_motor_that_brakes_itself(void) {
  turn_azimuth_at_0_2_rad_s();
  machine.axis[0].encoder_failed = true;
  wait_ms(20);
  machine.axis[0].encoder_failed = false;
  for (int ms = 0; ms < 1500; ++ms) {
    wait_ms(1);
    TEST_ASSERT_EQUAL_HEX64(0, node.axis[0].inputs.faults & fault_bit(FAULT_STOP_IGNORED));
  }
}

/* --- what the bus does
 * --------------------------------------------------------------------------------------------- */

static void test_a_master_that_falls_silent_stops_both_axes(void) {
  enable(PITCH, PV);
  turn_azimuth_at_0_2_rad_s();
  SET(0x1016, 1, 0x00010032); /* node 1 every 50 ms */
  give(0x701, 1, (const uint8_t[]){5});
  wait_ms(40);
  TEST_ASSERT_EQUAL_HEX32(STATE_ENABLED, state_of(0));
  wait_ms(20);
  TEST_ASSERT_EQUAL_HEX32(0x8130, get(0x603F, 0));
  TEST_ASSERT_EQUAL_HEX32(0x8130, get(0x603F + PITCH, 0));
  wait_ms(500);
  TEST_ASSERT_TRUE(is_in_fault(0));
  TEST_ASSERT_TRUE(is_in_fault(PITCH));
  CHECK_NEAR("rad/s", 0.0, machine.axis[0].rate_rad_s, 0.005);
}

/* --- a silent master: 6007 ---------------------------------------------------------------------------------------- */

enum { SILENCE_MS = 1000, MASTER_SILENT = 0x8101, LOG = 0x3020 };

static void expect_left_alone(uint8_t source, bool left_alone) {
  const can_frame *reported = last_sent(EMCY);
  TEST_ASSERT_EQUAL(left_alone, reported != NULL);
  if (left_alone) {
    TEST_ASSERT_EQUAL_HEX32(MASTER_SILENT, u32_of(reported->data) & 0xFFFF);
    TEST_ASSERT_EQUAL(FAULT_MASTER_SILENT, reported->data[3]);
    TEST_ASSERT_EQUAL(source, reported->data[4]);
  }
}

static void turn_and_be_silent(uint32_t silent_ms) {
  enable(0, PV);
  SET(0x60FF, 0, 200000);
  sent_count = 0;
  wait_ms(silent_ms - 1); /* SET has waited a ms */
}

static void test_an_axis_that_turns_stops_without_a_fault_after_1_s_without_a_frame(void) {
  TEST_ASSERT_EQUAL(3, get(0x6007, 0) & 0xFFFF);
  TEST_ASSERT_EQUAL(3, get(0x6007 + PITCH, 0) & 0xFFFF);
  enable(PITCH, PV); /* and stands */
  turn_and_be_silent(SILENCE_MS - 2);
  expect_left_alone(1, false);
  CHECK_NEAR("rad/s", 0.2, machine.axis[0].rate_rad_s, 0.002);
  wait_ms(4);
  expect_left_alone(1, true);
  wait_ms(300);
  CHECK_NEAR("rad/s", 0.0, machine.axis[0].rate_rad_s, 0.002);
  const uint32_t statusword = get(0x6041, 0);
  TEST_ASSERT_EQUAL_HEX32(STATE_DISABLED, statusword & 0x4F);
  TEST_ASSERT_NOT_EQUAL(0, statusword & 0x80); /* warning */
  TEST_ASSERT_EQUAL(0, get(0x603F, 0) & 0xFFFF);
  TEST_ASSERT_EQUAL(1, get(LOG, 1));
  TEST_ASSERT_EQUAL(1, get(0x3041, 2));
  TEST_ASSERT_NOT_EQUAL(0, get(0x1001, 0) & 0xFF);
  TEST_ASSERT_EQUAL_HEX32(STATE_ENABLED, state_of(PITCH));
  wait_ms(5000); /* it stays off */
  TEST_ASSERT_EQUAL_HEX32(STATE_DISABLED, get(0x6041, 0) & 0x4F);
  TEST_ASSERT_EQUAL_HEX32(STATE_ENABLED, state_of(PITCH)); /* an axis at rest may be left alone */
  enable(0, PV);
  wait_ms(2);
  TEST_ASSERT_EQUAL(0, get(0x1001, 0) & 0xFF);
  TEST_ASSERT_EQUAL(0, get(0x6041, 0) & 0x80);
  SET(0x60FF, 0, 0);
  SET(0x60FF + PITCH, 0, 200000); /* the other way round */
  wait_ms(SILENCE_MS + 300);
  TEST_ASSERT_EQUAL_HEX32(STATE_DISABLED, get(0x6041 + PITCH, 0) & 0x4F);
  TEST_ASSERT_EQUAL_HEX32(STATE_ENABLED, state_of(0));
  enable(PITCH, PV);
  wait_ms(2);
  TEST_ASSERT_EQUAL(0, get(0x1001, 0) & 0xFF);
  TEST_ASSERT_EQUAL(0, get(0x6041 + PITCH, 0) & 0x80);
}

static void test_6007_chooses_between_going_on_a_fault_and_switching_off(void) {
  for (uint32_t option = 0; option <= 2; ++option) {
    node_bench_start();
    SET(0x6007, 0, option);
    turn_and_be_silent(SILENCE_MS + 5);
    expect_left_alone(1, option != 0);
    TEST_ASSERT_EQUAL(option == 2, machine.axis[0].current_a == 0.0f);
    wait_ms(500);
    TEST_ASSERT_EQUAL(option == 1, is_in_fault(0));
    TEST_ASSERT_EQUAL_HEX32(option == 1 ? MASTER_SILENT : 0, get(0x603F, 0) & 0xFFFF);
    TEST_ASSERT_EQUAL_HEX32(option == 0 ? 0x0F : option == 1 ? 0x0F : 0, get(0x6040, 0) & 0xFFFF);
  }
  TEST_ASSERT_EQUAL_HEX32(0x06090031, set(0x6007, 0, 4));
}

static void test_a_quick_stop_that_stays_is_not_ended_by_any_frame(void) {
  SET(0x605A, 0, 6);
  turn_and_be_silent(SILENCE_MS + 5);
  wait_ms(500);
  TEST_ASSERT_EQUAL_HEX32(STATE_QUICK_STOP, state_of(0));
  wait_ms(100);
  TEST_ASSERT_EQUAL_HEX32(STATE_QUICK_STOP, state_of(0));
  command(0, 0x0F);
  TEST_ASSERT_EQUAL_HEX32(STATE_ENABLED, state_of(0));
}

static void test_the_longest_silence_can_be_set_and_is_stored(void) {
  SET(0x3041, 1, 100);
  TEST_ASSERT_EQUAL_HEX32(0x06090032, set(0x3041, 1, 49));
  turn_and_be_silent(98);
  expect_left_alone(1, false);
  wait_ms(5);
  expect_left_alone(1, true);
}

/* What counts as a frame for the node: each is sent every 0.9 s while azimuth turns. */
typedef struct {
  uint32_t id;
  uint8_t length;
  uint8_t bytes[8];
  bool counts;
} spoken;

static void test_what_is_addressed_to_the_node_ends_the_silence_and_nothing_else(void) {
  static const spoken frames[] = {
      {0x000, 2, {1, NODE_ID}, true},
      {0x000, 2, {1, 0}, true},
      {0x000, 2, {1, NODE_ID + 1}, false},
      {0x600 + NODE_ID, 8, {0x40, 0x41, 0x60}, true},
      {0x600 + NODE_ID, 8, {0x80}, true}, /* an abort */
      {0x600 + NODE_ID + 1, 8, {0x40, 0x41, 0x60}, false},
      {0x300 + NODE_ID, 3, {0, 0, PV}, true},
      {0x300 + NODE_ID + 1, 3, {0, 0, PV}, false},
      {0x080, 0, {0}, false}, /* no PDO is synchronous */
      {0x701, 1, {5}, false}, /* not in 1016 */
      {0x7E5, 8, {0x04, 0}, false},
      {0x180 + NODE_ID + 1, 8, {0}, false},
  };
  for (uint32_t i = 0; i < sizeof frames / sizeof frames[0]; ++i) {
    node_bench_start();
    nmt(1);
    turn_and_be_silent(900);
    for (int n = 0; n < 4; ++n) {
      give(frames[i].id, frames[i].length, frames[i].bytes);
      wait_ms(900);
    }
    char message[32];
    (void)snprintf(message, sizeof message, "frame %u, %03X", (unsigned)i, (unsigned)frames[i].id);
    TEST_ASSERT_EQUAL_MESSAGE(frames[i].counts ? 0 : 1, get(0x3041, 2), message);
  }
}

static void test_sync_counts_while_a_pdo_is_synchronous(void) {
  SET(0x1800, 1, 0xC0000180 + NODE_ID);
  SET(0x1800, 2, 10);
  SET(0x1800, 1, 0x40000180 + NODE_ID);
  nmt(1);
  turn_and_be_silent(900);
  for (int n = 0; n < 4; ++n) {
    give(0x080, 0, (const uint8_t[]){0});
    wait_ms(900);
  }
  TEST_ASSERT_EQUAL(0, get(0x3041, 2));
}

static void test_rpdos_of_a_node_that_is_not_operational_do_not_count(void) {
  turn_and_be_silent(900);
  for (int n = 0; n < 2; ++n) {
    give(0x300 + NODE_ID, 3, (const uint8_t[]){0, 0, PV});
    wait_ms(900);
  }
  TEST_ASSERT_EQUAL(1, get(0x3041, 2));
}

static void test_a_monitored_heartbeat_may_be_as_slow_as_1016_says(void) {
  SET(0x1016, 1, 1 << 16 | 3000);
  give(0x701, 1, (const uint8_t[]){5});
  turn_and_be_silent(900);
  for (int n = 0; n < 4; ++n) {
    give(0x701, 1, (const uint8_t[]){5});
    wait_ms(2900);
  }
  TEST_ASSERT_EQUAL(0, get(0x3041, 2));
  wait_ms(200);
  TEST_ASSERT_EQUAL_HEX32(0x8130, get(0x603F, 0) & 0xFFFF);
}

static void test_an_rpdo_with_an_event_timer_may_be_as_slow_as_it_says(void) {
  SET(0x1401, 5, 3000);
  nmt(1);
  turn_and_be_silent(900);
  for (int n = 0; n < 3; ++n) {
    give(0x300 + NODE_ID, 3, (const uint8_t[]){0, 0, PV});
    wait_ms(2900);
  }
  TEST_ASSERT_EQUAL(0, get(0x3041, 2));
}

static void test_an_axis_that_has_arrived_in_pp_is_not_stopped(void) {
  enable(0, 1);
  SET(0x607A, 0, 100000);
  command(0, 0x1F);
  wait_ms(900);
  TEST_ASSERT_NOT_EQUAL(0, get(0x6041, 0) & 0x400);
  wait_ms(3000);
  TEST_ASSERT_EQUAL_HEX32(STATE_ENABLED, state_of(0));
}

static void test_setpoints_that_stay_away_stop_the_axis(void) {
  SET(0x1402, 1, 0x80000400 + NODE_ID);
  SET(0x1402, 5, 20); /* ms */
  SET(0x1402, 1, 0x00000400 + NODE_ID);
  nmt(1);
  turn_azimuth_at_0_2_rad_s(); /* not supervised before the first one */
  give(0x400 + NODE_ID, 8, (const uint8_t[]){0x40, 0x0D, 0x03, 0, 0, 0, 0, 0});
  wait_ms(15);
  TEST_ASSERT_EQUAL_HEX32(0, get(0x603F, 0));
  wait_ms(10);
  TEST_ASSERT_EQUAL_HEX32(0x8250, get(0x603F, 0));
}

static void test_an_nmt_stop_stops_an_axis_that_turns(void) {
  nmt(1);
  turn_azimuth_at_0_2_rad_s();
  nmt(2);
  wait_ms(500);
  CHECK_NEAR("rad/s", 0.0, machine.axis[0].rate_rad_s, 0.005);
  nmt(128);
  TEST_ASSERT_EQUAL_HEX32(0x8100, get(0x603F, 0));
}

static void test_a_reset_of_the_communication_stops_an_axis_that_turns_and_no_other(void) {
  turn_azimuth_at_0_2_rad_s();
  nmt(130);
  wait_ms(RESET_MS);
  TEST_ASSERT_EQUAL_HEX32(0x8100, get(0x603F, 0));
  node_bench_start();
  nmt(130);
  wait_ms(RESET_MS);
  TEST_ASSERT_EQUAL_HEX32(0, get(0x603F, 0));
}

static void test_a_fault_that_outlives_a_reset_of_the_communication_is_reported_again(void) {
  turn_azimuth_at_0_2_rad_s();
  machine.axis[0].health = HAL_TOO_HOT;
  wait_ms(500);
  nmt(130);
  sent_count = 0;
  wait_ms(RESET_MS);
  TEST_ASSERT_EQUAL_HEX32(0x4310, newest_error());
}

static void test_a_reset_of_the_node_is_a_fresh_start(void) {
  enable(PITCH, PV);
  turn_azimuth_at_0_2_rad_s();
  SET(0x3000, 3, 7);
  SET_FLOAT(0x2000, 1, 500.0f);
  SET(0x2070, 1, 1);
  for (int i = 0; i < SERVO_AXES; ++i) {
    TEST_ASSERT_TRUE(machine.axis[i].powered);
  }
  sent_count = 0;
  nmt(129);
  CHECK_SAME("A", 0.0, machine.axis[0].current_a); /* at once; the objects take longer */
  for (int i = 0; i < SERVO_AXES; ++i) {
    TEST_ASSERT_FALSE(machine.axis[i].powered);
  }
  wait_ms(RESET_MS);
  const can_frame *boot_up = last_sent(HEARTBEAT);
  TEST_ASSERT_NOT_NULL(boot_up);
  TEST_ASSERT_EQUAL(0, boot_up->data[0]);
  TEST_ASSERT_EQUAL_HEX32(STATE_DISABLED, get(0x6041, 0) & 0x4F);
  TEST_ASSERT_EQUAL(1, get(0x3000, 3));
  TEST_ASSERT_EQUAL(0, get(0x2070, 1) & 0xFF);
  CHECK_SAME("gain", 720.0, get_float(0x2000, 1));
}

/* It was stopping; now nothing is ordered, and without friction it turns on. */
static void test_a_reset_of_the_node_ends_an_ordered_stop(void) {
  turn_azimuth_at_0_2_rad_s();
  command(0, 0x02);
  wait_ms(20);
  nmt(129);
  wait_ms(3000);
  CHECK_AT_LEAST("turns, rad/s", 0.15, machine.axis[0].rate_rad_s);
  TEST_ASSERT_EQUAL_HEX32(STATE_DISABLED, get(0x6041, 0) & 0x4F);
}

/* A fault brakes both axes by the shorted motor for 2 s. The reset does not set them free. */
static void test_a_reset_of_the_node_does_not_end_a_braking(void) {
  turn_azimuth_at_0_2_rad_s();
  machine.bus_voltage_v = 65.0f;
  wait_ms(10);
  TEST_ASSERT_EQUAL(SERVO_BRAKE, node.board.app.axis[0].mode);
  nmt(129);
  wait_ms(1900);
  TEST_ASSERT_EQUAL(SERVO_BRAKE, node.board.app.axis[0].mode);
  wait_ms(200);
  TEST_ASSERT_EQUAL(SERVO_OFF, node.board.app.axis[0].mode);
  TEST_ASSERT_EQUAL_HEX32(0x08, get(0x6041, 0) & 0x4F); /* fault */
}

static void test_a_queue_that_is_full_loses_frames_and_says_so(void) {
  const can_frame frame = {.id = 0x080, .length = 0};
  uint32_t taken = 0;
  while (taken < 2 * SERVO_NODE_QUEUE && servo_node_receive(&node, &frame)) {
    ++taken;
  }
  TEST_ASSERT_EQUAL(SERVO_NODE_QUEUE, taken);
  sent_count = 0;
  wait_ms(20);
  const can_frame *reported = last_sent(EMCY);
  TEST_ASSERT_NOT_NULL(reported);
  TEST_ASSERT_EQUAL_HEX32(0x8110, u32_of(reported->data) & 0xFFFF);
}

/* --- objects
 * -------------------------------------------------------------------------------------------------------- */

/* 2010:2 limits the position loop. A ramp of pp or csp that were faster would leave the axis behind. */
static void test_a_move_is_no_faster_than_the_position_loop(void) {
  static const int8_t modes[] = {1, CSP};
  for (unsigned i = 0; i < sizeof modes / sizeof modes[0]; ++i) {
    node_bench_start();
    SET_FLOAT(0x2010, 2, 0.1f);
    SET(0x2070, 1, 1);
    SET(0x6007, 0, 0);
    SET(0x6081, 0, 500000);
    enable(0, modes[i]);
    SET(0x607A, 0, 2000000);
    command(0, 0x1F);
    double fastest_rad_s = 0.0;
    for (int ms = 0; ms < 1500; ++ms) {
      wait_ms(1);
      fastest_rad_s = fmax(fastest_rad_s, fabs((double)node.axis[0].drive.motion.ramp.rate_rad_s));
      CHECK_NEAR("behind, 1e-7 rad", 0.0, (double)(int32_t)node.axis[0].objects.position.following_error, 50000.0);
    }
    CHECK_NEAR("rad/s", 0.1, fastest_rad_s, 1e-3);
    TEST_ASSERT_EQUAL_HEX32(STATE_ENABLED, state_of(0));
  }
}

/* 607F = FFFFFFFF is the usual value for "no limit": the limit is then 80 % of 2060:1, whatever the other objects
 * are. */
static void test_no_limit_of_607f_leaves_the_machine_its_own(void) {
  enable(0, 3);
  SET(0x607F, 0, UINT32_MAX);
  SET(0x60FF, 0, INT32_MAX);
  SET(0x6007, 0, 0);
  wait_ms(4000);
  TEST_ASSERT_EQUAL_HEX32(STATE_ENABLED, state_of(0));
  CHECK_NEAR("rad/s", 0.8 * 1.5, machine.axis[0].rate_rad_s, 0.01);
  TEST_ASSERT_TRUE((get(0x6041, 0) & 1u << 11) != 0);
}

/* No value that an object accepts causes a sensor fault (7300). */
static void test_the_largest_values_of_all_objects_are_plausible(void) {
  static const struct {
    uint16_t index;
    uint8_t sub;
    uint32_t value;
  } largest[] = {{0x607F, 0, UINT32_MAX}, {0x6081, 0, UINT32_MAX}, {0x6083, 0, UINT32_MAX}, {0x6084, 0, UINT32_MAX},
                 {0x6085, 0, UINT32_MAX}, {0x60A4, 1, UINT32_MAX}, {0x6087, 0, UINT32_MAX}, {0x6076, 0, UINT32_MAX},
                 {0x6072, 0, 0xFFFF},     {0x60E0, 0, 0xFFFF},     {0x60E1, 0, 0xFFFF},     {0x60FF, 0, INT32_MAX},
                 {0x60B1, 0, INT32_MAX},  {0x60B2, 0, INT16_MAX},  {0x6071, 0, INT16_MAX},  {0x607A, 0, INT32_MAX}};
  static const int8_t modes[] = {0, 1, 3, 6, 8, 9, 10};
  SET(0x3040, 1, 0x6E65706Fu);
  SET_FLOAT(0x2060, 1, 1000.0f); /* then there is no other limit */
  SET_FLOAT(0x2060, 6, 1000.0f);
  for (unsigned i = 0; i < sizeof largest / sizeof largest[0]; ++i) {
    SET(largest[i].index, largest[i].sub, largest[i].value);
  }
  for (unsigned m = 0; m < sizeof modes; ++m) {
    SET(0x6060, 0, (uint8_t)modes[m]);
    command(0, 0x80);
    command(0, 0x06);
    command(0, 0x07);
    for (int i = 0; i < 20; ++i) {
      command(0, (uint16_t)(0x0F | (i % 2 == 0 ? 0x30 : 0)));
      SET(0x60FF, 0, i % 4 < 2 ? (uint32_t)INT32_MAX : (uint32_t)INT32_MIN);
      SET(0x607A, 0, i % 4 < 2 ? (uint32_t)INT32_MAX : (uint32_t)INT32_MIN);
      SET(0x6071, 0, i % 4 < 2 ? (uint32_t)INT16_MAX : (uint16_t)INT16_MIN);
      TEST_ASSERT_FALSE_MESSAGE(node.board.app.axis[0].implausible, "refused by the servo axis");
    }
    command(0, 0x00);
    rigid_machine_init(&machine);
    wait_ms(20);
  }
}

/* CiA 301, 1000: a device of several, and the type of each of them. */
static void test_the_device_types_are_those_of_two_drives_on_one_node(void) {
  TEST_ASSERT_EQUAL_HEX32(0xFFFF0192, get(0x1000, 0));
  TEST_ASSERT_EQUAL_HEX32(0x00020192, get(0x67FF, 0));
  TEST_ASSERT_EQUAL_HEX32(0x00020192, get(0x6FFF, 0));
}

static void test_the_motion_profile_is_jerk_limited_and_no_other(void) {
  for (uint16_t shift = 0; shift <= 0x800; shift = (uint16_t)(shift + 0x800)) {
    const uint16_t index = (uint16_t)(0x6086 + shift);
    TEST_ASSERT_EQUAL(3, get(index, 0));
    SET(index, 0, 3);
    TEST_ASSERT_EQUAL_HEX32(0x06090032, set(index, 0, 0)); /* linear */
    TEST_ASSERT_EQUAL_HEX32(0x06090032, set(index, 0, 2)); /* jerk-free */
    TEST_ASSERT_EQUAL_HEX32(0x06090031, set(index, 0, 4));
    TEST_ASSERT_EQUAL(3, get(index, 0));
  }
}

static void test_what_the_drive_cannot_do_is_refused(void) {
  TEST_ASSERT_EQUAL_HEX32(0x06090030, set(0x605A, 0, 3));
  TEST_ASSERT_EQUAL_HEX32(0x06090030, set(0x6060, 0, 7)); /* interpolated position */
  TEST_ASSERT_EQUAL(2, get(0x605A, 0));
  TEST_ASSERT_EQUAL(0, get(0x6060, 0));
  SET(0x605A, 0, 6);
  SET(0x6060, 0, 0);
}

static void test_staged_gains_come_into_force_in_one_piece(void) {
  const servo_axis_params before = node.board.app.params.axis[0];
  SET_FLOAT(0x2000, 1, 500.0f);
  SET_FLOAT(0x2000, 2, 9000.0f);
  TEST_ASSERT_EQUAL_MEMORY(&before, &node.board.app.params.axis[0], sizeof before);
  TEST_ASSERT_EQUAL(3, get(0x2070, 2) | 2); /* staged */
  SET(0x2070, 1, 1);
  CHECK_SAME("proportional", 500.0, node.board.app.params.axis[0].speed.pi.proportional_gain);
  CHECK_SAME("integral", 9000.0, node.board.app.params.axis[0].speed.pi.integral_gain);
  TEST_ASSERT_EQUAL(2, get(0x2070, 2)); /* not stored */
  SET(0x2070, 1, 3);
  TEST_ASSERT_EQUAL_MEMORY(&before, &node.board.app.params.axis[0], sizeof before);
  SET_FLOAT(0x2000, 1, 400.0f);
  SET(0x2070, 1, 2);
  CHECK_SAME("staged again", 720.0, get_float(0x2000, 1));
  SET(0x2070, 1, 0);
}

/* The answer waits for the check, which takes more than a ms. */
static void test_gains_that_are_unstable_stay_staged(void) {
  SET_FLOAT(0x2000, 1, 20000.0f);
  TEST_ASSERT_EQUAL_HEX32(0x06040043, set(0x2070, 1, 1));
  CHECK_SAME("in force", 720.0, node.board.app.params.axis[0].speed.pi.proportional_gain);
  CHECK_SAME("staged", 20000.0, get_float(0x2000, 1));
  TEST_ASSERT_EQUAL_HEX32(PARAMETER_OBJECT(0x2000, 1), get(0x2070, 6));
  TEST_ASSERT_EQUAL_HEX32(0, get(0x2070, 9)); /* no other value is in its way */
  SET(0x2070, 1, 2);
}

/* Only the azimuth's inertia changes with the pitch. */
static void test_the_gains_of_the_azimuth_are_judged_as_they_follow_its_inertia(void) {
  TEST_ASSERT_TRUE(node.axis[SERVO_AZIMUTH].tuning.gains_follow);
  TEST_ASSERT_FALSE(node.axis[SERVO_PITCH].tuning.gains_follow);
}

/* 2050:1 = 1 and 2011:1 = 1 have the number of the command "apply", but are values of the staged set. */
static void test_a_staged_value_is_no_command(void) {
  const servo_axis_params before = node.board.app.params.axis[0];
  SET_FLOAT(0x2000, 1, 500.0f);
  SET(0x2011, 1, 0);
  SET(0x2011, 1, 1);
  SET(0x2020, 1, 0);
  SET(0x2020, 1, 1);
  SET(0x2050, 1, 1);
  TEST_ASSERT_EQUAL_MEMORY(&before, &node.board.app.params.axis[0], sizeof before);
}

/* Whatever the timer held before: until the first period the bridge pushes nothing. */
static void test_a_board_that_starts_sets_every_duty_to_0(void) {
  const servo_params params = node.board.app.params;
  for (int i = 0; i < SERVO_AXES; ++i) {
    machine.axis[i].duty = 0.7f;
  }
  CHECK_STATUS(CONTROL_OK, servo_board_start(&node.board, &machine.functions, &params));
  for (int i = 0; i < SERVO_AXES; ++i) {
    CHECK_SAME("duty", 0.0, machine.axis[i].duty);
  }
}

/* Static memory is cleared, but a restart without a loss of power is not. */
static void test_a_board_starts_off_at_its_angles_whatever_was_in_its_memory(void) {
  static servo_board board;
  const servo_params params = node.board.app.params;
  machine.axis[0].turns = 0.3;
  machine.axis[1].turns = -0.4;
  memset(&board, 0x5A, sizeof board);
  CHECK_STATUS(CONTROL_OK, servo_board_start(&board, &machine.functions, &params));
  servo_board_pwm_period(&board, 1);
  servo_board_tick(&board);
  for (int i = 0; i < SERVO_AXES; ++i) {
    TEST_ASSERT_EQUAL_INT(SERVO_OFF, board.app.axis[i].mode);
    TEST_ASSERT_FALSE(board.app.axis[i].implausible);
    CHECK_SAME("rad/s", 0.0, board.app.axis[i].signals.rates.joint_rate_rad_s);
    CHECK_SAME("A", 0.0, board.app.axis[i].current_reference_a);
    CHECK_SAME("duty", 0.0, machine.axis[i].duty);
    TEST_ASSERT_FALSE(machine.axis[i].powered);
  }
}

/* What has changed since the start: the voltage of the bus, an angle, and what the current loop has seen. */
static void test_each_tick_of_a_board_takes_new_samples(void) {
  static servo_board board;
  const servo_params params = node.board.app.params;
  CHECK_STATUS(CONTROL_OK, servo_board_start(&board, &machine.functions, &params));
  machine.bus_voltage_v = 47.0f;
  machine.axis[1].turns = 1.0 / 65536.0;
  atomic_store(&board.motor[0].tick_voltage_v, 3.0f);
  atomic_store(&board.motor[1].limited, true);
  servo_board_tick(&board);
  CHECK_SAME("V", 47.0, board.samples.bus_voltage_v);
  TEST_ASSERT_EQUAL_HEX32(0x10000, board.samples.axis[1].sensors.joint_angle_turn32);
  CHECK_SAME("V", 3.0, board.samples.axis[0].tick_voltage_v);
  TEST_ASSERT_FALSE(board.samples.axis[0].motor_limited);
  TEST_ASSERT_TRUE(board.samples.axis[1].motor_limited); /* the bus could not give what its loop wanted */
}

static unsigned duties_set;

static void note_duty(void *of, int axis, float duty) {
  (void)of;
  (void)duty;
  TEST_ASSERT_TRUE(axis >= 0 && axis < SERVO_AXES);
  duties_set += 1u << 8 * axis;
}

static float no_current_a(void *of, int axis) {
  (void)of;
  TEST_ASSERT_TRUE(axis >= 0 && axis < SERVO_AXES);
  return 0.0f;
}

/* And asks the machine for no axis that it does not have. */
static void test_a_pwm_period_sets_the_duty_of_each_axis_once(void) {
  static servo_board board;
  const servo_params params = node.board.app.params;
  hal functions = machine.functions;
  functions.set_duty = note_duty;
  functions.current_a = no_current_a;
  CHECK_STATUS(CONTROL_OK, servo_board_start(&board, &functions, &params));
  duties_set = 0;
  servo_board_pwm_period(&board, 1);
  TEST_ASSERT_EQUAL_HEX32(0x0101, duties_set);
}

static void test_a_board_with_wrong_parameters_of_either_axis_does_not_start(void) {
  for (int i = 0; i < SERVO_AXES; ++i) {
    servo_board board = node.board;
    servo_params params = node.board.app.params;
    params.axis[i].torque_constant_nm_a = -1.0f;
    CHECK_STATUS(CONTROL_OUT_OF_RANGE, servo_board_start(&board, &machine.functions, &params));
    CHECK_SAME("in force", node.board.app.params.axis[i].torque_constant_nm_a,
               board.app.params.axis[i].torque_constant_nm_a);
  }
}

static void test_gains_that_do_not_fit_together_are_refused_with_the_reason(void) {
  const servo_axis_params before = node.board.app.params.axis[1];
  const float breakaway_nm = get_float(0x2030 + PITCH, 8);
  SET_FLOAT(0x2030 + PITCH, 7, 2.0f * breakaway_nm); /* Coulomb above break-away */
  TEST_ASSERT_EQUAL_HEX32(0x06040043, set(0x2070 + PITCH, 1, 1));
  TEST_ASSERT_EQUAL(CONTROL_INCONSISTENT, get(0x2070 + PITCH, 3));
  TEST_ASSERT_EQUAL_HEX32(PARAMETER_OBJECT(0x2030 + PITCH, 8), get(0x2070 + PITCH, 6));
  TEST_ASSERT_EQUAL_HEX32(PARAMETER_OBJECT(0x2030 + PITCH, 7), get(0x2070 + PITCH, 9));
  TEST_ASSERT_EQUAL_MEMORY(&before, &node.board.app.params.axis[1], sizeof before);
  SET(0x2070 + PITCH, 1, 2);
  SET_FLOAT(0x2040 + PITCH, 1, 100.0f); /* a notch as wide as the sampling rate */
  SET_FLOAT(0x2040 + PITCH, 2, 980.0f);
  TEST_ASSERT_EQUAL_HEX32(0x06040043, set(0x2070 + PITCH, 1, 1));
  TEST_ASSERT_EQUAL(CONTROL_OUT_OF_RANGE, get(0x2070 + PITCH, 3));
}

static void test_filters_that_are_set_are_in_force(void) {
  const biquad_params pass = biquad_pass();
  SET_FLOAT(0x2040, 1, 90.0f);
  SET_FLOAT(0x2040, 4, 200.0f);
  SET(0x2070, 1, 1);
  const speed_loop_params *speed = &node.board.app.params.axis[0].speed;
  TEST_ASSERT_NOT_EQUAL(0, memcmp(&pass, &speed->notch, sizeof pass));
  TEST_ASSERT_NOT_EQUAL(0, memcmp(&pass, &speed->lowpass, sizeof pass));
}

static void test_the_recorded_tick_is_one_tick(void) {
  enable(0, CST);
  SET(0x6071, 0, 50);
  machine.axis[0].friction_nm = 3.0; /* more than that */
  wait_ms(3);
  CHECK_NEAR("torque, N m", 2.0, get_float(0x2101, 7), 1e-4);
  CHECK_NEAR("reference, N m", 2.0, get_float(0x2101, 8), 1e-4);
  TEST_ASSERT_EQUAL(0, get(0x2101, 2));
  const uint32_t number = get(0x2101, 1) & 0xFFFF;
  wait_ms(10);
  TEST_ASSERT_EQUAL(number + 11, get(0x2101, 1) & 0xFFFF);
  TEST_ASSERT_EQUAL_HEX32(node.board.samples.axis[0].sensors.joint_angle_turn32, get(0x2101, 4));
  machine.axis[0].friction_nm = 0.0;
  for (int i = 0; i < 50; ++i) { /* in 0.5 s 2 Nm turn 6 kg m^2 by 42 mrad */
    SET(0x6071, 0, 50);
    wait_ms(9);
  }
  CHECK_NEAR("joint angle, turns", machine.axis[0].turns, get(0x2101, 4) / 4294967296.0, 1e-4);
  CHECK_NEAR("turns", 0.042 / 6.283185307, machine.axis[0].turns, 2e-4);
  machine.axis[0].gyro_missing = true;
  wait_ms(2);
  TEST_ASSERT_TRUE(isnan(get_float(0x2101, 6)));
}

/* --- start
 * ---------------------------------------------------------------------------------------------------------- */

static void test_it_does_not_start_with_a_wrong_node_id(void) {
  TEST_ASSERT_FALSE(rigid_machine_start_node(&machine, &node, 0, (can_sender){node_bench_send, NULL}, NULL));
  TEST_ASSERT_FALSE(rigid_machine_start_node(&machine, &node, 128, (can_sender){node_bench_send, NULL}, NULL));
}

static void test_it_has_its_serial_number_and_does_not_start_with_wrong_parameters(void) {
  axis_parameters parameters[SERVO_AXES] = {node.axis[0].tuning.active, node.axis[1].tuning.active};
  const protection_limits limits[SERVO_AXES] = {node.axis[0].monitor.limits, node.axis[1].monitor.limits};
  servo_node_config config = {
      NODE_ID, {node_bench_send, NULL}, &machine.functions, parameters, limits, NULL, 4711, {0}, "test board", NULL};
  TEST_ASSERT_TRUE(servo_node_start(&node, &config));
  wait_ms(2);
  TEST_ASSERT_EQUAL_UINT32(4711, get(0x1018, 4));
  TEST_ASSERT_EQUAL_STRING("test board", node.canopen.objects.hardware_version);
  nmt(0x81); /* a reset of the node does not change it */
  wait_ms(RESET_MS);
  TEST_ASSERT_EQUAL_UINT32(4711, get(0x1018, 4));
  TEST_ASSERT_EQUAL_STRING("test board", node.canopen.objects.hardware_version);
  parameters[1].observer.inertia_kg_m2 = -1.0f;
  TEST_ASSERT_FALSE(servo_node_start(&node, &config));
  parameters[1].observer.inertia_kg_m2 = 2.0f;
  parameters[0].motor.torque_constant_nm_a = 0.0f;
  TEST_ASSERT_FALSE(servo_node_start(&node, &config));
  parameters[0].motor.torque_constant_nm_a = 2.5f;
  hal_scales scales = {
      .current_full_scale_a = {10.0f, 20.0f}, .over_current_a = {8.0f, 9.0f}, .voltage_full_scale_v = 80.0f};
  config.scales = &scales;
  TEST_ASSERT_TRUE(servo_node_start(&node, &config));
  TEST_ASSERT_EQUAL_FLOAT(80.0f, machine.scales.voltage_full_scale_v);
  scales.voltage_full_scale_v = 0.0f;
  TEST_ASSERT_FALSE(servo_node_start(&node, &config));
}

static int32_t software_limit(uint16_t shift, uint8_t sub) { return (int32_t)get((uint16_t)(0x607D + shift), sub); }

/* Without a tick so far. */
static void test_a_node_that_has_started_knows_what_its_machine_measures(void) {
  rigid_machine_init(&machine);
  machine.axis[0].turns = 0.125;
  machine.axis[1].turns = 0.0625;
  machine.bus_voltage_v = 47.0f;
  const can_sender sender = {node_bench_send, NULL};
  TEST_ASSERT_TRUE(rigid_machine_start_node(&machine, &node, NODE_ID, sender, NULL));
  TEST_ASSERT_EQUAL_HEX32(0x20000000, node.board.samples.axis[0].sensors.joint_angle_turn32);
  TEST_ASSERT_EQUAL_HEX32(0x10000000, node.board.samples.axis[1].sensors.joint_angle_turn32);
  CHECK_SAME("V", 47.0, node.board.samples.bus_voltage_v);
}

static void test_software_limits_are_at_first_a_degree_inside_the_hard_ones(void) {
  const axis_parameters parameters[SERVO_AXES] = {node.axis[0].tuning.active, node.axis[1].tuning.active};
  protection_limits limits[SERVO_AXES] = {node.axis[0].monitor.limits, node.axis[1].monitor.limits};
  servo_node_config config = {
      NODE_ID, {node_bench_send, NULL}, &machine.functions, parameters, limits, NULL, 0, {0}, "test board", NULL};
  limits[0].minimum_rad = -1.0f;
  limits[0].maximum_rad = 2.0f;
  limits[1].minimum_rad = limits[1].maximum_rad = 0.0f; /* no hard limits */
  TEST_ASSERT_TRUE(servo_node_start(&node, &config));
  wait_ms(2);
  TEST_ASSERT_EQUAL_INT32(-10000000 + 174533, software_limit(0, 1));
  TEST_ASSERT_EQUAL_INT32(20000000 - 174533, software_limit(0, 2));
  TEST_ASSERT_EQUAL_INT32(0, software_limit(PITCH, 1));
  TEST_ASSERT_EQUAL_INT32(0, software_limit(PITCH, 2));
  SET(0x607D, 1, (uint32_t)-5000);
  SET(0x607D, 2, 5000);
  nmt(0x81); /* resets the node */
  wait_ms(RESET_MS);
  TEST_ASSERT_EQUAL_INT32(-10000000 + 174533, software_limit(0, 1));
  TEST_ASSERT_EQUAL_INT32(20000000 - 174533, software_limit(0, 2));
  limits[0].minimum_rad = 1.935f; /* 3.7 degrees are left, fewer than 4 */
  TEST_ASSERT_TRUE(servo_node_start(&node, &config));
  wait_ms(2);
  TEST_ASSERT_EQUAL_INT32(0, software_limit(0, 1));
  TEST_ASSERT_EQUAL_INT32(0, software_limit(0, 2));
}

static uint32_t remote_bit(int axis) { return node.axis[axis].objects.state.statusword & 0x0200u; }

/* "Remote": the axis obeys the bus in each NMT state but "stopped". */
static void test_an_axis_is_remote_unless_the_node_is_stopped(void) {
  for (int axis = 0; axis < SERVO_AXES; ++axis) {
    TEST_ASSERT_EQUAL(NMT_PRE_OPERATIONAL, node.canopen.state);
    TEST_ASSERT_EQUAL_HEX32(0x0200, remote_bit(axis));
    nmt(1);
    wait_ms(1);
    TEST_ASSERT_EQUAL_HEX32(0x0200, remote_bit(axis));
    nmt(2);
    wait_ms(1);
    TEST_ASSERT_EQUAL(NMT_STOPPED, node.canopen.state);
    TEST_ASSERT_EQUAL_HEX32(0, remote_bit(axis));
    nmt(130);
    wait_ms(3);
    TEST_ASSERT_EQUAL(NMT_INITIALISING, node.canopen.state);
    TEST_ASSERT_EQUAL_HEX32(0x0200, remote_bit(axis));
    wait_ms(RESET_MS);
  }
}

/* The machine has no friction: at a constant rate the loop takes back what is fed forward for it. */
static void test_the_search_for_oscillations_knows_what_the_loop_itself_gives(void) {
  SET(0x6007, 0, 0); /* the master may be silent */
  enable(0, PV);
  SET(0x60FF, 0, 200000);
  wait_ms(120); /* while it still speeds up, with 6 kg m^2 */
  const servo_axis *servo = &node.board.app.axis[0];
  CHECK_AT_LEAST("to speed up, Nm", 2.0, servo->signals.torque.acceleration_nm);
  CHECK_NEAR("all but friction, Nm", -(double)servo->signals.torque.friction_nm,
             node.axis[0].monitor.swings.last_feedback_nm, 0.7);
  wait_ms(2000);
  const float fed_nm = node.board.app.axis[0].signals.torque.friction_nm;
  CHECK_AT_LEAST("fed forward, Nm", 1.0, fed_nm);
  CHECK_NEAR("by the loop, Nm", -(double)fed_nm, node.axis[0].monitor.swings.last_feedback_nm, 0.1);
  CHECK_NEAR("in all, Nm", 0.0, node.axis[0].monitor.swings.last_loop_nm, 0.1);
}

/* The search for oscillations compares the set-point with the joint's rate; for a loop on the gyro alone, with the
 * gyro's, as long as it answers. */
static void test_an_axis_that_follows_has_no_rate_error_for_the_search_of_oscillations(void) {
  static const struct {
    uint32_t source;
    bool gyro_missing;
    float gyro_error_rad_s;
  } rows[] = {{0, false, 0.0f}, {0, false, 0.0025f}, {0, true, 0.0f}, {1, false, 0.0f}, {2, false, 0.0f}};
  for (uint32_t i = 0; i < sizeof rows / sizeof rows[0]; ++i) {
    node_bench_start();
    SET(0x6007, 0, 0);
    SET(0x2050, 1, rows[i].source);
    SET(0x2070, 1, 1);
    machine.axis[0].gyro_missing = rows[i].gyro_missing;
    machine.axis[0].gyro_error_rad_s = rows[i].gyro_error_rad_s;
    turn_azimuth_at_0_2_rad_s();
    CHECK_NEAR("rad/s", 0.0, node.axis[0].monitor.swings.last_error_rad_s, 0.002);
    SET(0x60FF, 0, 0);
    wait_ms(1);
    SET(0x60FF, 0, (uint32_t)-100000);
    wait_ms(900);
    CHECK_NEAR("rad/s", -0.1, machine.axis[0].rate_rad_s, 0.002);
    CHECK_NEAR("rad/s", 0.0, node.axis[0].monitor.swings.last_error_rad_s, 0.002);
    machine.axis[0].gyro_error_rad_s += 0.02f; /* the base begins to turn: the gyro alone holds the inertial rate */
    wait_ms(300);
    if (rows[i].source == 1) {
      TEST_ASSERT_EQUAL_MESSAGE(1, node.board.app.params.axis[0].speed.rate_fusion.source, "gains taken back");
      CHECK_NEAR("rad/s", -0.12, machine.axis[0].rate_rad_s, 0.002);
      CHECK_NEAR("rad/s", 0.0, node.axis[0].monitor.swings.last_error_rad_s, 0.002);
    }
  }
}

/* Pushed to and fro by its master in cst, with 80 % of the motor's torque for 4 ms each: no loop of the axis does it.
 */
static void test_the_torque_that_a_master_alternates_is_no_oscillation(void) {
  enable(0, CST);
  for (int i = 0; i < 100; ++i) {
    SET(0x6071, 0, (uint32_t)(i % 2 == 0 ? 800 : -800));
    wait_ms(3);
    CHECK_NEAR("Nm", i % 2 == 0 ? 32.0 : -32.0, node.board.app.axis[0].commanded_nm, 0.1);
  }
  TEST_ASSERT_EQUAL_HEX32(STATE_ENABLED, state_of(0));
  TEST_ASSERT_EQUAL_HEX32(0, get(0x603F, 0));
}

/* 1010 and 1011, while an axis without torque and without friction turns on, and 2 s after it has come to rest. */
static void test_nothing_is_stored_while_an_axis_turns_without_torque(void) {
  turn_azimuth_at_0_2_rad_s();
  command(0, 0);
  TEST_ASSERT_EQUAL_HEX32(STATE_DISABLED, get(0x6041, 0) & 0x4F);
  CHECK_NEAR("rad/s", 0.2, machine.axis[0].rate_rad_s, 0.002);
  TEST_ASSERT_EQUAL_HEX32(OD_DEVICE_STATE, set(0x1010, 1, 0x65766173));
  TEST_ASSERT_EQUAL_HEX32(OD_DEVICE_STATE, set(0x1011, 1, 0x64616F6C));
  machine.axis[0].rate_rad_s = 0.0;
  wait_ms(2000);
  SET(0x1010, 1, 0x65766173);
}

/* 3061:1. */
static void test_what_the_board_says_of_itself_is_on_the_bus(void) {
  machine.status = HAL_STATUS_STO_A | HAL_STATUS_BRAKE_PITCH;
  wait_ms(1);
  TEST_ASSERT_EQUAL_HEX32(HAL_STATUS_STO_A | HAL_STATUS_BRAKE_PITCH, get(0x3061, 1));
  machine.status = HAL_STATUS_STO_A | HAL_STATUS_STO_B;
  wait_ms(1);
  TEST_ASSERT_EQUAL_HEX32(HAL_STATUS_STO_A | HAL_STATUS_STO_B, get(0x3061, 1));
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_every_row_of_the_dictionary_keeps_the_rules);
  RUN_TEST(test_pdos_alone_enable_an_axis_and_turn_it);
  RUN_TEST(test_the_bridge_pushes_only_where_an_axis_is_on);
  RUN_TEST(test_the_brake_opens_where_an_axis_is_on);
  RUN_TEST(test_cyclic_setpoints_that_repeat_their_value_keep_the_axis_going);
  RUN_TEST(test_cyclic_positions_move_the_axis_and_hold_it_while_they_come);
  RUN_TEST(test_a_stop_in_rpdo1_is_obeyed_whatever_mode_it_carries);
  RUN_TEST(test_a_period_that_the_drive_cannot_have_is_refused_and_no_other);
  RUN_TEST(test_what_the_drive_has_not_is_refused);
  RUN_TEST(test_the_time_out_of_cyclic_setpoints_follows_their_period);
  RUN_TEST(test_each_fault_of_the_board_stops_its_axis_alone_and_is_reported);
  RUN_TEST(test_an_axis_whose_self_test_failed_is_never_ready);
  RUN_TEST(test_below_its_limit_of_the_bus_the_drive_does_not_switch_on);
  RUN_TEST(test_without_an_angle_the_motor_brakes_itself);
  RUN_TEST(test_an_angle_that_returns_does_not_judge_the_motor_that_brakes_itself);
  RUN_TEST(test_a_master_that_falls_silent_stops_both_axes);
  RUN_TEST(test_an_axis_that_turns_stops_without_a_fault_after_1_s_without_a_frame);
  RUN_TEST(test_6007_chooses_between_going_on_a_fault_and_switching_off);
  RUN_TEST(test_a_quick_stop_that_stays_is_not_ended_by_any_frame);
  RUN_TEST(test_the_longest_silence_can_be_set_and_is_stored);
  RUN_TEST(test_what_is_addressed_to_the_node_ends_the_silence_and_nothing_else);
  RUN_TEST(test_sync_counts_while_a_pdo_is_synchronous);
  RUN_TEST(test_rpdos_of_a_node_that_is_not_operational_do_not_count);
  RUN_TEST(test_a_monitored_heartbeat_may_be_as_slow_as_1016_says);
  RUN_TEST(test_an_rpdo_with_an_event_timer_may_be_as_slow_as_it_says);
  RUN_TEST(test_an_axis_that_has_arrived_in_pp_is_not_stopped);
  RUN_TEST(test_setpoints_that_stay_away_stop_the_axis);
  RUN_TEST(test_an_nmt_stop_stops_an_axis_that_turns);
  RUN_TEST(test_a_reset_of_the_communication_stops_an_axis_that_turns_and_no_other);
  RUN_TEST(test_a_fault_that_outlives_a_reset_of_the_communication_is_reported_again);
  RUN_TEST(test_a_reset_of_the_node_is_a_fresh_start);
  RUN_TEST(test_a_reset_of_the_node_ends_an_ordered_stop);
  RUN_TEST(test_a_reset_of_the_node_does_not_end_a_braking);
  RUN_TEST(test_a_queue_that_is_full_loses_frames_and_says_so);
  RUN_TEST(test_a_move_is_no_faster_than_the_position_loop);
  RUN_TEST(test_no_limit_of_607f_leaves_the_machine_its_own);
  RUN_TEST(test_the_largest_values_of_all_objects_are_plausible);
  RUN_TEST(test_the_device_types_are_those_of_two_drives_on_one_node);
  RUN_TEST(test_the_motion_profile_is_jerk_limited_and_no_other);
  RUN_TEST(test_what_the_drive_cannot_do_is_refused);
  RUN_TEST(test_gains_that_are_unstable_stay_staged);
  RUN_TEST(test_the_gains_of_the_azimuth_are_judged_as_they_follow_its_inertia);
  RUN_TEST(test_staged_gains_come_into_force_in_one_piece);
  RUN_TEST(test_a_staged_value_is_no_command);
  RUN_TEST(test_a_board_that_starts_sets_every_duty_to_0);
  RUN_TEST(test_a_board_starts_off_at_its_angles_whatever_was_in_its_memory);
  RUN_TEST(test_each_tick_of_a_board_takes_new_samples);
  RUN_TEST(test_a_pwm_period_sets_the_duty_of_each_axis_once);
  RUN_TEST(test_a_board_with_wrong_parameters_of_either_axis_does_not_start);
  RUN_TEST(test_gains_that_do_not_fit_together_are_refused_with_the_reason);
  RUN_TEST(test_filters_that_are_set_are_in_force);
  RUN_TEST(test_the_recorded_tick_is_one_tick);
  RUN_TEST(test_it_does_not_start_with_a_wrong_node_id);
  RUN_TEST(test_it_has_its_serial_number_and_does_not_start_with_wrong_parameters);
  RUN_TEST(test_a_node_that_has_started_knows_what_its_machine_measures);
  RUN_TEST(test_software_limits_are_at_first_a_degree_inside_the_hard_ones);
  RUN_TEST(test_an_axis_is_remote_unless_the_node_is_stopped);
  RUN_TEST(test_the_search_for_oscillations_knows_what_the_loop_itself_gives);
  RUN_TEST(test_an_axis_that_follows_has_no_rate_error_for_the_search_of_oscillations);
  RUN_TEST(test_the_torque_that_a_master_alternates_is_no_oscillation);
  RUN_TEST(test_nothing_is_stored_while_an_axis_turns_without_torque);
  RUN_TEST(test_what_the_board_says_of_itself_is_on_the_bus);
  return UNITY_END();
}
