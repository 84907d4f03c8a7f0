/* SPDX-License-Identifier: Apache-2.0 */
/* The envelope in the whole node: restrictions, the turn of the start, and stops of protection. */
#include "support/node_bench.h"

#include "support/check.h"

enum {
  PROTECTION = 0x2060,
  OVERSPEED = 1,
  TRAVEL_MINIMUM = 9,
  TRAVEL_MAXIMUM,
  STOPPING_MARGIN = 17,
  DECELERATION = 19,
  TRAVEL_KIND = 21
};
enum { ENVELOPE = 0x2061, RESTRICTIONS = 1, TURN, LOWEST_TURN, HIGHEST_TURN, CONFIRMED, FASTEST_DOWN, FASTEST_UP };
enum { ACCESS = 0x3040, PP = 1, PV = 3, CSV = 9 };

#define OPEN 0x6E65706Fu
#define DEVICE_STATE 0x08000022u
#define BAD_VALUE 0x06090030u
#define DEGREES 0.0174532925f

void setUp(void) { node_bench_start(); }
void tearDown(void) {}

static uint8_t restrictions_of(uint32_t shift) { return (uint8_t)get(ENVELOPE + shift, RESTRICTIONS); }

static uint8_t restrictions(void) { return restrictions_of(0); }

/* With inertia 6 and 40 Nm the machine has 6.7 rad/s^2. */
static void limit_travel(float minimum_rad, float maximum_rad) {
  SET(ACCESS, 1, OPEN);
  SET_FLOAT(PROTECTION, TRAVEL_KIND, 0.0f);
  SET_FLOAT(PROTECTION, TRAVEL_MINIMUM, minimum_rad);
  SET_FLOAT(PROTECTION, TRAVEL_MAXIMUM, maximum_rad);
  wait_ms(8);
}

static void start_at(double turns) {
  rigid_machine_init(&machine);
  machine.axis[0].turns = turns;
  TEST_ASSERT_TRUE(rigid_machine_start_node(&machine, &node, NODE_ID, (can_sender){node_bench_send, NULL}, NULL));
  wait_ms(8);
}

static void test_without_a_travel_an_axis_is_not_enabled_and_says_so(void) {
  for (uint32_t shift = 0; shift <= PITCH; shift += PITCH) {
    SET(ACCESS, 1, OPEN);
    SET_FLOAT(PROTECTION + shift, TRAVEL_KIND, 0.0f);
    wait_ms(8);
    TEST_ASSERT_EQUAL(1, restrictions_of(shift));
    command(shift, 0x06);
    command(shift, 0x07);
    command(shift, 0x0F);
    TEST_ASSERT_EQUAL_HEX32(STATE_READY, state_of(shift));
    SET_FLOAT(PROTECTION + shift, TRAVEL_KIND, 1.0f);
    wait_ms(8);
    TEST_ASSERT_EQUAL(0, restrictions_of(shift));
    TEST_ASSERT_EQUAL_HEX32(STATE_ENABLED, state_of(shift));
    command(shift, 0);
  }
}

static void test_commissioning_is_slow(void) {
  SET(ACCESS, 1, OPEN);
  SET_FLOAT(PROTECTION, TRAVEL_KIND, 2.0f);
  wait_ms(8);
  TEST_ASSERT_EQUAL(4, restrictions());
  SET(0x6007, 0, 0); /* this master is silent */
  enable(0, PV);
  SET(0x60FF, 0, 1000000);
  wait_ms(2000);
  CHECK_NEAR("rad/s", 0.8 * 5.0 * 0.0174533, machine.axis[0].rate_rad_s, 1e-3);
  machine.axis[0].rate_rad_s = 0.09; /* pushed */
  wait_ms(3);
  TEST_ASSERT_EQUAL_HEX32(0x8613, get(0x603F, 0));
  CHECK_NEAR("rad/s", 5.0 * 0.0174533, get_float(ENVELOPE, FASTEST_UP), 1e-6);
}

/* The torque that protection demands is no set-point, and 2101:8 has the unit of one: rad/s. */
static void test_the_recorded_reference_is_0_while_protection_brakes(void) {
  SET(ACCESS, 1, OPEN);
  SET_FLOAT(PROTECTION, TRAVEL_KIND, 2.0f);
  SET(0x6007, 0, 0);
  enable(0, PV);
  SET(0x60FF, 0, 60000);
  wait_ms(1000);
  CHECK_NEAR("rad/s", 0.06, get_float(0x2101, 8), 1e-3);
  machine.axis[0].rate_rad_s = 0.09; /* pushed, and pushed on */
  machine.axis[0].load_nm = -30.0;
  wait_ms(4);
  TEST_ASSERT_EQUAL(SERVO_PROTECTIVE_STOP, node.board.app.axis[0].mode);
  CHECK_AT_MOST("Nm", -10.0, node.board.app.axis[0].commanded_nm);
  CHECK_SAME("rad/s", 0.0, get_float(0x2101, 8));
}

static void test_the_fastest_rate_is_on_the_bus(void) {
  limit_travel(-1.0f, 1.0f);
  CHECK_NEAR("rad/s", sqrt(2.0 * 5.0 / 1.0609), get_float(ENVELOPE, FASTEST_UP), 1.7);
  TEST_ASSERT_TRUE(get_float(ENVELOPE, FASTEST_DOWN) <= 1.5f);
  machine.axis[0].turns = 0.95 / 6.283185307;
  wait_ms(16); /* to the encoder it is a jump: the turn is looked for again */
  CHECK_NEAR("rad/s", sqrt(2.0 * 5.0 / 1.0609 * 0.05), get_float(ENVELOPE, FASTEST_UP), 0.03);
  CHECK_AT_LEAST("away from the end, rad/s", 1.4, get_float(ENVELOPE, FASTEST_DOWN));
}

/* 2060:17: the ramps of pp and pv end this far before the ends of the travel; here 607D allows all of it. */
static void test_no_ramp_goes_into_the_stopping_margin(void) {
  static const int8_t modes[] = {PP, PV};
  for (unsigned i = 0; i < sizeof modes / sizeof modes[0]; ++i) {
    for (int side = -1; side <= 1; side += 2) {
      node_bench_start();
      limit_travel(-0.5f, 0.5f);
      SET_FLOAT(PROTECTION, STOPPING_MARGIN, 0.2f);
      SET(0x6007, 0, 0);
      SET(0x607D, 1, (uint32_t)-5000000);
      SET(0x607D, 2, 5000000);
      enable(0, modes[i]);
      SET(0x607A, 0, (uint32_t)(side * 5000000));
      SET(0x60FF, 0, (uint32_t)(side * 3000000));
      command(0, 0x1F);
      wait_ms(3000);
      TEST_ASSERT_EQUAL_HEX32(STATE_ENABLED, state_of(0));
      CHECK_NEAR("rad", side * 0.3, machine.axis[0].turns * 6.283185307, 1e-3);
    }
  }
}

/* 6072 = 0 and a push; a second and a third time after a reset. */
static void test_an_axis_without_torque_is_stopped_before_the_end_every_time(void) {
  limit_travel(-1.0f, 1.0f);
  SET(0x6072, 0, 0);
  for (int i = 0; i < 3; ++i) {
    enable(0, PV);
    machine.axis[0].load_nm = i == 1 ? 12.0 : -12.0;
    float braking_nm = 0.0f; /* the most that protection demands: what the motor has, not the 6072 of the user */
    for (int ms = 0; ms < 2300; ++ms) {
      machine.axis[0].load_nm = ms < 300 ? machine.axis[0].load_nm : 0.0;
      wait_ms(1);
      braking_nm = scalar_max(braking_nm, scalar_abs(node.axis[0].inputs.protective_nm));
    }
    const servo_axis_params *params = &node.board.app.params.axis[0];
    CHECK_NEAR("Nm", params->current_limit_a * params->torque_constant_nm_a, braking_nm, 1e-3);
    TEST_ASSERT_TRUE(is_in_fault(0));
    CHECK_AT_MOST("rad", 1.0, fabs(machine.axis[0].turns * 6.283185307));
    CHECK_NEAR("rad/s", 0.0, machine.axis[0].rate_rad_s, 0.01);
    command(0, 0x80);
    command(0, 0x00);
    wait_ms(8);
  }
}

/* 0.5 rad/s for this time. A set-point by SDO takes a ms; its period is 5 ms in csv. */
static void turn_for(unsigned ms) {
  for (unsigned i = 0; i < ms; ++i) {
    SET(0x60FF, 0, 500000);
  }
}

/* Without torque the axis goes on at its rate; stopped by the halt, or because its set-points are missing. */
static void test_an_ordered_stop_that_the_axis_does_not_follow_is_a_fault(void) {
  static const int8_t modes[] = {PV, CSV};
  for (int i = 0; i < 2; ++i) {
    node_bench_start();
    SET(ACCESS, 1, OPEN);
    SET_FLOAT(PROTECTION, TRAVEL_KIND, 1.0f);
    wait_ms(8);
    SET(0x6007, 0, 0);
    SET(0x60C2, 1, 5);
    enable(0, modes[i]);
    turn_for(2000);
    CHECK_NEAR("rad/s", 0.5, machine.axis[0].rate_rad_s, 1e-2);
    SET(0x6072, 0, 0);
    turn_for(1000);
    CHECK_NEAR("it goes on, rad/s", 0.5, machine.axis[0].rate_rad_s, 1e-2);
    TEST_ASSERT_EQUAL_HEX32(STATE_ENABLED, get(0x6041, 0) & STATE_MASK);
    if (modes[i] == PV) {
      SET(0x6040, 0, 0x10F);
    }
    for (int ms = 0; ms < 3000 && !is_in_fault(0); ms += 100) {
      wait_ms(100);
    }
    TEST_ASSERT_EQUAL_HEX32(0x8482, get(0x603F, 0) & 0xFFFF);
  }
}

static void test_a_start_in_an_unknown_turn_is_confirmed_by_the_operator(void) {
  start_at(-120.0 / 360.0);
  limit_travel(-279.0f * DEGREES, 279.0f * DEGREES);
  TEST_ASSERT_EQUAL(2, restrictions());
  TEST_ASSERT_EQUAL(0, (int8_t)get(ENVELOPE, LOWEST_TURN));
  TEST_ASSERT_EQUAL(1, (int8_t)get(ENVELOPE, HIGHEST_TURN));
  start_at(120.0 / 360.0);
  limit_travel(-279.0f * DEGREES, 279.0f * DEGREES);
  TEST_ASSERT_EQUAL(-1, (int8_t)get(ENVELOPE, LOWEST_TURN));
  TEST_ASSERT_EQUAL(0, (int8_t)get(ENVELOPE, HIGHEST_TURN));
  start_at(-120.0 / 360.0);
  limit_travel(-279.0f * DEGREES, 279.0f * DEGREES);
  SET(ACCESS, 1, 0);
  TEST_ASSERT_EQUAL_HEX32(DEVICE_STATE, set(ENVELOPE, CONFIRMED, 1));
  SET(ACCESS, 1, OPEN);
  TEST_ASSERT_EQUAL_HEX32(BAD_VALUE, set(ENVELOPE, CONFIRMED, 2));
  enable(0, PV);
  TEST_ASSERT_EQUAL_HEX32(DEVICE_STATE, set(ENVELOPE, CONFIRMED, 1));
  command(0, 0x00);
  SET(ENVELOPE, CONFIRMED, 1);
  wait_ms(8);
  TEST_ASSERT_EQUAL(0, restrictions());
  TEST_ASSERT_EQUAL(1, (int8_t)get(ENVELOPE, TURN));
  CHECK_NEAR("1e-7 rad", 240.0 * 174532.925, (double)(int32_t)get(0x6064, 0), 100.0);
  nmt(0x81); /* what is known stays known */
  wait_ms(100);
  CHECK_NEAR("1e-7 rad", 240.0 * 174532.925, (double)(int32_t)get(0x6064, 0), 100.0);
}

static void test_a_target_waits_while_the_turn_is_unknown_and_is_dropped_then(void) {
  start_at(-100.0 / 360.0); /* or 260 */
  limit_travel(-279.0f * DEGREES, 279.0f * DEGREES);
  SET(0x6007, 0, 0);
  enable(0, PP);
  SET(0x607A, 0, 0);
  command(0, 0x1F);
  wait_ms(1000);
  CHECK_NEAR("turns", -100.0 / 360.0, machine.axis[0].turns, 1e-4);
  TEST_ASSERT_TRUE((get(0x6041, 0) & 1u << 11) != 0);
  SET(0x6060, 0, PV);
  SET(0x60FF, 0, 1000000);
  wait_ms(8000); /* 260 would be 292 by now: excluded */
  TEST_ASSERT_EQUAL(0, restrictions());
  TEST_ASSERT_EQUAL(0, (int8_t)get(ENVELOPE, TURN));
}

/* Only one turn is within the travel: it is known at once. */
static void test_the_only_turn_within_the_travel_is_taken(void) {
  start_at(-100.0 / 360.0);
  limit_travel(10.0f * DEGREES, 350.0f * DEGREES);
  TEST_ASSERT_EQUAL(0, restrictions());
  CHECK_NEAR("1e-7 rad", 260.0 * 174532.925, (double)(int32_t)get(0x6064, 0), 100.0);
}

static void test_a_second_without_the_encoder_forgets_the_turn(void) {
  start_at(-100.0 / 360.0);
  limit_travel(-279.0f * DEGREES, 279.0f * DEGREES);
  SET(ENVELOPE, CONFIRMED, 1);
  wait_ms(8);
  TEST_ASSERT_EQUAL(0, restrictions());
  machine.axis[0].encoder_failed = true;
  wait_ms(996);
  TEST_ASSERT_TRUE(node.axis[0].monitor.candidates.known);
  wait_ms(4);
  TEST_ASSERT_FALSE(node.axis[0].monitor.candidates.known);
  wait_ms(100);
  TEST_ASSERT_EQUAL(2, restrictions());
  machine.axis[0].encoder_failed = false;
  wait_ms(10);
  TEST_ASSERT_EQUAL(2, restrictions());
}

/* While its encoder is silent, the last rate of the axis is no reason to push: what protection hands to the drive. */
static void test_without_an_angle_protection_demands_no_torque(void) {
  SET(0x6007, 0, 0);
  enable(0, PV);
  SET(0x60FF, 0, 500000);
  wait_ms(2000);
  CHECK_NEAR("rad/s", 0.5, machine.axis[0].rate_rad_s, 1e-2);
  machine.axis[0].encoder_failed = true;
  for (int ms = 0; ms < 20; ++ms) {
    wait_ms(1);
    TEST_ASSERT_EQUAL(FAULT_ENCODER_LOST, node.axis[0].drive.fault);
    CHECK_SAME("Nm", 0.0, node.axis[0].inputs.protective_nm);
  }
}

/* Two wrong readings, each less than half a turn from the last: the count of turns is then one too high. */
static void read_a_turn_too_many(uint32_t wait_before_ms) {
  const double turns = machine.axis[0].turns;
  wait_ms(wait_before_ms);
  machine.axis[0].turns = turns + 0.35;
  wait_ms(1);
  machine.axis[0].turns = turns + 0.7;
  wait_ms(1);
  machine.axis[0].turns = turns;
  wait_ms(20);
}

/* The turn is looked for every 4 ms: the wrong readings come in each phase of it. */
static void test_after_an_encoder_that_jumps_the_turn_is_found_again(void) {
  start_at(100.0 / 360.0);
  limit_travel(10.0f * DEGREES, 350.0f * DEGREES);
  for (uint32_t phase = 0; phase < 4; ++phase) {
    read_a_turn_too_many(4 + phase);
    TEST_ASSERT_EQUAL_HEX32(0x7320, get(0x603F, 0));
    TEST_ASSERT_EQUAL(0, restrictions());
    CHECK_NEAR("1e-7 rad", 100.0 * 174532.925, (double)(int32_t)get(0x6064, 0), 100.0);
  }
}

/* Each reading 0.38 turns from the one before, as of noise on the line: the count runs away by hundreds of turns. */
static void test_after_readings_that_count_hundreds_of_turns_the_turn_is_found_again(void) {
  for (int sign = -1; sign <= 1; sign += 2) {
    start_at(100.0 / 360.0);
    limit_travel(10.0f * DEGREES, 350.0f * DEGREES);
    for (int ms = 0; ms < 1000 + sign; ++ms) {
      machine.axis[0].turns += 0.38 * sign;
      wait_ms(1);
    }
    machine.axis[0].turns = 100.0 / 360.0;
    wait_ms(20);
    TEST_ASSERT_EQUAL(0, restrictions());
    CHECK_NEAR("1e-7 rad", 100.0 * 174532.925, (double)(int32_t)get(0x6064, 0), 100.0);
  }
}

/* An axis without end stops that has turned three times: the garbage counts from the last good position, not from the
 * encoder's zero, and what it has counted is gone. */
static void test_an_endless_axis_keeps_its_turn_when_readings_count_hundreds_of_them(void) {
  for (int sign = -1; sign <= 1; sign += 2) {
    start_at(100.0 / 360.0);
    machine.axis[0].rate_rad_s = 1.2 * sign;
    wait_ms(15700);
    machine.axis[0].rate_rad_s = 0.0;
    const double turns = machine.axis[0].turns;
    wait_ms(20);
    CHECK_NEAR("1e-7 rad", turns * 6.283185307e7, (double)(int32_t)get(0x6064, 0), 100.0);
    for (int ms = 0; ms < 1000 + sign; ++ms) { /* the increments are equal: no jump */
      machine.axis[0].turns += 0.38 * sign;
      wait_ms(1);
    }
    machine.axis[0].turns = turns;
    wait_ms(20);
    TEST_ASSERT_EQUAL_HEX32(0x7320, get(0x603F, 0));
    CHECK_NEAR("1e-7 rad", turns * 6.283185307e7, (double)(int32_t)get(0x6064, 0), 100.0);
  }
}

/* Wrong readings that stand still for 10 ms each, at rest, in each phase of the search. */
static void test_an_endless_axis_keeps_its_turn_when_wrong_readings_stand_still(void) {
  for (uint32_t phase = 0; phase < 4; ++phase) {
    start_at(0.1);
    wait_ms(600 + phase);
    for (int part = 1; part <= 2; ++part) {
      machine.axis[0].turns = 0.1 + 0.4 * part;
      wait_ms(10);
    }
    machine.axis[0].turns = 0.1;
    wait_ms(20);
    CHECK_NEAR("1e-7 rad", 0.1 * 6.283185307e7, (double)(int32_t)get(0x6064, 0), 100.0);
  }
}

/* Without an angle for more than a second, and a reset of the node meanwhile. */
static void test_an_endless_axis_keeps_its_turn_in_a_reset_of_the_node(void) {
  start_at(0.1);
  machine.axis[0].rate_rad_s = 1.2;
  wait_ms(15700);
  machine.axis[0].rate_rad_s = 0.0;
  wait_ms(600);
  machine.axis[0].encoder_failed = true;
  wait_ms(1200);
  nmt(0x81);
  wait_ms(20);
  machine.axis[0].encoder_failed = false;
  wait_ms(20);
  const double turns = machine.axis[0].turns;
  CHECK_NEAR("1e-7 rad", turns * 6.283185307e7, (double)(int32_t)get(0x6064, 0), 100.0);
}

/* It reads -100 degrees and is at 260; afterwards it counts as after a start, in each phase of the search. */
static void test_an_encoder_that_jumps_makes_a_confirmed_turn_unknown(void) {
  for (uint32_t phase = 0; phase < 4; ++phase) {
    start_at(-100.0 / 360.0);
    limit_travel(-279.0f * DEGREES, 279.0f * DEGREES);
    SET(ENVELOPE, CONFIRMED, 1);
    wait_ms(8);
    TEST_ASSERT_EQUAL(0, restrictions());
    read_a_turn_too_many(4 + phase);
    TEST_ASSERT_EQUAL(2, restrictions());
    TEST_ASSERT_EQUAL(0, get(ENVELOPE, LOWEST_TURN) & 0xFF);
    TEST_ASSERT_EQUAL(1, get(ENVELOPE, HIGHEST_TURN) & 0xFF);
    CHECK_NEAR("1e-7 rad", -100.0 * 174532.925, (double)(int32_t)get(0x6064, 0), 100.0);
  }
}

static void encoder_reads(double turns, bool valid) {
  machine.axis[0].turns = turns;
  machine.axis[0].encoder_failed = !valid;
  wait_ms(1);
}

/* Two wrong readings between ticks without one count a turn too many; fault 2 does not see them. */
static void test_wrong_readings_between_ticks_without_one_do_not_count_a_turn(void) {
  for (uint32_t phase = 0; phase < 4; ++phase) {
    start_at(0.0);
    limit_travel(-279.0f * DEGREES, 279.0f * DEGREES);
    wait_ms(4 + phase);
    for (int part = 1; part <= 2; ++part) {
      encoder_reads(0.0, false);
      encoder_reads(0.35 * part, true);
    }
    encoder_reads(0.0, false);
    machine.axis[0].encoder_failed = false;
    wait_ms(20);
    TEST_ASSERT_EQUAL(0, restrictions());
    CHECK_NEAR("1e-7 rad", 0.0, (double)(int32_t)get(0x6064, 0), 100.0);
  }
}

/* Lost at 240 degrees (it reads -120) for 1.1 s: the turn is forgotten. One wrong reading of 30 degrees has one turn.
 */
static void test_one_wrong_reading_does_not_tell_the_turn(void) {
  for (uint32_t phase = 0; phase < 4; ++phase) {
    start_at(-120.0 / 360.0);
    limit_travel(-279.0f * DEGREES, 279.0f * DEGREES);
    SET(ENVELOPE, CONFIRMED, 1);
    machine.axis[0].encoder_failed = true;
    wait_ms(1100 + phase);
    encoder_reads(30.0 / 360.0, true);
    encoder_reads(30.0 / 360.0, false);
    machine.axis[0].turns = -120.0 / 360.0;
    wait_ms(20);
    machine.axis[0].encoder_failed = false;
    wait_ms(20);
    TEST_ASSERT_EQUAL(2, restrictions());
  }
}

/* 2060:1 = 10 rad/s: in 0.9 s without an angle the axis may have turned by more than half a turn. It was at 0, and 0.8
 * turns further there is no other turn within the travel. */
static void test_a_fast_axis_without_an_angle_for_long_may_be_a_turn_further(void) {
  start_at(0.0);
  limit_travel(-350.0f * DEGREES, 350.0f * DEGREES);
  SET_FLOAT(PROTECTION, OVERSPEED, 10.0f);
  wait_ms(8);
  encoder_reads(0.0, false);
  wait_ms(900);
  encoder_reads(0.8, true);
  wait_ms(20);
  TEST_ASSERT_EQUAL(2, restrictions());
}

/* 7 ms with 16 angles; after the return to two it fades by 0.2 ms in a ms. */
static void test_the_delay_of_the_rate_follows_its_window(void) {
  SET(ACCESS, 1, OPEN);
  SET(0x2050, 3, 16);
  SET(0x2070, 1, 4); /* without a check */
  wait_ms(2);
  const float *delay_s = &node.axis[0].monitor.seen.rate_delay_s;
  CHECK_NEAR("s", 7e-3, *delay_s, 1e-6);
  SET(0x2050, 3, 2);
  SET(0x2070, 1, 1);
  wait_ms(2);
  CHECK_AT_LEAST("s", 6e-3, *delay_s);
  wait_ms(24);
  CHECK_AT_LEAST("s", 1e-3, *delay_s);
  wait_ms(20);
  CHECK_NEAR("s", 0.0, *delay_s, 1e-9);
}

/* Pushed by hand at 0.15 rad/s; whether the axis says within 100 ms that it moves away from its travel. */
static bool says_it_moves_away(double direction) {
  bool said = false;
  for (int ms = 0; ms < 100; ++ms) {
    machine.axis[0].rate_rad_s = 0.15 * direction;
    wait_ms(1);
    said = said || (node.axis[0].inputs.faults & fault_bit(FAULT_BEYOND_TRAVEL)) != 0;
  }
  return said;
}

/* Outside its travel, an axis says that it is moved further out only while a loop is closed. */
static void test_an_axis_outside_of_its_travel_is_moved_inwards_only(void) {
  for (int side = -1; side <= 1; side += 2) {
    start_at(side * 0.9 / 6.283185307);
    limit_travel(-1.0f, 1.0f);
    SET(0x6007, 0, 0);
    TEST_ASSERT_EQUAL(0, restrictions());
    for (int i = 0; i < 20; ++i) {
      TEST_ASSERT_FALSE(says_it_moves_away(side)); /* the axis is off: to 1.2 rad */
    }
    machine.axis[0].rate_rad_s = 0.0;
    TEST_ASSERT_EQUAL(0, restrictions());
    enable(0, PV);
    SET(0x60FF, 0, (uint32_t)(-side * 100000));
    wait_ms(200);
    SET(0x60FF, 0, 0);
    wait_ms(200);
    CHECK_AT_LEAST("outside, rad", 0.15, side * machine.axis[0].turns * 6.283185307 - 1.0);
    TEST_ASSERT_EQUAL_HEX32(STATE_ENABLED, state_of(0));
    TEST_ASSERT_TRUE(says_it_moves_away(side));
  }
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_without_a_travel_an_axis_is_not_enabled_and_says_so);
  RUN_TEST(test_commissioning_is_slow);
  RUN_TEST(test_the_recorded_reference_is_0_while_protection_brakes);
  RUN_TEST(test_the_fastest_rate_is_on_the_bus);
  RUN_TEST(test_no_ramp_goes_into_the_stopping_margin);
  RUN_TEST(test_an_axis_without_torque_is_stopped_before_the_end_every_time);
  RUN_TEST(test_an_ordered_stop_that_the_axis_does_not_follow_is_a_fault);
  RUN_TEST(test_a_start_in_an_unknown_turn_is_confirmed_by_the_operator);
  RUN_TEST(test_a_target_waits_while_the_turn_is_unknown_and_is_dropped_then);
  RUN_TEST(test_the_only_turn_within_the_travel_is_taken);
  RUN_TEST(test_a_second_without_the_encoder_forgets_the_turn);
  RUN_TEST(test_without_an_angle_protection_demands_no_torque);
  RUN_TEST(test_after_an_encoder_that_jumps_the_turn_is_found_again);
  RUN_TEST(test_after_readings_that_count_hundreds_of_turns_the_turn_is_found_again);
  RUN_TEST(test_an_endless_axis_keeps_its_turn_when_readings_count_hundreds_of_them);
  RUN_TEST(test_an_endless_axis_keeps_its_turn_when_wrong_readings_stand_still);
  RUN_TEST(test_an_endless_axis_keeps_its_turn_in_a_reset_of_the_node);
  RUN_TEST(test_an_encoder_that_jumps_makes_a_confirmed_turn_unknown);
  RUN_TEST(test_wrong_readings_between_ticks_without_one_do_not_count_a_turn);
  RUN_TEST(test_one_wrong_reading_does_not_tell_the_turn);
  RUN_TEST(test_a_fast_axis_without_an_angle_for_long_may_be_a_turn_further);
  RUN_TEST(test_the_delay_of_the_rate_follows_its_window);
  RUN_TEST(test_an_axis_outside_of_its_travel_is_moved_inwards_only);
  return UNITY_END();
}
