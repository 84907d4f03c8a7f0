/* SPDX-License-Identifier: Apache-2.0 */
/* The CiA 402 power state machine, against the standard's table and against python-canopen's masks. */
#include "drive/drive_state.h"

#include "support/check.h"

void setUp(void) {}
void tearDown(void) {}

enum { states = 8, NONE = -1 };

typedef struct {
  drive_state state;
  drive_options options;
  drive_state_inputs in;
} bench;

static bench bench_in(drive_power_state power) {
  return (bench){.state = {.power = power, .action = power == DRIVE_OPERATION_ENABLED ? DRIVE_RUN : DRIVE_OFF},
                 .options = drive_options_default(),
                 .in = {.ready = true, .voltage_present = true, .may_enable = true}};
}

static drive_action step(bench *b, uint16_t controlword) {
  b->in.controlword = controlword;
  return drive_state_step(&b->state, &b->options, &b->in);
}

static void expect(bench *b, uint16_t controlword, drive_power_state power, drive_action action) {
  char text[80];
  (void)snprintf(text, sizeof text, "controlword %04X in state %d", controlword, (int)b->state.power);
  const drive_action did = step(b, controlword);
  TEST_ASSERT_EQUAL_INT_MESSAGE((int)power, (int)b->state.power, text);
  TEST_ASSERT_EQUAL_INT_MESSAGE((int)action, (int)did, text);
}

/* The standard's command table (8.4.1): mask and value of the low byte, with bit 7 = 0 for commands that give power. */
typedef struct {
  uint8_t mask;
  uint8_t value;
  int8_t next[states]; /* with the option codes that switch off at once */
} row;

static const row rows[] = {
    /* mask, value, not ready, on disabled, ready, switched on, enabled, quick stop, reaction, fault */
    {0x02, 0x00, {NONE, NONE, 1, 1, 1, 1, NONE, NONE}},       /* disable voltage: 7, 10, 9, 12 */
    {0x06, 0x02, {NONE, NONE, 1, 1, 5, NONE, NONE, NONE}},    /* quick stop: 7, 10, 11 */
    {0x87, 0x06, {NONE, 2, NONE, 2, 2, NONE, NONE, NONE}},    /* shutdown: 2, 6, 8 */
    {0x8F, 0x07, {NONE, NONE, 3, NONE, 3, NONE, NONE, NONE}}, /* switch on, disable operation: 3, 5 */
    {0x8F, 0x0F, {NONE, NONE, 3, 4, NONE, 4, NONE, NONE}},    /* enable operation: 3, 4, 16 */
};

static int expected_next(uint16_t controlword, int power) {
  for (unsigned i = 0; i < sizeof rows / sizeof rows[0]; ++i) {
    if ((controlword & rows[i].mask) == rows[i].value) {
      return rows[i].next[power] == NONE ? power : rows[i].next[power];
    }
  }
  return power;
}

static void test_every_controlword_in_every_state_does_what_the_standards_table_says(void) {
  for (int power = DRIVE_SWITCH_ON_DISABLED; power <= DRIVE_QUICK_STOP_ACTIVE; ++power) {
    for (uint32_t controlword = 0; controlword <= UINT16_MAX; ++controlword) {
      for (int before = 0; before < 2; ++before) {
        bench b = bench_in((drive_power_state)power);
        b.options = (drive_options){.quick_stop = 6, .shutdown = 0, .disable = 0, .halt = 1, .fault_reaction = 0};
        b.state.reset_bit_before = before == 1;
        const drive_action action = step(&b, (uint16_t)controlword);
        if (expected_next((uint16_t)controlword, power) != (int)b.state.power) {
          LOG_VALUE("controlword", controlword);
          TEST_ASSERT_EQUAL_INT(expected_next((uint16_t)controlword, power), (int)b.state.power);
        }
        const bool powered = b.state.power == DRIVE_OPERATION_ENABLED || b.state.power == DRIVE_QUICK_STOP_ACTIVE;
        TEST_ASSERT_EQUAL_INT(powered, action != DRIVE_OFF);
      }
    }
  }
}

static void test_a_fault_is_left_by_the_rising_edge_of_bit_7_and_by_nothing_else(void) {
  for (uint32_t controlword = 0; controlword <= UINT16_MAX; ++controlword) {
    for (int before = 0; before < 2; ++before) {
      for (int present = 0; present < 2; ++present) {
        bench b = bench_in(DRIVE_FAULT);
        b.state.reset_bit_before = before == 1;
        b.in.fault = present == 1 ? DRIVE_FAULT_STOPS : DRIVE_NO_FAULT;
        TEST_ASSERT_EQUAL_INT(DRIVE_OFF, (int)step(&b, (uint16_t)controlword));
        const bool left = (controlword & 0x80) != 0 && before == 0 && present == 0;
        TEST_ASSERT_EQUAL_INT(left ? DRIVE_SWITCH_ON_DISABLED : DRIVE_FAULT, (int)b.state.power);
      }
    }
  }
}

static void test_a_reset_bit_that_was_set_before_the_fault_does_not_reset_it(void) {
  bench b = bench_in(DRIVE_SWITCHED_ON);
  expect(&b, 0x87, DRIVE_SWITCHED_ON, DRIVE_OFF);
  b.in.fault = DRIVE_FAULT_CUTS;
  expect(&b, 0x87, DRIVE_FAULT_REACTION_ACTIVE, DRIVE_OFF);
  expect(&b, 0x87, DRIVE_FAULT, DRIVE_OFF);
  b.in.fault = DRIVE_NO_FAULT;
  expect(&b, 0x87, DRIVE_FAULT, DRIVE_OFF);
  expect(&b, 0x07, DRIVE_FAULT, DRIVE_OFF);
  expect(&b, 0x80, DRIVE_SWITCH_ON_DISABLED, DRIVE_OFF);
}

/* An edge that comes too early is used up: the client must clear the bit and set it again. */
static void test_a_reset_while_the_fault_lasts_is_not_remembered(void) {
  bench b = bench_in(DRIVE_FAULT);
  b.in.fault = DRIVE_FAULT_STOPS;
  expect(&b, 0x80, DRIVE_FAULT, DRIVE_OFF);
  b.in.fault = DRIVE_NO_FAULT;
  expect(&b, 0x80, DRIVE_FAULT, DRIVE_OFF);
}

static void test_not_ready_lasts_until_the_self_test_is_done_whatever_is_commanded(void) {
  bench b = bench_in(DRIVE_NOT_READY);
  drive_state_reset(&b.state);
  b.in.ready = false;
  const uint16_t words[] = {0x06, 0x07, 0x0F, 0x80, 0x00, 0x02};
  for (unsigned i = 0; i < sizeof words / sizeof words[0]; ++i) {
    expect(&b, words[i], DRIVE_NOT_READY, DRIVE_OFF);
  }
  b.in.ready = true;
  expect(&b, 0x0F, DRIVE_SWITCH_ON_DISABLED, DRIVE_OFF);
}

static void test_python_canopens_steps_to_operation_enabled_takes_five_ticks(void) {
  bench b = bench_in(DRIVE_NOT_READY);
  expect(&b, 0x00, DRIVE_SWITCH_ON_DISABLED, DRIVE_OFF);
  expect(&b, 0x06, DRIVE_READY_TO_SWITCH_ON, DRIVE_OFF);
  expect(&b, 0x07, DRIVE_SWITCHED_ON, DRIVE_OFF);
  expect(&b, 0x0F, DRIVE_OPERATION_ENABLED, DRIVE_RUN);
  expect(&b, 0x0F, DRIVE_OPERATION_ENABLED, DRIVE_RUN);
}

static void test_enable_operation_from_ready_goes_through_switched_on(void) {
  bench b = bench_in(DRIVE_READY_TO_SWITCH_ON);
  expect(&b, 0x0F, DRIVE_SWITCHED_ON, DRIVE_OFF);
  expect(&b, 0x0F, DRIVE_OPERATION_ENABLED, DRIVE_RUN);
}

static void test_nothing_is_switched_on_without_bus_voltage(void) {
  bench b = bench_in(DRIVE_READY_TO_SWITCH_ON);
  b.in.voltage_present = false;
  expect(&b, 0x0F, DRIVE_READY_TO_SWITCH_ON, DRIVE_OFF);
}

/* canopen.profiles.p402.State402.SW_MASK */
static void test_statuswords_match_the_masks_of_python_canopen_and_only_their_own(void) {
  static const uint16_t masks[states][2] = {{0x4F, 0x00}, {0x4F, 0x40}, {0x6F, 0x21}, {0x6F, 0x23},
                                            {0x6F, 0x27}, {0x6F, 0x07}, {0x4F, 0x0F}, {0x4F, 0x08}};
  for (int power = 0; power < states; ++power) {
    for (int other = 0; other < states; ++other) {
      const uint16_t word = drive_state_statusword((drive_power_state)power);
      TEST_ASSERT_EQUAL_INT(power == other, (word & masks[other][0]) == masks[other][1]);
    }
    /* Bit 5, "no quick stop", in every state but one: masters look at it alone. */
    TEST_ASSERT_EQUAL_INT(power != DRIVE_QUICK_STOP_ACTIVE,
                          (drive_state_statusword((drive_power_state)power) & 0x20) != 0);
  }
}

static void test_halt_stops_by_its_option_and_lets_go_again(void) {
  bench b = bench_in(DRIVE_OPERATION_ENABLED);
  expect(&b, 0x10F, DRIVE_OPERATION_ENABLED, DRIVE_SLOW_DOWN);
  b.options.halt = 2;
  expect(&b, 0x10F, DRIVE_OPERATION_ENABLED, DRIVE_QUICK_STOP);
  expect(&b, 0x00F, DRIVE_OPERATION_ENABLED, DRIVE_RUN);
}

static void test_quick_stop_brakes_and_then_does_what_its_option_says(void) {
  static const struct {
    int16_t code;
    drive_action stop;
    bool stays;
  } options[] = {{1, DRIVE_SLOW_DOWN, false},
                 {2, DRIVE_QUICK_STOP, false},
                 {5, DRIVE_SLOW_DOWN, true},
                 {6, DRIVE_QUICK_STOP, true}};
  for (unsigned i = 0; i < sizeof options / sizeof options[0]; ++i) {
    bench b = bench_in(DRIVE_OPERATION_ENABLED);
    b.options.quick_stop = options[i].code;
    expect(&b, 0x02, DRIVE_QUICK_STOP_ACTIVE, options[i].stop);
    expect(&b, 0x02, DRIVE_QUICK_STOP_ACTIVE, options[i].stop);
    TEST_ASSERT_EQUAL(!options[i].stays, b.state.ends_off);
    b.in.stopped = true;
    if (options[i].stays) {
      expect(&b, 0x02, DRIVE_QUICK_STOP_ACTIVE, options[i].stop);
      bench halted = b;
      expect(&halted, 0x10F, DRIVE_OPERATION_ENABLED, DRIVE_SLOW_DOWN); /* not one tick of motion */
      expect(&b, 0x0F, DRIVE_OPERATION_ENABLED, DRIVE_RUN);
    } else {
      expect(&b, 0x0F, DRIVE_SWITCH_ON_DISABLED, DRIVE_OFF);
    }
  }
}

static void test_quick_stop_with_option_0_switches_off_at_once(void) {
  bench b = bench_in(DRIVE_OPERATION_ENABLED);
  b.options.quick_stop = 0;
  expect(&b, 0x02, DRIVE_QUICK_STOP_ACTIVE, DRIVE_OFF);
  expect(&b, 0x02, DRIVE_SWITCH_ON_DISABLED, DRIVE_OFF);
}

static void test_shutdown_and_disable_ramp_down_first_when_requested_to(void) {
  for (int which = 0; which < 2; ++which) {
    const uint16_t word = which == 0 ? 0x06 : 0x07;
    bench b = bench_in(DRIVE_OPERATION_ENABLED);
    b.options.shutdown = 1;
    b.options.disable = 1;
    expect(&b, word, DRIVE_OPERATION_ENABLED, DRIVE_SLOW_DOWN);
    TEST_ASSERT_TRUE(b.state.ends_off);
    expect(&b, 0x0F, DRIVE_OPERATION_ENABLED, DRIVE_RUN); /* another command before */
    TEST_ASSERT_FALSE(b.state.ends_off);
    expect(&b, word, DRIVE_OPERATION_ENABLED, DRIVE_SLOW_DOWN);
    expect(&b, word | 0x80, DRIVE_OPERATION_ENABLED, DRIVE_SLOW_DOWN); /* no command: the stop goes on */
    TEST_ASSERT_TRUE(b.state.ends_off);
    b.in.stopped = true;
    expect(&b, word, which == 0 ? DRIVE_READY_TO_SWITCH_ON : DRIVE_SWITCHED_ON, DRIVE_OFF);
  }
}

static void test_a_stop_of_the_last_operation_stops_nothing_in_the_next_one(void) {
  for (int which = 0; which < 2; ++which) {
    const uint16_t word = which == 0 ? 0x06 : 0x07;
    bench b = bench_in(DRIVE_OPERATION_ENABLED);
    b.options.shutdown = 1;
    b.options.disable = 1;
    expect(&b, word, DRIVE_OPERATION_ENABLED, DRIVE_SLOW_DOWN);
    b.in.stopped = true;
    expect(&b, word, which == 0 ? DRIVE_READY_TO_SWITCH_ON : DRIVE_SWITCHED_ON, DRIVE_OFF);
    b.in.stopped = false;
    expect(&b, 0x07, DRIVE_SWITCHED_ON, DRIVE_OFF);
    expect(&b, 0x0F, DRIVE_OPERATION_ENABLED, DRIVE_RUN);
    expect(&b, 0x8F, DRIVE_OPERATION_ENABLED, DRIVE_RUN); /* no command */
  }
}

static void test_a_fault_brakes_by_its_option_and_ends_in_fault(void) {
  static const drive_action stops[] = {DRIVE_OFF, DRIVE_SLOW_DOWN, DRIVE_QUICK_STOP};
  for (int16_t code = 0; code <= 2; ++code) {
    bench b = bench_in(DRIVE_OPERATION_ENABLED);
    b.options.fault_reaction = code;
    b.in.fault = DRIVE_FAULT_STOPS;
    expect(&b, 0x0F, DRIVE_FAULT_REACTION_ACTIVE, stops[code]);
    b.in.fault = DRIVE_NO_FAULT; /* gone, but it was present */
    if (code != 0) {
      expect(&b, 0x0F, DRIVE_FAULT_REACTION_ACTIVE, stops[code]);
      b.in.stopped = true;
    }
    expect(&b, 0x0F, DRIVE_FAULT, DRIVE_OFF);
    expect(&b, 0x0F, DRIVE_FAULT, DRIVE_OFF);
  }
}

static void test_a_fault_that_forbids_torque_cuts_it_even_while_braking(void) {
  bench b = bench_in(DRIVE_OPERATION_ENABLED);
  b.in.fault = DRIVE_FAULT_STOPS;
  expect(&b, 0x0F, DRIVE_FAULT_REACTION_ACTIVE, DRIVE_QUICK_STOP);
  b.in.fault = DRIVE_FAULT_CUTS;
  expect(&b, 0x0F, DRIVE_FAULT, DRIVE_OFF);
  b = bench_in(DRIVE_OPERATION_ENABLED);
  b.in.fault = DRIVE_FAULT_CUTS;
  expect(&b, 0x0F, DRIVE_FAULT_REACTION_ACTIVE, DRIVE_OFF);
}

static void test_every_state_without_torque_goes_to_fault_without_torque(void) {
  const drive_power_state without[] = {DRIVE_NOT_READY, DRIVE_SWITCH_ON_DISABLED, DRIVE_READY_TO_SWITCH_ON,
                                       DRIVE_SWITCHED_ON};
  for (unsigned i = 0; i < 4; ++i) {
    bench b = bench_in(without[i]);
    b.in.fault = DRIVE_FAULT_STOPS;
    expect(&b, 0x0F, DRIVE_FAULT_REACTION_ACTIVE, DRIVE_OFF);
    expect(&b, 0x0F, DRIVE_FAULT, DRIVE_OFF);
  }
}

static void test_a_fault_reaction_that_never_ends_is_cut_after_10_s(void) {
  bench b = bench_in(DRIVE_OPERATION_ENABLED);
  b.in.fault = DRIVE_FAULT_STOPS;
  int ticks = 0;
  while (step(&b, 0x0F) != DRIVE_OFF) {
    TEST_ASSERT_TRUE(++ticks < 20000);
  }
  LOG_VALUE("ticks until the torque is cut", ticks);
  TEST_ASSERT_EQUAL_INT(DRIVE_LONGEST_REACTION_TICKS + 1, ticks);
  TEST_ASSERT_EQUAL_INT(DRIVE_FAULT, (int)b.state.power);
}

/* From the fault to operation again, as a client does it. */
static void reset_and_enable(bench *b) {
  b->in.fault = DRIVE_NO_FAULT;
  b->in.stopped = false;
  expect(b, 0x00, DRIVE_FAULT, DRIVE_OFF);
  expect(b, 0x80, DRIVE_SWITCH_ON_DISABLED, DRIVE_OFF);
  expect(b, 0x06, DRIVE_READY_TO_SWITCH_ON, DRIVE_OFF);
  expect(b, 0x0F, DRIVE_SWITCHED_ON, DRIVE_OFF);
  expect(b, 0x0F, DRIVE_OPERATION_ENABLED, DRIVE_RUN);
}

static int ticks_of(bench *b, drive_action action) {
  int count = 0;
  while (step(b, 0x0F) == action) {
    TEST_ASSERT_TRUE(++count < 20000);
  }
  return count;
}

/* An axis that still turns when its second fault comes needs the whole reaction again. */
static void test_a_second_and_a_third_fault_are_braked_as_long_as_the_first(void) {
  static const struct {
    drive_fault fault;
    drive_action action;
    uint32_t longest;
  } kinds[] = {{DRIVE_FAULT_BRAKES, DRIVE_BRAKE, DRIVE_BRAKE_TICKS},
               {DRIVE_FAULT_STOPS, DRIVE_QUICK_STOP, DRIVE_LONGEST_REACTION_TICKS}};
  bench b = bench_in(DRIVE_OPERATION_ENABLED);
  for (int number = 1; number <= 6; ++number) {
    const unsigned kind = (unsigned)number & 1u;
    b.in.fault = kinds[kind].fault;
    TEST_ASSERT_EQUAL_INT((int)(kinds[kind].longest + 1), ticks_of(&b, kinds[kind].action));
    TEST_ASSERT_EQUAL_INT(DRIVE_FAULT, (int)b.state.power);
    reset_and_enable(&b);
  }
}

/* A milder reaction that has lasted for a while takes nothing from the worse one. */
static void test_a_worse_fault_during_a_reaction_brakes_for_its_own_whole_time(void) {
  bench b = bench_in(DRIVE_OPERATION_ENABLED);
  b.in.fault = DRIVE_FAULT_STOPS;
  for (int i = 0; i < 1500; ++i) {
    expect(&b, 0x0F, DRIVE_FAULT_REACTION_ACTIVE, DRIVE_QUICK_STOP);
  }
  b.in.fault = DRIVE_FAULT_BRAKES;
  TEST_ASSERT_EQUAL_INT(DRIVE_BRAKE_TICKS, ticks_of(&b, DRIVE_BRAKE));
  TEST_ASSERT_EQUAL_INT(DRIVE_FAULT, (int)b.state.power);
}

/* Only the first fault of a reaction counts from 0; its repetition must not keep the brake on. */
static void test_a_fault_that_comes_and_goes_while_braking_makes_the_brake_no_longer(void) {
  bench b = bench_in(DRIVE_OPERATION_ENABLED);
  int count = 0;
  do {
    b.in.fault = count % 3 == 0 ? DRIVE_FAULT_BRAKES : DRIVE_FAULT_STOPS;
    TEST_ASSERT_TRUE(++count < 20000);
  } while (step(&b, 0x0F) == DRIVE_BRAKE);
  TEST_ASSERT_EQUAL_INT(DRIVE_BRAKE_TICKS + 2, count);
}

/* --- the protective stop --- */

static void test_a_protective_stop_ignores_605e_and_ends_at_rest_or_after_3_s(void) {
  for (int16_t option = 0; option <= 2; ++option) {
    bench b = bench_in(DRIVE_OPERATION_ENABLED);
    b.options.fault_reaction = option;
    b.in.turns = true;
    b.in.fault = DRIVE_FAULT_PROTECTS;
    expect(&b, 0x0F, DRIVE_FAULT_REACTION_ACTIVE, DRIVE_PROTECTIVE_STOP);
    b.in.fault = DRIVE_NO_FAULT;
    for (uint32_t i = 0; i < (option == 0 ? 50 : DRIVE_LONGEST_PROTECTIVE_STOP_TICKS); ++i) {
      expect(&b, 0x00, DRIVE_FAULT_REACTION_ACTIVE, DRIVE_PROTECTIVE_STOP);
    }
    b.in.stopped = option == 0;
    expect(&b, 0x0F, DRIVE_FAULT, DRIVE_OFF);
  }
}

static void test_a_stop_becomes_protective_and_a_protective_stop_becomes_the_shorted_motor(void) {
  bench b = bench_in(DRIVE_OPERATION_ENABLED);
  b.in.turns = true;
  b.in.fault = DRIVE_FAULT_STOPS;
  expect(&b, 0x0F, DRIVE_FAULT_REACTION_ACTIVE, DRIVE_QUICK_STOP);
  b.in.fault = DRIVE_FAULT_PROTECTS;
  b.in.stopped = true; /* the ramp has ended, but the axis has not followed it */
  expect(&b, 0x0F, DRIVE_FAULT_REACTION_ACTIVE, DRIVE_PROTECTIVE_STOP);
  b.in.stopped = false;
  b.in.fault = DRIVE_FAULT_BRAKES;
  expect(&b, 0x0F, DRIVE_FAULT_REACTION_ACTIVE, DRIVE_BRAKE);
  b.in.fault = DRIVE_FAULT_PROTECTS; /* never milder */
  expect(&b, 0x0F, DRIVE_FAULT_REACTION_ACTIVE, DRIVE_BRAKE);
}

/* Switched off while it turned, or in fault with 605E = 0; one that came to rest stays off. */
static void test_an_axis_that_turns_since_it_had_torque_is_braked_and_no_other(void) {
  static const drive_power_state states_off[] = {DRIVE_SWITCH_ON_DISABLED, DRIVE_READY_TO_SWITCH_ON, DRIVE_SWITCHED_ON,
                                                 DRIVE_FAULT};
  for (unsigned i = 0; i < sizeof states_off / sizeof states_off[0]; ++i) {
    for (int turns = 0; turns <= 1; ++turns) {
      bench b = bench_in(states_off[i]);
      b.in.turns = turns != 0;
      b.in.fault = DRIVE_FAULT_PROTECTS;
      const drive_action did = step(&b, 0x00);
      TEST_ASSERT_EQUAL(turns ? DRIVE_PROTECTIVE_STOP : DRIVE_OFF, did);
      TEST_ASSERT_EQUAL(turns || states_off[i] != DRIVE_FAULT ? DRIVE_FAULT_REACTION_ACTIVE : DRIVE_FAULT,
                        b.state.power);
      if (turns) {
        expect(&b, 0x00, DRIVE_FAULT_REACTION_ACTIVE, DRIVE_PROTECTIVE_STOP);
      }
    }
  }
  static const drive_fault others[] = {DRIVE_FAULT_STOPS, DRIVE_FAULT_BRAKES, DRIVE_FAULT_CUTS};
  for (unsigned i = 0; i < sizeof others / sizeof others[0]; ++i) { /* in fault, they have nothing to stop */
    bench b = bench_in(DRIVE_FAULT);
    b.in.turns = true;
    b.in.fault = others[i];
    expect(&b, 0x00, DRIVE_FAULT, DRIVE_OFF);
  }
}

static void test_nothing_is_enabled_while_protection_does_not_know_the_travel(void) {
  bench b = bench_in(DRIVE_READY_TO_SWITCH_ON);
  b.in.may_enable = false;
  expect(&b, 0x0F, DRIVE_READY_TO_SWITCH_ON, DRIVE_OFF);
  b.state.power = DRIVE_SWITCHED_ON;
  expect(&b, 0x0F, DRIVE_SWITCHED_ON, DRIVE_OFF);
  b.in.may_enable = true;
  expect(&b, 0x0F, DRIVE_OPERATION_ENABLED, DRIVE_RUN);
}

static void test_option_codes_that_are_not_supported_are_refused(void) {
  static const uint16_t supported[] = {0x67, 0x03, 0x03, 0x06, 0x07};
  for (uint16_t index = 0x6059; index <= 0x605F; ++index) {
    for (int code = -2; code < 12; ++code) {
      const bool in_table = index >= 0x605A && index <= 0x605E && code >= 0;
      const bool expected = in_table && ((supported[index - 0x605A] >> code) & 1) != 0;
      TEST_ASSERT_EQUAL_INT(expected, drive_option_supported(index, (int16_t)code));
    }
  }
}

static void test_an_option_code_that_slipped_through_counts_as_the_default(void) {
  bench b = bench_in(DRIVE_OPERATION_ENABLED);
  b.options = (drive_options){.quick_stop = 7, .shutdown = -1, .disable = 9, .halt = 3, .fault_reaction = 99};
  expect(&b, 0x10F, DRIVE_OPERATION_ENABLED, DRIVE_SLOW_DOWN);
  expect(&b, 0x07, DRIVE_OPERATION_ENABLED, DRIVE_SLOW_DOWN);
  expect(&b, 0x02, DRIVE_QUICK_STOP_ACTIVE, DRIVE_QUICK_STOP);
  b = bench_in(DRIVE_OPERATION_ENABLED);
  b.options.shutdown = -1;
  expect(&b, 0x06, DRIVE_READY_TO_SWITCH_ON, DRIVE_OFF);
  b = bench_in(DRIVE_OPERATION_ENABLED);
  b.options.fault_reaction = 99;
  b.in.fault = DRIVE_FAULT_STOPS;
  expect(&b, 0x0F, DRIVE_FAULT_REACTION_ACTIVE, DRIVE_QUICK_STOP);
}

/* Whoever takes the defaults may write them: none of them would be refused, or be replaced. */
static void test_the_default_option_codes_are_supported(void) {
  const drive_options o = drive_options_default();
  const int16_t codes[] = {o.quick_stop, o.shutdown, o.disable, o.halt, o.fault_reaction};
  for (unsigned i = 0; i < sizeof codes / sizeof codes[0]; ++i) {
    TEST_ASSERT_TRUE(drive_option_supported((uint16_t)(0x605A + i), codes[i]));
  }
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_every_controlword_in_every_state_does_what_the_standards_table_says);
  RUN_TEST(test_a_fault_is_left_by_the_rising_edge_of_bit_7_and_by_nothing_else);
  RUN_TEST(test_a_reset_bit_that_was_set_before_the_fault_does_not_reset_it);
  RUN_TEST(test_a_reset_while_the_fault_lasts_is_not_remembered);
  RUN_TEST(test_not_ready_lasts_until_the_self_test_is_done_whatever_is_commanded);
  RUN_TEST(test_python_canopens_steps_to_operation_enabled_takes_five_ticks);
  RUN_TEST(test_enable_operation_from_ready_goes_through_switched_on);
  RUN_TEST(test_nothing_is_switched_on_without_bus_voltage);
  RUN_TEST(test_statuswords_match_the_masks_of_python_canopen_and_only_their_own);
  RUN_TEST(test_halt_stops_by_its_option_and_lets_go_again);
  RUN_TEST(test_quick_stop_brakes_and_then_does_what_its_option_says);
  RUN_TEST(test_quick_stop_with_option_0_switches_off_at_once);
  RUN_TEST(test_shutdown_and_disable_ramp_down_first_when_requested_to);
  RUN_TEST(test_a_stop_of_the_last_operation_stops_nothing_in_the_next_one);
  RUN_TEST(test_a_fault_brakes_by_its_option_and_ends_in_fault);
  RUN_TEST(test_a_fault_that_forbids_torque_cuts_it_even_while_braking);
  RUN_TEST(test_every_state_without_torque_goes_to_fault_without_torque);
  RUN_TEST(test_a_fault_reaction_that_never_ends_is_cut_after_10_s);
  RUN_TEST(test_a_second_and_a_third_fault_are_braked_as_long_as_the_first);
  RUN_TEST(test_a_worse_fault_during_a_reaction_brakes_for_its_own_whole_time);
  RUN_TEST(test_a_fault_that_comes_and_goes_while_braking_makes_the_brake_no_longer);
  RUN_TEST(test_a_protective_stop_ignores_605e_and_ends_at_rest_or_after_3_s);
  RUN_TEST(test_a_stop_becomes_protective_and_a_protective_stop_becomes_the_shorted_motor);
  RUN_TEST(test_an_axis_that_turns_since_it_had_torque_is_braked_and_no_other);
  RUN_TEST(test_nothing_is_enabled_while_protection_does_not_know_the_travel);
  RUN_TEST(test_option_codes_that_are_not_supported_are_refused);
  RUN_TEST(test_an_option_code_that_slipped_through_counts_as_the_default);
  RUN_TEST(test_the_default_option_codes_are_supported);
  return UNITY_END();
}
