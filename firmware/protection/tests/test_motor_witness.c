/* SPDX-License-Identifier: Apache-2.0 */
/* The motor as a witness, on a motor whose true R and Ke are known: when it contradicts, when it must not. */
#include "protection/motor_witness.h"

#include <math.h>

#include "support/check.h"
#include "unity.h"

#define DT_S 0.001f
#define R_OHM 1.2f
#define L_S (3e-3f / 1.2f) /* L / R */
#define KE 2.5f

void setUp(void) {}
void tearDown(void) {}

typedef struct {
  motor_witness witness;
  motor_witness_limits limits;
  motor_data data;
  float resistance_ohm; /* the true ones */
  float back_emf_v_s_rad;
  float offset_a;
  float last_a;
} bench;

static bench new_bench(void) {
  bench b = {.witness = {0},
             .limits = {.tolerance = 0.32f, .back_emf_error_v = 0.03f, .largest_zero_a = 0.5f, .largest_v = 4.0f},
             .data = {R_OHM, L_S, KE},
             .resistance_ohm = R_OHM,
             .back_emf_v_s_rad = KE};
  return b;
}

/* One tick with these true values; the sensors show `seen_rad_s`. */
static motor_verdict step(bench *b, float current_a, float true_rad_s, float seen_rad_s) {
  const float voltage_v =
      b->resistance_ohm * current_a + b->back_emf_v_s_rad * true_rad_s + 3e-3f / DT_S * (current_a - b->last_a);
  b->last_a = current_a;
  const motor_witness_inputs in = {.driven = true,
                                   .voltage_v = voltage_v,
                                   .current_a = current_a + b->offset_a,
                                   .now_a = current_a + b->offset_a,
                                   .rate_rad_s = seen_rad_s};
  const motor_verdict verdict = motor_witness_step(&b->witness, &b->limits, &b->data, &in, DT_S);
  motor_witness_learn(&b->witness, &b->limits, DT_S);
  return verdict;
}

static void rest_off(bench *b, int ticks) {
  for (int i = 0; i < ticks; ++i) {
    const motor_witness_inputs in = {.idle = true, .current_a = b->offset_a, .now_a = b->offset_a};
    TEST_ASSERT_EQUAL(MOTOR_AGREES, motor_witness_step(&b->witness, &b->limits, &b->data, &in, DT_S));
    motor_witness_learn(&b->witness, &b->limits, DT_S);
  }
  b->last_a = 0.0f;
}

static void agree(bench *b, float current_a, float rate_rad_s, int ticks) {
  for (int i = 0; i < ticks; ++i) {
    TEST_ASSERT_EQUAL(MOTOR_AGREES, step(b, current_a, rate_rad_s, rate_rad_s));
  }
}

/* Ticks until a verdict other than MOTOR_AGREES; 0: none in `most`. */
static int ticks_until(bench *b, motor_verdict expected, float current_a, float true_rad_s, float seen_rad_s,
                       int most) {
  for (int i = 1; i <= most; ++i) {
    const motor_verdict verdict = step(b, current_a, true_rad_s, seen_rad_s);
    if (verdict != MOTOR_AGREES) {
      TEST_ASSERT_EQUAL(expected, verdict);
      return i;
    }
  }
  return 0;
}

static float width(motor_interval interval) { return interval.high - interval.low; }

static void test_every_motor_within_the_tolerance_agrees_in_every_motion(void) {
  static const float shares[] = {0.7f, 0.85f, 1.0f, 1.15f, 1.3f};
  for (int r = 0; r < 5; ++r) {
    for (int k = 0; k < 5; ++k) {
      bench b = new_bench();
      rest_off(&b, 60);
      b.resistance_ohm = shares[r] * R_OHM;
      b.back_emf_v_s_rad = shares[k] * KE;
      for (int i = 0; i < 6000; ++i) {
        const float t = (float)i * DT_S;
        const float rate_rad_s = 1.2f * sinf(2.0f * t);
        TEST_ASSERT_EQUAL(MOTOR_AGREES,
                          step(&b, 8.0f * sinf(3.3f * t) + 2.0f * sinf(200.0f * t), rate_rad_s, rate_rad_s));
      }
      TEST_ASSERT_TRUE(b.witness.resistance.low <= shares[r] && shares[r] <= b.witness.resistance.high);
      TEST_ASSERT_TRUE(b.witness.back_emf.low <= shares[k] && shares[k] <= b.witness.back_emf.high);
      TEST_ASSERT_TRUE(width(b.witness.resistance) < 0.1f);
      TEST_ASSERT_TRUE(width(b.witness.back_emf) < 0.35f);
    }
  }
}

/* The bound that the header states: a motion below it may stay unseen, one above it is found. */
static void test_a_motion_that_the_sensors_do_not_show_is_found_above_the_bound_and_not_below_the_error(void) {
  for (int sign = -1; sign <= 1; sign += 2) {
    const float current_a = (float)sign * 4.0f;
    bench b = new_bench();
    rest_off(&b, 60);
    agree(&b, current_a, 0.0f, 1000);
    const float bound_rad_s = motor_witness_bound_rad_s(&b.witness, &b.limits);
    CHECK_AT_MOST("rad/s", 0.08, bound_rad_s);
    TEST_ASSERT_EQUAL(0, ticks_until(&b, MOTOR_CONTRADICTS, current_a, (float)sign * 0.9f * 0.03f / KE, 0.0f, 300));
    const int ticks = ticks_until(&b, MOTOR_CONTRADICTS, current_a, (float)sign * 1.3f * bound_rad_s, 0.0f, 100);
    TEST_ASSERT_TRUE(ticks >= MOTOR_WITNESS_TICKS);
    TEST_ASSERT_TRUE(ticks <= 25);
  }
}

/* From 0 the torque of a loop that sees nothing rises, and with it the speed: the witness still learns while it does.
 */
static void test_a_speed_that_grows_with_the_current_does_not_hide_in_the_resistance(void) {
  bench b = new_bench();
  rest_off(&b, 60);
  for (int i = 0; i < 500; ++i) {
    (void)step(&b, 4.0f * (float)i / 500.0f, 0.0f, 0.0f);
  }
  float rate_rad_s = 0.0f;
  float current_a = 4.0f;
  int ticks = 0;
  while (step(&b, current_a, rate_rad_s, 0.0f) == MOTOR_AGREES && ticks < 1000) {
    current_a += 0.009f;
    rate_rad_s += 0.0006f;
    ++ticks;
  }
  CHECK_AT_MOST("rad/s", 0.09, rate_rad_s);
}

/* --- the limits of the header ------------------------------------------------------------------------------------- */

/* The verdict on constant signals, on intervals as wide as at the start. */
static motor_verdict verdict_on(float voltage_v, float current_a, float rate_rad_s) {
  bench b = new_bench();
  rest_off(&b, 60);
  motor_verdict verdict = MOTOR_AGREES;
  for (int i = 0; i < 200; ++i) { /* the first current is a step: its inductive voltage decays in the filter */
    const motor_witness_inputs in = {
        .driven = true, .voltage_v = voltage_v, .current_a = current_a, .now_a = current_a, .rate_rad_s = rate_rad_s};
    verdict = motor_witness_step(&b.witness, &b.limits, &b.data, &in, DT_S);
  }
  return verdict;
}

/* All permitted motors: R from 0.68 to 1.42 times 1.2 ohm, Ke from 0.68 to 1.32 times 2.5 Vs/rad, and e. */
static void test_a_voltage_contradicts_beyond_what_every_permitted_motor_explains(void) {
  static const struct {
    float current_a, rate_rad_s, low_v, high_v;
  } edges[] = {
      {0.0f, 0.0f, -0.03f, 0.03f},
      {2.0f, 0.0f, 0.68f * 2.4f - 0.03f, 1.42f * 2.4f + 0.03f},
      {-2.0f, 0.0f, -1.42f * 2.4f - 0.03f, -0.68f * 2.4f + 0.03f},
      {0.0f, 1.0f, 0.68f * 2.5f - 0.13f, 1.32f * 2.5f + 0.13f}, /* a ripple of 4 % */
      {0.0f, -1.0f, -1.32f * 2.5f - 0.13f, -0.68f * 2.5f + 0.13f},
      {2.0f, -1.0f, 0.68f * 2.4f - 1.32f * 2.5f - 0.13f, 1.42f * 2.4f - 0.68f * 2.5f + 0.13f},
      {2.0f, 1.0f, 0.68f * 2.4f + 0.68f * 2.5f - 0.13f, 1.42f * 2.4f + 1.32f * 2.5f + 0.13f},
  };
  for (unsigned i = 0; i < sizeof edges / sizeof edges[0]; ++i) {
    const float low_v = edges[i].low_v;
    const float high_v = edges[i].high_v;
    TEST_ASSERT_EQUAL(MOTOR_AGREES, verdict_on(low_v + 0.001f, edges[i].current_a, edges[i].rate_rad_s));
    TEST_ASSERT_EQUAL(MOTOR_AGREES, verdict_on(high_v - 0.001f, edges[i].current_a, edges[i].rate_rad_s));
    TEST_ASSERT_TRUE(verdict_on(low_v - 0.001f, edges[i].current_a, edges[i].rate_rad_s) != MOTOR_AGREES);
    TEST_ASSERT_TRUE(verdict_on(high_v + 0.001f, edges[i].current_a, edges[i].rate_rad_s) != MOTOR_AGREES);
  }
}

/* Too little back-EMF of the right sign is that of weak magnets; none, or one of the wrong sign, is not. */
static void test_a_motor_is_weak_only_with_a_back_emf_of_the_right_sign(void) {
  TEST_ASSERT_EQUAL(MOTOR_WEAK, verdict_on(1.5f, 0.0f, 1.0f));
  TEST_ASSERT_EQUAL(MOTOR_WEAK, verdict_on(-1.5f, 0.0f, -1.0f));
  TEST_ASSERT_EQUAL(MOTOR_WEAK, verdict_on(0.1f, 0.0f, 1.0f));
  TEST_ASSERT_EQUAL(MOTOR_CONTRADICTS, verdict_on(0.0f, 0.0f, 1.0f));
  TEST_ASSERT_EQUAL(MOTOR_CONTRADICTS, verdict_on(-0.1f, 0.0f, 1.0f));
  TEST_ASSERT_EQUAL(MOTOR_CONTRADICTS, verdict_on(0.1f, 0.0f, -1.0f));
  TEST_ASSERT_EQUAL(MOTOR_CONTRADICTS, verdict_on(4.0f, 0.0f, 1.0f));
  TEST_ASSERT_EQUAL(MOTOR_CONTRADICTS, verdict_on(-4.0f, 0.0f, -1.0f));
}

/* (2 e + the width of R times R i) / Ke + the width of Ke times w, both intervals as at the start. */
static void test_the_bound_is_that_of_the_header(void) {
  static const struct {
    float current_a, rate_rad_s, acceleration_rad_s2, expected_rad_s;
  } cases[] = {
      {0.0f, 0.0f, 0.0f, 0.06f / 2.5f},
      {2.0f, 0.0f, 0.0f, (0.06f + 0.74f * 2.4f) / 2.5f},
      {-2.0f, 0.0f, 0.0f, (0.06f + 0.74f * 2.4f) / 2.5f},
      {0.0f, -1.0f, 0.0f, (0.06f + 0.2f) / 2.5f + 0.64f},
      {0.0f, 0.0f, 5.0f, 0.06f / 2.5f + 2.0f * 0.001f * 5.0f},
      {0.0f, 0.0f, -5.0f, 0.06f / 2.5f + 2.0f * 0.001f * 5.0f},
  };
  for (unsigned i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
    bench b = new_bench();
    rest_off(&b, 60);
    for (int tick = 0; tick < 200; ++tick) {
      const float until_end_s =
          DT_S * (float)(tick - 195); /* the filter is 5 ms late: then its rate is the wanted one */
      const motor_witness_inputs in = {.driven = true,
                                       .current_a = cases[i].current_a,
                                       .now_a = cases[i].current_a,
                                       .rate_rad_s = cases[i].rate_rad_s + cases[i].acceleration_rad_s2 * until_end_s};
      (void)motor_witness_step(&b.witness, &b.limits, &b.data, &in, DT_S);
    }
    CHECK_NEAR("rad/s", cases[i].expected_rad_s, motor_witness_bound_rad_s(&b.witness, &b.limits), 1e-3);
  }
}

/* Of 6 V, e is 0.03 V: R is known to 0.5 % to either side, and to what it may drift in a tick. */
static void test_the_interval_of_the_resistance_becomes_as_narrow_as_the_error_permits(void) {
  for (int sign = -1; sign <= 1; sign += 2) {
    bench b = new_bench();
    rest_off(&b, 60);
    b.resistance_ohm = 0.9f * R_OHM;
    agree(&b, 5.0f * (float)sign, 0.0f, 1000);
    CHECK_NEAR("lowest", 0.9 - 0.005, b.witness.resistance.low, 1e-4);
    CHECK_NEAR("highest", 0.9 + 0.005, b.witness.resistance.high, 1e-4);
    CHECK_NEAR("lowest of Ke", 0.68, b.witness.back_emf.low, 1e-4);
    CHECK_NEAR("highest of Ke", 1.32, b.witness.back_emf.high, 1e-4);
  }
}

/* With R unknown the current must be small: at none, Ke is known to the error of 0.03 V and 4 % ripple. */
static void test_the_interval_of_the_back_emf_becomes_as_narrow_as_the_error_permits(void) {
  for (int sign = -1; sign <= 1; sign += 2) {
    bench b = new_bench();
    rest_off(&b, 60);
    b.back_emf_v_s_rad = 1.1f * KE;
    agree(&b, 0.0f, 1.2f * (float)sign, 1000);
    CHECK_NEAR("lowest", 1.1 - 0.04 - 0.01, b.witness.back_emf.low, 1e-4);
    CHECK_NEAR("highest", 1.1 + 0.04 + 0.01, b.witness.back_emf.high, 1e-4);
    CHECK_NEAR("lowest of R", 0.68, b.witness.resistance.low, 1e-4);
    CHECK_NEAR("highest of R", 1.42, b.witness.resistance.high, 1e-4);
  }
}

/* A share is learned when its voltage is more than twice the error of 0.03 V. */
static void test_a_voltage_of_less_than_twice_the_error_teaches_nothing(void) {
  bench b = new_bench();
  rest_off(&b, 60);
  b.resistance_ohm = 0.7f * R_OHM;
  agree(&b, 0.057f / R_OHM, 0.0f, 500);
  CHECK_SAME("highest", 1.42f, b.witness.resistance.high);
  agree(&b, 0.063f / R_OHM, 0.0f, 500);
  CHECK_NEAR("highest", 0.7 + 0.03 / 0.063, b.witness.resistance.high, 2e-3);
}

/* It is learned from signals that are four times as smooth as those that are judged: 20 ms. */
static void test_the_signals_that_are_learned_from_follow_within_20_ms(void) {
  bench b = new_bench();
  rest_off(&b, 60);
  agree(&b, 0.0f, 0.0f, 10);
  agree(&b, 5.0f, 0.0f, 5);
  CHECK_NEAR("A, of what is judged", 5.0 * (1.0 - pow(0.8, 5.0)), b.witness.fast.current_a, 1e-3);
  agree(&b, 5.0f, 0.0f, 20);
  double fast = 0.0;
  double slow = 0.0;
  for (int i = 0; i < 25; ++i) {
    fast += (5.0 - fast) * 0.2;
    slow += (fast - slow) * 0.05;
  }
  CHECK_NEAR("A, of what is learned from", slow, b.witness.slow.current_a, 1e-3);
}

static void test_the_offset_is_a_mean_over_10_ms(void) {
  bench b = new_bench();
  b.offset_a = 0.04f;
  rest_off(&b, 10);
  CHECK_NEAR("A", 0.04 * (1.0 - pow(0.9, 10.0)), b.witness.zero_a, 1e-6);
}

/* By more than 0.05 A, and than a tenth of 2060:13 (0.5 A), for three ticks. */
static void test_another_offset_is_measured_anew(void) {
  for (int sign = -1; sign <= 1; sign += 2) {
    bench b = new_bench();
    rest_off(&b, 100);
    b.offset_a = (float)sign * 0.2f;
    rest_off(&b, 2);
    CHECK_NEAR("A", sign * 0.2 * (1.0 - pow(0.9, 2.0)), b.witness.zero_a, 1e-6);
    rest_off(&b, 1);
    CHECK_NEAR("A", sign * 0.2, b.witness.zero_a, 1e-6);
    TEST_ASSERT_TRUE(motor_witness_zero_error_a(&b.witness) > 0.0f);
    rest_off(&b, 49);
    CHECK_SAME("A", 0.0, motor_witness_zero_error_a(&b.witness));
  }
}

static void test_the_resistance_is_learned_from_a_current_and_forgotten_with_time(void) {
  bench b = new_bench();
  rest_off(&b, 60);
  b.resistance_ohm = 1.38f * R_OHM; /* a warm winding */
  agree(&b, 5.0f, 0.0f, 500);
  CHECK_AT_MOST("of R", 0.02, width(b.witness.resistance));
  TEST_ASSERT_TRUE(b.witness.resistance.low <= 1.38f && b.witness.resistance.high >= 1.38f);
  rest_off(&b, 1000); /* 3 % per second, to either side */
  CHECK_NEAR("of R", 0.06, width(b.witness.resistance), 0.025);
  rest_off(&b, 60000);
  CHECK_SAME("lowest", 0.68f, b.witness.resistance.low);
  CHECK_SAME("highest", 1.42f, b.witness.resistance.high);
}

static void test_a_winding_that_warms_by_3_percent_a_second_is_followed(void) {
  bench b = new_bench();
  rest_off(&b, 60);
  for (int i = 0; i < 10000; ++i) {
    b.resistance_ohm = R_OHM * (1.0f + 0.029e-3f * (float)i);
    TEST_ASSERT_EQUAL(MOTOR_AGREES, step(&b, 16.0f, 0.0f, 0.0f));
  }
}

static void test_a_motor_with_half_its_back_emf_is_weak_once_it_has_been_moved_at_low_and_high_current(void) {
  bench b = new_bench();
  rest_off(&b, 60);
  b.back_emf_v_s_rad = 0.5f * KE;
  agree(&b, 6.0f, 0.0f, 300);
  const int ticks = ticks_until(&b, MOTOR_WEAK, 4.0f, 0.7f, 0.7f, 200);
  TEST_ASSERT_TRUE(ticks > 0 && ticks <= 30);
}

static void test_a_motor_that_turns_in_the_opposite_direction_is_no_weak_motor(void) {
  bench b = new_bench();
  rest_off(&b, 60);
  agree(&b, 4.0f, 0.0f, 300);
  TEST_ASSERT_TRUE(ticks_until(&b, MOTOR_CONTRADICTS, 4.0f, -0.3f, 0.3f, 50) > 0);
}

static void test_the_offset_of_the_current_is_learned_while_the_bridge_is_off(void) {
  bench b = new_bench();
  b.offset_a = 0.2f;
  rest_off(&b, 100);
  CHECK_NEAR("A", 0.2, b.witness.zero_a, 1e-3);
  agree(&b, 2.0f, 0.0f, 300);
  CHECK_AT_MOST("of R", 0.05, width(b.witness.resistance));
}

static void test_an_offset_that_is_a_fault_of_its_own_is_not_learned(void) {
  bench b = new_bench();
  b.offset_a = 0.6f;
  rest_off(&b, 100);
  CHECK_SAME("A", 0.0, b.witness.zero_a);
}

static void test_before_the_offset_is_known_the_error_is_larger(void) {
  bench b = new_bench();
  agree(&b, 1.0f, 0.0f, 300);
  const float bound_rad_s = motor_witness_bound_rad_s(&b.witness, &b.limits);
  bench known = new_bench();
  rest_off(&known, 60);
  agree(&known, 1.0f, 0.0f, 300);
  TEST_ASSERT_TRUE(bound_rad_s > 1.5f * motor_witness_bound_rad_s(&known.witness, &known.limits));
}

/* The true L is 25 % above that of 2055, and the bridge puts up to 3 V across it: the error grows by its share. */
static void test_an_inductance_within_the_tolerance_agrees_with_a_current_that_swings(void) {
  bench b = new_bench();
  b.data.time_constant_s = 0.8f * L_S;
  rest_off(&b, 60);
  for (int i = 0; i < 3000; ++i) {
    TEST_ASSERT_EQUAL(MOTOR_AGREES, step(&b, 8.0f * sinf(6.2831853f * 20.0f * (float)i * DT_S), 0.0f, 0.0f));
  }
}

static void test_the_back_emf_is_learned_from_a_motion_and_forgotten_slowly(void) {
  bench b = new_bench();
  rest_off(&b, 60);
  b.back_emf_v_s_rad = 1.1f * KE;
  agree(&b, 0.0f, 1.2f, 1000);
  const float learned = width(b.witness.back_emf);
  CHECK_AT_MOST("of Ke", 0.25, learned);
  rest_off(&b, 10000); /* 0.3 % per second, to either side */
  CHECK_NEAR("of Ke", learned + 0.06f, width(b.witness.back_emf), 0.002);
}

static void test_the_offset_counts_as_known_after_50_ticks_without_current(void) {
  bench b = new_bench();
  rest_off(&b, 49);
  CHECK_SAME("A", 0.05f, motor_witness_zero_error_a(&b.witness));
  rest_off(&b, 1);
  CHECK_SAME("A", 0.0, motor_witness_zero_error_a(&b.witness));
}

/* A current sensor that is stuck has moved R; its repair is not a fault of the motor. */
static void test_what_was_learned_from_a_broken_sensor_can_be_forgotten(void) {
  bench b = new_bench();
  rest_off(&b, 60);
  b.resistance_ohm = 1.2f * R_OHM;
  agree(&b, 6.0f, 0.0f, 300);
  rest_off(&b, 60);
  b.resistance_ohm = 0.9f * R_OHM;
  bench kept = b;
  TEST_ASSERT_TRUE(ticks_until(&kept, MOTOR_CONTRADICTS, 6.0f, 0.0f, 0.0f, 200) > 0);
  motor_witness_forget(&b.witness);
  agree(&b, 6.0f, 0.0f, 300);
}

/* A converter with an offset of 45 mA: with 1.2 ohm this is more than e, and less than the 50 mA that an offset may be
 * which has not been measured since. */
static void test_an_offset_that_was_forgotten_is_unknown_until_it_is_measured_again(void) {
  bench b = new_bench();
  b.offset_a = 0.045f;
  rest_off(&b, 100);
  motor_witness_forget(&b.witness);
  CHECK_SAME("A", 0.05f, motor_witness_zero_error_a(&b.witness));
  agree(&b, 0.0f, 0.0f, 300);
  rest_off(&b, 49);
  CHECK_SAME("A", 0.05f, motor_witness_zero_error_a(&b.witness));
  rest_off(&b, 1);
  CHECK_SAME("A", 0.0, motor_witness_zero_error_a(&b.witness));
}

/* An error this large is a fault of the current sensor. */
static void test_an_error_beyond_the_voltage_mismatch_is_left_to_that_monitor(void) {
  bench b = new_bench();
  rest_off(&b, 60);
  agree(&b, 2.0f, 0.0f, 300);
  int counted = 0;
  for (int i = 0; i < 200; ++i) {
    (void)step(&b, 2.0f, 4.0f, 0.0f);
    counted = b.witness.ticks;
  }
  TEST_ASSERT_TRUE(counted < MOTOR_WITNESS_TICKS);
}

/* 20 V that nothing explains for 10 ticks: the smoothed error is below 4 V in the first of them only. In the seventh
 * tick after them it is again, and the count goes on. */
static void test_ticks_with_an_error_beyond_the_voltage_mismatch_are_not_counted(void) {
  bench b = new_bench();
  rest_off(&b, 60);
  for (int i = 0; i < 10; ++i) {
    const motor_witness_inputs in = {.driven = true, .voltage_v = 20.0f};
    TEST_ASSERT_EQUAL(MOTOR_AGREES, motor_witness_step(&b.witness, &b.limits, &b.data, &in, DT_S));
    TEST_ASSERT_EQUAL(1, b.witness.ticks);
  }
  const motor_witness_inputs in = {.driven = true};
  for (int i = 1; i <= 10; ++i) {
    TEST_ASSERT_EQUAL(i < 10 ? MOTOR_AGREES : MOTOR_CONTRADICTS,
                      motor_witness_step(&b.witness, &b.limits, &b.data, &in, DT_S));
  }
}

/* At full current that monitor permits 2060:22 of R i more: what it leaves is judged here. */
static void test_at_full_current_an_error_of_9_V_is_found(void) {
  bench b = new_bench();
  rest_off(&b, 60);
  agree(&b, 16.0f, 0.0f, 300);
  TEST_ASSERT_TRUE(ticks_until(&b, MOTOR_CONTRADICTS, 16.0f, 9.0f / KE, 0.0f, 200) > 0);
}

/* Not even before it has lasted long enough to be a verdict: the intervals drift apart only. */
static void test_nothing_is_learned_while_the_voltage_contradicts(void) {
  bench b = new_bench();
  rest_off(&b, 60);
  agree(&b, 4.0f, 0.0f, 1000);
  int ticks = 0;
  for (; b.witness.verdict == MOTOR_AGREES && ticks < 100; ++ticks) {
    TEST_ASSERT_EQUAL(MOTOR_AGREES, step(&b, 4.0f, 0.2f, 0.0f));
  }
  TEST_ASSERT_EQUAL(MOTOR_CONTRADICTS, b.witness.verdict);
  const motor_interval r = b.witness.resistance;
  for (int more = 1; more < MOTOR_WITNESS_TICKS; ++more) {
    TEST_ASSERT_EQUAL(more + 1 < MOTOR_WITNESS_TICKS ? MOTOR_AGREES : MOTOR_CONTRADICTS, step(&b, 4.0f, 0.2f, 0.0f));
    CHECK_NEAR("lowest R", (double)r.low - 0.03e-3 * more, b.witness.resistance.low, 1e-6);
    CHECK_NEAR("highest R", (double)r.high + 0.03e-3 * more, b.witness.resistance.high, 1e-6);
  }
}

static void test_a_contradiction_that_ends_is_forgotten(void) {
  bench b = new_bench();
  rest_off(&b, 60);
  agree(&b, 2.0f, 0.0f, 300);
  for (int i = 0; i < 40; ++i) {
    agree(&b, 2.0f, 0.0f, 30);
    TEST_ASSERT_EQUAL(MOTOR_AGREES, step(&b, 2.0f, 0.25f, 0.0f));
  }
}

static void test_a_tolerance_of_0_and_a_current_that_is_no_number_compare_nothing(void) {
  bench b = new_bench();
  b.limits.tolerance = 0.0f;
  TEST_ASSERT_EQUAL(0, ticks_until(&b, MOTOR_CONTRADICTS, 2.0f, 3.0f, 0.0f, 300));
  b = new_bench();
  TEST_ASSERT_EQUAL(0, ticks_until(&b, MOTOR_CONTRADICTS, NAN, 3.0f, 0.0f, 300));
}

static void test_each_motor_datum_that_changes_makes_what_was_learned_void(void) {
  static const motor_data others[] = {
      {0.99f * R_OHM, L_S, KE}, {1.01f * R_OHM, L_S, KE}, {R_OHM, L_S, 0.99f * KE}, {R_OHM, L_S, 1.01f * KE}};
  for (unsigned i = 0; i < sizeof others / sizeof others[0]; ++i) {
    bench b = new_bench();
    rest_off(&b, 60);
    agree(&b, 5.0f, 0.0f, 500);
    agree(&b, 0.0f, 1.0f, 500);
    TEST_ASSERT_TRUE(width(b.witness.resistance) < 0.1f && width(b.witness.back_emf) < 0.3f);
    b.data = others[i];
    const motor_witness_inputs in = {.driven = true};
    (void)motor_witness_step(&b.witness, &b.limits, &b.data, &in, DT_S);
    CHECK_NEAR("lowest R", 0.68, b.witness.resistance.low, 1e-6);
    CHECK_NEAR("highest R", 1.42, b.witness.resistance.high, 1e-6);
    CHECK_NEAR("lowest Ke", 0.68, b.witness.back_emf.low, 1e-6);
    CHECK_NEAR("highest Ke", 1.32, b.witness.back_emf.high, 1e-6);
  }
}

static void test_other_motor_data_begin_anew(void) {
  bench b = new_bench();
  rest_off(&b, 60);
  agree(&b, 5.0f, 0.0f, 500);
  TEST_ASSERT_TRUE(width(b.witness.resistance) < 0.05f);
  b.data.resistance_ohm = 1.4f * R_OHM;
  TEST_ASSERT_EQUAL(MOTOR_AGREES, step(&b, 5.0f, 0.0f, 0.0f));
  TEST_ASSERT_TRUE(b.witness.resistance.low <= 1.0f / 1.4f);
  b.resistance_ohm = R_OHM;
  agree(&b, 5.0f, 0.0f, 500);
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_every_motor_within_the_tolerance_agrees_in_every_motion);
  RUN_TEST(test_a_motion_that_the_sensors_do_not_show_is_found_above_the_bound_and_not_below_the_error);
  RUN_TEST(test_a_speed_that_grows_with_the_current_does_not_hide_in_the_resistance);
  RUN_TEST(test_a_voltage_contradicts_beyond_what_every_permitted_motor_explains);
  RUN_TEST(test_a_motor_is_weak_only_with_a_back_emf_of_the_right_sign);
  RUN_TEST(test_the_bound_is_that_of_the_header);
  RUN_TEST(test_the_interval_of_the_resistance_becomes_as_narrow_as_the_error_permits);
  RUN_TEST(test_the_interval_of_the_back_emf_becomes_as_narrow_as_the_error_permits);
  RUN_TEST(test_a_voltage_of_less_than_twice_the_error_teaches_nothing);
  RUN_TEST(test_the_signals_that_are_learned_from_follow_within_20_ms);
  RUN_TEST(test_the_offset_is_a_mean_over_10_ms);
  RUN_TEST(test_another_offset_is_measured_anew);
  RUN_TEST(test_the_resistance_is_learned_from_a_current_and_forgotten_with_time);
  RUN_TEST(test_a_winding_that_warms_by_3_percent_a_second_is_followed);
  RUN_TEST(test_a_motor_with_half_its_back_emf_is_weak_once_it_has_been_moved_at_low_and_high_current);
  RUN_TEST(test_a_motor_that_turns_in_the_opposite_direction_is_no_weak_motor);
  RUN_TEST(test_the_offset_of_the_current_is_learned_while_the_bridge_is_off);
  RUN_TEST(test_an_offset_that_is_a_fault_of_its_own_is_not_learned);
  RUN_TEST(test_before_the_offset_is_known_the_error_is_larger);
  RUN_TEST(test_what_was_learned_from_a_broken_sensor_can_be_forgotten);
  RUN_TEST(test_an_inductance_within_the_tolerance_agrees_with_a_current_that_swings);
  RUN_TEST(test_the_back_emf_is_learned_from_a_motion_and_forgotten_slowly);
  RUN_TEST(test_the_offset_counts_as_known_after_50_ticks_without_current);
  RUN_TEST(test_an_offset_that_was_forgotten_is_unknown_until_it_is_measured_again);
  RUN_TEST(test_an_error_beyond_the_voltage_mismatch_is_left_to_that_monitor);
  RUN_TEST(test_ticks_with_an_error_beyond_the_voltage_mismatch_are_not_counted);
  RUN_TEST(test_at_full_current_an_error_of_9_V_is_found);
  RUN_TEST(test_nothing_is_learned_while_the_voltage_contradicts);
  RUN_TEST(test_a_contradiction_that_ends_is_forgotten);
  RUN_TEST(test_a_tolerance_of_0_and_a_current_that_is_no_number_compare_nothing);
  RUN_TEST(test_each_motor_datum_that_changes_makes_what_was_learned_void);
  RUN_TEST(test_other_motor_data_begin_anew);
  return UNITY_END();
}
