/* SPDX-License-Identifier: Apache-2.0 */
/* Homing in the whole node, on an azimuth of +-279 degrees whose encoder knows one turn. */
#include "support/node_bench.h"

#include "support/check.h"

enum { HOME_OFFSET = 0x607C, METHOD = 0x6098, SPEEDS = 0x6099, ENVELOPE = 0x2061, TURN = 2, ACCESS = 0x3040 };
enum { PROTECTION = 0x2060, TRAVEL_MINIMUM = 9, TRAVEL_MAXIMUM, TRAVEL_KIND = 21, PP = 1, PV = 3, HOMING_MODE = 6 };
enum { REACHED = 0x0400, ATTAINED = 0x1000, ERROR = 0x2000, BITS = REACHED | ATTAINED | ERROR, RUN = 0x0F, GO = 0x1F };

#define OPEN 0x6E65706Fu
#define DEVICE_STATE 0x08000022u
#define BAD_VALUE 0x06090030u
#define TURNS_PER_DEGREE (1.0 / 360.0)
#define COUNTS_PER_DEGREE 174532.925

static double low_turns; /* end stops, 1 degree beyond the hard travel */
static double high_turns;
static double fastest_rad_s;

void setUp(void) { node_bench_start(); }
void tearDown(void) {}

/* Off, in an unknown turn, the lock open. */
static void start_at(double degrees) {
  rigid_machine_init(&machine);
  machine.axis[0].turns = degrees * TURNS_PER_DEGREE;
  machine.axis[0].friction_nm = 5.0;
  high_turns = 280.0 * TURNS_PER_DEGREE;
  low_turns = -high_turns;
  fastest_rad_s = 0.0;
  TEST_ASSERT_TRUE(rigid_machine_start_node(&machine, &node, NODE_ID, (can_sender){node_bench_send, NULL}, NULL));
  wait_ms(8);
  SET(ACCESS, 1, OPEN);
  SET_FLOAT(PROTECTION, TRAVEL_KIND, 0.0f);
  SET_FLOAT(PROTECTION, TRAVEL_MINIMUM, (float)(-279.0 * 0.0174532925));
  SET_FLOAT(PROTECTION, TRAVEL_MAXIMUM, (float)(279.0 * 0.0174532925));
  SET(0x6007, 0, 0); /* this master is silent */
  wait_ms(8);
  TEST_ASSERT_EQUAL(2, get(ENVELOPE, 1) & 0xFF);
}

/* With hard end stops. */
static void turn_ms(int duration_ms) {
  rigid_axis *axis = &machine.axis[0];
  for (int i = 0; i < duration_ms; ++i) {
    wait_ms(1);
    fastest_rad_s = fmax(fastest_rad_s, fabs(axis->rate_rad_s));
    if (axis->turns < low_turns || axis->turns > high_turns) {
      axis->turns = axis->turns < low_turns ? low_turns : high_turns;
      axis->rate_rad_s = 0.0;
    }
  }
}

static uint32_t bits(void) { return get(0x6041, 0) & BITS; }

static double position_deg(void) { return (double)(int32_t)get(0x6064, 0) / COUNTS_PER_DEGREE; }

static void home(int8_t method) {
  SET(METHOD, 0, (uint8_t)method);
  enable(0, HOMING_MODE);
  TEST_ASSERT_EQUAL_HEX32(REACHED, bits()); /* not started */
  command(0, GO);
}

/* Until the homing has ended; seconds. */
static double ends_after_s(void) {
  int ms = 0;
  while (bits() == 0) {
    turn_ms(50);
    ms += 50;
    TEST_ASSERT_TRUE(ms < 120000);
  }
  turn_ms(500);
  return 1e-3 * ms;
}

static void check_homed(double degrees) {
  TEST_ASSERT_EQUAL_HEX32(REACHED | ATTAINED, bits());
  TEST_ASSERT_EQUAL(0, get(ENVELOPE, 1) & 0xFF);
  TEST_ASSERT_EQUAL_HEX32(STATE_ENABLED, state_of(0));
  CHECK_NEAR("degrees", degrees, machine.axis[0].turns * 360.0, 15.0);
  CHECK_NEAR("degrees", machine.axis[0].turns * 360.0, position_deg(), 1e-3);
  CHECK_AT_MOST("rad/s", 0.0872664626, fastest_rad_s);
  SET(0x6060, 0, PP); /* a target has a meaning now */
  command(0, RUN);
  SET(0x607A, 0, 0);
  command(0, GO);
  turn_ms(30000);
  CHECK_NEAR("degrees", 0.0, machine.axis[0].turns * 360.0, 0.01);
}

/* The mode and bit 4 in one frame, of an axis that stands in pv: the homing starts. Bit 4 that was set before, in pv,
 * starts none. */
static void test_a_start_may_come_together_with_the_mode(void) {
  for (int set_before = 0; set_before < 2; ++set_before) {
    start_at(100.0);
    SET(METHOD, 0, (uint8_t)-1);
    enable(0, PV);
    if (set_before != 0) {
      command(0, GO);
    }
    give(0x600 + NODE_ID, 8, (const uint8_t[]){0x2F, 0x60, 0x60, 0, HOMING_MODE, 0, 0, 0});
    give(0x600 + NODE_ID, 8, (const uint8_t[]){0x2B, 0x40, 0x60, 0, GO, 0, 0, 0});
    turn_ms(2000);
    CHECK_NEAR("rad/s", set_before != 0 ? 0.0 : -0.034907, machine.axis[0].rate_rad_s, 1e-3);
    TEST_ASSERT_EQUAL_HEX32(set_before != 0 ? REACHED : 0, bits());
  }
}

static void test_the_mode_is_listed_and_methods_are_checked(void) {
  TEST_ASSERT_EQUAL_HEX32(0x000103A5, get(0x6502, 0));
  TEST_ASSERT_EQUAL_HEX32(BAD_VALUE, set(METHOD, 0, 17)); /* there are no limit switches */
  TEST_ASSERT_EQUAL_HEX32(BAD_VALUE, set(METHOD, 0, 36));
  TEST_ASSERT_EQUAL_HEX32(0x06090032, set(METHOD, 0, (uint8_t)-3));
  SET(METHOD, 0, 35);
  SET(METHOD, 0, 37);
  SET(METHOD, 0, (uint8_t)-2);
}

/* At 100 degrees, or -260: down is free, -285.7 excludes the other turn. */
static void test_motion_excludes_the_other_turn(void) {
  start_at(100.0);
  home(-1);
  turn_ms(2000);
  TEST_ASSERT_EQUAL_HEX32(0, bits());
  CHECK_NEAR("rad/s", -0.034907, machine.axis[0].rate_rad_s, 1e-3);
  LOG_VALUE("seconds until homed", ends_after_s());
  check_homed(74.0);
}

/* At -260 degrees, or 100: the first path ends at the end stop, the second one leads away from it. */
static void test_at_an_end_stop_it_turns_round(void) {
  start_at(-260.0);
  home(-1);
  LOG_VALUE("seconds until homed", ends_after_s());
  check_homed(-74.0);
}

static void jam_around(double degrees, double half_width_deg) {
  start_at(degrees);
  low_turns = (degrees - half_width_deg) * TURNS_PER_DEGREE;
  high_turns = (degrees + half_width_deg) * TURNS_PER_DEGREE;
}

/* Something blocks the axis in its travel: that decides no turn. */
static void test_a_jam_on_both_sides_is_an_error(void) {
  jam_around(150.0, 5.0);
  SET(SPEEDS, 2, 34907);
  home(-2);
  LOG_VALUE("seconds until the error", ends_after_s());
  TEST_ASSERT_EQUAL_HEX32(REACHED | ERROR, bits());
  TEST_ASSERT_EQUAL(2, get(ENVELOPE, 1) & 0xFF);
  TEST_ASSERT_EQUAL_HEX32(STATE_ENABLED, state_of(0));
  turn_ms(500); /* the integral part runs down */
  CHECK_NEAR("rad/s", 0.0, machine.axis[0].rate_rad_s, 1e-3);
  CHECK_AT_MOST("Nm", 10.0, fabs((double)node.board.app.axis[0].commanded_nm)); /* it does not press on */
}

/* 0.25 s do. */
static void test_a_contact_of_0_15_s_turns_nothing_round(void) {
  start_at(100.0);
  home(-1);
  turn_ms(2000);
  const double free_turns = low_turns;
  low_turns = machine.axis[0].turns;
  turn_ms(150);
  CHECK_NEAR("limited, Nm", -40.0, node.board.app.axis[0].commanded_nm, 1.0);
  low_turns = free_turns;
  turn_ms(1000);
  CHECK_NEAR("goes on, rad/s", -0.034907, machine.axis[0].rate_rad_s, 1e-3);
}

/* The path back from an end stop is fast: there a contact is a fault. */
static void test_a_contact_at_4_deg_s_is_a_fault(void) {
  jam_around(150.0, 5.0);
  home(-2);
  turn_ms(15000);
  TEST_ASSERT_TRUE(is_in_fault(0));
  TEST_ASSERT_EQUAL_HEX32(0x7122, get(0x603F, 0) & 0xFFFF);
  TEST_ASSERT_EQUAL(2, get(ENVELOPE, 1) & 0xFF);
}

static void test_bit_4_halt_and_a_fault_interrupt_it(void) {
  start_at(150.0);
  home(-1);
  turn_ms(1000);
  command(0, RUN);
  turn_ms(500);
  TEST_ASSERT_EQUAL_HEX32(REACHED, bits());
  CHECK_NEAR("rad/s", 0.0, machine.axis[0].rate_rad_s, 1e-3);
  command(0, GO);
  turn_ms(1000);
  TEST_ASSERT_EQUAL_HEX32(0, bits());
  command(0, GO | 0x100);
  turn_ms(500);
  command(0, GO);
  turn_ms(500);
  CHECK_NEAR("rad/s", 0.0, machine.axis[0].rate_rad_s, 1e-3); /* needs a new start */
  TEST_ASSERT_EQUAL_HEX32(REACHED, bits());
  machine.axis[0].encoder_failed = true;
  turn_ms(2500);
  machine.axis[0].encoder_failed = false;
  TEST_ASSERT_TRUE(is_in_fault(0));
}

static void test_where_the_operator_saw_the_axis_is_confirmed(void) {
  start_at(240.0);
  SET(HOME_OFFSET, 0, (uint32_t)(int32_t)(200.0 * COUNTS_PER_DEGREE)); /* roughly */
  TEST_ASSERT_EQUAL(2, get(ENVELOPE, 1) & 0xFF);                       /* homing confirms it, not the write */
  home(37);
  wait_ms(10);
  check_homed(240.0);
}

static void test_a_position_needs_the_lock_an_axis_that_is_off_and_a_possible_turn(void) {
  start_at(-120.0);
  TEST_ASSERT_EQUAL_HEX32(BAD_VALUE, set(HOME_OFFSET, 0, (uint32_t)(int32_t)(-20.0 * COUNTS_PER_DEGREE)));
  TEST_ASSERT_EQUAL_HEX32(BAD_VALUE, set(HOME_OFFSET, 0, (uint32_t)(int32_t)(600.0 * COUNTS_PER_DEGREE)));
  TEST_ASSERT_EQUAL_HEX32(0, get(HOME_OFFSET, 0));
  SET(ACCESS, 1, 0);
  TEST_ASSERT_EQUAL_HEX32(DEVICE_STATE, set(HOME_OFFSET, 0, (uint32_t)(int32_t)(-120.0 * COUNTS_PER_DEGREE)));
  TEST_ASSERT_EQUAL_HEX32(DEVICE_STATE, set(HOME_OFFSET, 0, (uint32_t)(int32_t)(-20.0 * COUNTS_PER_DEGREE)));
  SET(ACCESS, 1, OPEN);
  enable(0, PV);
  TEST_ASSERT_EQUAL_HEX32(DEVICE_STATE, set(HOME_OFFSET, 0, (uint32_t)(int32_t)(-120.0 * COUNTS_PER_DEGREE)));
  command(0, 0);
  home(37); /* nothing was seen */
  wait_ms(10);
  TEST_ASSERT_EQUAL_HEX32(REACHED | ERROR, bits());
  TEST_ASSERT_EQUAL(2, get(ENVELOPE, 1) & 0xFF);
}

/* It is used up: after the encoder has lost the turn again, the old position confirms nothing. */
static void test_a_position_confirms_once(void) {
  start_at(240.0);
  SET(HOME_OFFSET, 0, (uint32_t)(int32_t)(240.0 * COUNTS_PER_DEGREE));
  home(37);
  wait_ms(10);
  TEST_ASSERT_EQUAL_HEX32(REACHED | ATTAINED, bits());
  command(0, 0);
  machine.axis[0].encoder_failed = true;
  wait_ms(1100);
  machine.axis[0].encoder_failed = false;
  wait_ms(10);
  command(0, 0x80);
  home(37);
  wait_ms(10);
  TEST_ASSERT_EQUAL_HEX32(REACHED | ERROR, bits());
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_the_mode_is_listed_and_methods_are_checked);
  RUN_TEST(test_a_start_may_come_together_with_the_mode);
  RUN_TEST(test_motion_excludes_the_other_turn);
  RUN_TEST(test_at_an_end_stop_it_turns_round);
  RUN_TEST(test_a_jam_on_both_sides_is_an_error);
  RUN_TEST(test_a_contact_of_0_15_s_turns_nothing_round);
  RUN_TEST(test_a_contact_at_4_deg_s_is_a_fault);
  RUN_TEST(test_bit_4_halt_and_a_fault_interrupt_it);
  RUN_TEST(test_where_the_operator_saw_the_axis_is_confirmed);
  RUN_TEST(test_a_position_needs_the_lock_an_axis_that_is_off_and_a_possible_turn);
  RUN_TEST(test_a_position_confirms_once);
  return UNITY_END();
}
