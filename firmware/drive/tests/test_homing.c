/* SPDX-License-Identifier: Apache-2.0 */
/* Homing without a drive: an axis between two end stops, that follows its set-point or is blocked. */
#include "drive/homing.h"

#include "support/check.h"

static const float dt_s = 1e-3f;

static drive_homing state;
static drive_homing_objects objects;
static homing_inputs in;

void setUp(void) {
  state = (drive_homing){.phase = HOMING_NOT_STARTED};
  objects = (drive_homing_objects){
      .method = HOMING_DOWN_FIRST, .first_speed = 50000, .second_speed = 70000, .acceleration = 1000000};
  in = (homing_inputs){.runs = true, .in_mode = true, .contact_s = 0.25f};
}

void tearDown(void) {}

static void steps(int count) {
  for (int i = 0; i < count; ++i) {
    homing_step(&state, &objects, &in, dt_s);
    in.reference_rad_s = state.target_rad_s;
    in.rate_rad_s = in.torque_limited ? 0.0f : state.target_rad_s;
  }
}

static void start(int8_t method) {
  objects.method = method;
  steps(1);
  in.start = true;
  steps(1);
}

static void test_it_moves_in_the_direction_of_its_method_until_the_turn_is_known(void) {
  start(HOMING_DOWN_FIRST);
  TEST_ASSERT_EQUAL(HOMING_FIRST_PATH, state.phase);
  CHECK_NEAR("rad/s", -0.05, state.target_rad_s, 1e-6);
  TEST_ASSERT_FALSE(homing_is_idle(&state));
  steps(5000);
  in.position_known = true;
  steps(1);
  TEST_ASSERT_EQUAL(HOMING_ATTAINED, state.phase);
  CHECK_SAME("rad/s", 0.0, state.target_rad_s);
  setUp();
  start(HOMING_UP_FIRST);
  CHECK_NEAR("rad/s", 0.05, state.target_rad_s, 1e-6);
}

static void test_a_contact_turns_it_round_and_a_second_one_is_an_error(void) {
  start(HOMING_UP_FIRST);
  steps(100);
  in.torque_limited = true;
  steps(249);
  TEST_ASSERT_EQUAL(HOMING_FIRST_PATH, state.phase);
  steps(3);
  TEST_ASSERT_EQUAL(HOMING_SECOND_PATH, state.phase);
  CHECK_NEAR("rad/s", -0.07, state.target_rad_s, 1e-6);
  in.torque_limited = false;
  steps(5000);
  TEST_ASSERT_EQUAL(HOMING_SECOND_PATH, state.phase);
  in.torque_limited = true;
  steps(260);
  TEST_ASSERT_EQUAL(HOMING_FAILED, state.phase);
  CHECK_SAME("rad/s", 0.0, state.target_rad_s);
  TEST_ASSERT_TRUE(homing_is_idle(&state));
}

/* The torque limit alone, as in a gust, or with a motion that goes on. */
static void test_the_torque_limit_without_a_standstill_is_no_contact(void) {
  start(HOMING_UP_FIRST);
  for (int i = 0; i < 1000; ++i) {
    in.torque_limited = true;
    in.rate_rad_s = 0.6f * state.target_rad_s;
    homing_step(&state, &objects, &in, dt_s);
  }
  TEST_ASSERT_EQUAL(HOMING_FIRST_PATH, state.phase);
}

/* After a contact the set-point still points to the end stop until the ramp has reversed. */
static void test_nothing_is_judged_while_the_ramp_reverses(void) {
  start(HOMING_UP_FIRST);
  in.torque_limited = true; /* from the first step on */
  steps(249);
  TEST_ASSERT_EQUAL(HOMING_FIRST_PATH, state.phase);
  steps(4);
  TEST_ASSERT_EQUAL(HOMING_SECOND_PATH, state.phase);
  for (int i = 0; i < 1000; ++i) {
    in.reference_rad_s = 0.05f;
    in.rate_rad_s = 0.0f;
    homing_step(&state, &objects, &in, dt_s);
  }
  TEST_ASSERT_EQUAL(HOMING_SECOND_PATH, state.phase);
}

/* Against an end stop, with the set-point of another mode still pointing to it: what was before the start does not
 * count. In ticks of 2^-10 s, which add up exactly. */
static void test_the_time_of_a_contact_counts_from_the_start_of_the_path(void) {
  const float tick_s = 0x1p-10f;
  objects.method = HOMING_UP_FIRST;
  in.torque_limited = true;
  in.reference_rad_s = 0.05f;
  homing_step(&state, &objects, &in, tick_s);
  in.start = true;
  homing_step(&state, &objects, &in, tick_s);
  for (int i = 0; i < 256; ++i) {
    TEST_ASSERT_EQUAL(HOMING_FIRST_PATH, state.phase);
    homing_step(&state, &objects, &in, tick_s);
  }
  TEST_ASSERT_EQUAL(HOMING_FIRST_PATH, state.phase); /* 0.25 s: not longer yet */
  homing_step(&state, &objects, &in, tick_s);
  TEST_ASSERT_EQUAL(HOMING_SECOND_PATH, state.phase);
}

static void test_the_turn_that_was_seen_is_confirmed_without_motion(void) {
  const int8_t methods[] = {HOMING_HERE, HOMING_HERE_OLD};
  for (int i = 0; i < 2; ++i) {
    setUp();
    in.turn_seen = true;
    start(methods[i]);
    TEST_ASSERT_EQUAL(HOMING_CONFIRMING, state.phase);
    CHECK_SAME("rad/s", 0.0, state.target_rad_s);
    in.turn_seen = false; /* taken */
    in.position_known = true;
    steps(1);
    TEST_ASSERT_EQUAL(HOMING_ATTAINED, state.phase);
  }
}

static void test_nothing_seen_is_an_error(void) {
  start(HOMING_HERE);
  TEST_ASSERT_EQUAL(HOMING_FAILED, state.phase);
}

/* Wherever such a method came from: the axis stays, with the turn known or not. */
static void test_any_other_method_is_an_error_and_moves_nothing(void) {
  for (int method = -128; method < 128; ++method) {
    if (method == -1 || method == -2 || method == 35 || method == 37) {
      continue;
    }
    for (int known = 0; known < 2; ++known) {
      setUp();
      in.position_known = known != 0;
      start((int8_t)method);
      TEST_ASSERT_EQUAL(HOMING_FAILED, state.phase);
      CHECK_SAME("rad/s", 0.0, state.target_rad_s);
    }
  }
}

static void test_a_known_turn_needs_no_motion(void) {
  in.position_known = true;
  start(HOMING_UP_FIRST);
  TEST_ASSERT_EQUAL(HOMING_ATTAINED, state.phase);
  in.position_known = false; /* the encoder has jumped */
  steps(1);
  TEST_ASSERT_EQUAL(HOMING_NOT_STARTED, state.phase);
}

static void test_enabling_with_bit_4_starts_nothing(void) {
  in.runs = false;
  in.start = true;
  steps(10);
  in.runs = true;
  steps(10);
  TEST_ASSERT_EQUAL(HOMING_NOT_STARTED, state.phase);
  in.start = false;
  steps(1);
  in.start = true;
  steps(1);
  TEST_ASSERT_EQUAL(HOMING_FIRST_PATH, state.phase);
}

static void test_a_bit_4_that_rises_with_the_mode_starts(void) {
  in.in_mode = false;
  steps(10);
  in.in_mode = true;
  in.start = true;
  steps(1);
  TEST_ASSERT_EQUAL(HOMING_FIRST_PATH, state.phase);
}

static void test_bit_4_the_mode_and_a_halt_interrupt_it(void) {
  bool *const ends[] = {&in.start, &in.in_mode, &in.runs};
  for (int i = 0; i < 3; ++i) {
    setUp();
    start(HOMING_DOWN_FIRST);
    steps(10);
    *ends[i] = false;
    steps(1);
    TEST_ASSERT_EQUAL(HOMING_NOT_STARTED, state.phase);
    CHECK_SAME("rad/s", 0.0, state.target_rad_s);
    *ends[i] = true;
    in.start = true;
    steps(10);
    TEST_ASSERT_EQUAL(i == 0 ? HOMING_FIRST_PATH : HOMING_NOT_STARTED, state.phase);
  }
}

static void test_only_the_listed_methods_are_supported(void) {
  for (int method = -128; method < 128; ++method) {
    const bool listed = method == 0 || method == -1 || method == -2 || method == 35 || method == 37;
    TEST_ASSERT_EQUAL(listed, homing_method_supported((int8_t)method));
  }
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_it_moves_in_the_direction_of_its_method_until_the_turn_is_known);
  RUN_TEST(test_a_contact_turns_it_round_and_a_second_one_is_an_error);
  RUN_TEST(test_the_torque_limit_without_a_standstill_is_no_contact);
  RUN_TEST(test_nothing_is_judged_while_the_ramp_reverses);
  RUN_TEST(test_the_time_of_a_contact_counts_from_the_start_of_the_path);
  RUN_TEST(test_the_turn_that_was_seen_is_confirmed_without_motion);
  RUN_TEST(test_nothing_seen_is_an_error);
  RUN_TEST(test_any_other_method_is_an_error_and_moves_nothing);
  RUN_TEST(test_a_known_turn_needs_no_motion);
  RUN_TEST(test_enabling_with_bit_4_starts_nothing);
  RUN_TEST(test_a_bit_4_that_rises_with_the_mode_starts);
  RUN_TEST(test_bit_4_the_mode_and_a_halt_interrupt_it);
  RUN_TEST(test_only_the_listed_methods_are_supported);
  return UNITY_END();
}
