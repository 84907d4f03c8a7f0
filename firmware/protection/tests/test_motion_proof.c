/* SPDX-License-Identifier: Apache-2.0 */
/* The test torque of a standing axis: who answers it, and who does not. */
#include "protection/motion_proof.h"

#include <complex.h>
#include <math.h>

#include "support/check.h"
#include "unity.h"

#define DT_S 0.001f
#define imaginary ((double complex)I) /* I itself is a float */
#define W_RAD_S (2.0 * 3.14159265358979 / (MOTION_PROOF_PERIOD_TICKS * 0.001))

/* The tracker's azimuth. */
static const motion_proof_axis azimuth = {.inertia_kg_m2 = 6.0f,
                                          .stiffness_nm_rad = 30000.0f,
                                          .damping_nm_s_rad = 308.0f,
                                          .proportional_gain = 2260.0f,
                                          .integral_gain = 213000.0f,
                                          .filter_gain = 1.0f,
                                          .position_per_s = 10.0f,
                                          .observer_rad_s = 220.0f,
                                          .observer_inertia_kg_m2 = 6.0f};

static const motion_proof_limits limits = {.answer_rad_s = 3e-5f, .most_nm = 0.8f};

void setUp(void) {}
void tearDown(void) {}

static void step(motion_proof *proof, double rate_rad_s) {
  motion_proof_step(proof, &limits, &azimuth, (float)rate_rad_s, false, DT_S);
}

/* Ticks until the fault with `answer` times the least answer and a vibration, 0: not within `most`. */
static int ticks_until(motion_proof *proof, double answer, double vibration_rad_s, double phase_rad, int most) {
  const double impedance = (double)motion_proof_impedance(&azimuth, DT_S);
  for (int i = 1; i <= most; ++i) {
    const double vibration = vibration_rad_s * sin(W_RAD_S * (i - 1) * 0.001 + phase_rad);
    step(proof, answer * (double)proof->torque_nm / impedance + vibration);
    if (proof->unanswered) {
      return i;
    }
  }
  return 0;
}

static void test_two_windows_without_an_answer_are_a_fault(void) {
  motion_proof proof = {0};
  TEST_ASSERT_EQUAL(2 * MOTION_PROOF_TICKS, ticks_until(&proof, 0.0, 0.0, 0.0, 1000));
}

static void test_half_of_the_least_answer_decides(void) {
  motion_proof proof = {0};
  TEST_ASSERT_EQUAL(0, ticks_until(&proof, 0.51, 0.0, 0.0, 10000));
  proof = (motion_proof){0};
  TEST_ASSERT_EQUAL(2 * MOTION_PROOF_TICKS, ticks_until(&proof, 0.49, 0.0, 0.0, 1000));
}

static void test_sensors_that_die_are_found_within_three_windows(void) {
  for (int after = 0; after < MOTION_PROOF_TICKS; after += 7) {
    motion_proof proof = {0};
    TEST_ASSERT_EQUAL(0, ticks_until(&proof, 1.0, 0.0, 0.0, 3 * MOTION_PROOF_TICKS + after));
    const int ticks = ticks_until(&proof, 0.0, 0.0, 0.0, 1000);
    TEST_ASSERT_TRUE(ticks >= MOTION_PROOF_TICKS && ticks <= 3 * MOTION_PROOF_TICKS);
  }
}

/* What takes the answer away in one window doubles it in the next. */
static void test_no_vibration_at_the_frequency_of_the_test_hides_an_answer(void) {
  const double answer_rad_s = 2.0 * (double)limits.answer_rad_s;
  for (int size = 1; size <= 20; ++size) {
    for (int phase = 0; phase < 16; ++phase) {
      motion_proof proof = {0};
      TEST_ASSERT_EQUAL(0, ticks_until(&proof, 1.0, 0.1 * size * answer_rad_s, phase * 0.3927, 2000));
    }
  }
}

static void test_an_axis_that_answers_well_is_swung_less(void) {
  const double whole_nm = 2.0 * (double)(limits.answer_rad_s * motion_proof_impedance(&azimuth, DT_S));
  motion_proof proof = {0};
  TEST_ASSERT_EQUAL(0, ticks_until(&proof, 2.5, 0.0, 0.0, 4 * MOTION_PROOF_TICKS));
  step(&proof, 0.0);
  CHECK_RELATIVE("torque, Nm", whole_nm / 2.5, proof.amplitude_nm, 0.01);
  proof = (motion_proof){0};
  TEST_ASSERT_EQUAL(0, ticks_until(&proof, 50.0, 0.0, 0.0, 10 * MOTION_PROOF_TICKS));
  step(&proof, 0.0);
  CHECK_RELATIVE("least torque, Nm", 0.2 * whole_nm, proof.amplitude_nm, 0.01);
  (void)ticks_until(&proof, 0.0, 0.0, 0.0, MOTION_PROOF_TICKS);
  CHECK_RELATIVE("torque after silence, Nm", whole_nm, proof.amplitude_nm, 0.01);
}

static void test_a_torque_that_could_not_act_proves_nothing(void) {
  motion_proof proof = {0};
  for (int i = 0; i < 20 * MOTION_PROOF_TICKS; ++i) {
    motion_proof_step(&proof, &limits, &azimuth, 0.0f, i % MOTION_PROOF_TICKS == 100, DT_S);
    TEST_ASSERT_FALSE(proof.unanswered);
  }
}

static void test_an_axis_that_would_need_too_much_torque_is_not_tested(void) {
  const float needed_nm = 2.0f * limits.answer_rad_s * motion_proof_impedance(&azimuth, DT_S);
  for (int enough = 0; enough <= 1; ++enough) {
    const motion_proof_limits weak = {.answer_rad_s = 3e-5f, .most_nm = (enough == 1 ? 1.01f : 0.99f) * needed_nm};
    motion_proof proof = {0};
    float largest_nm = 0.0f;
    for (int i = 0; i < 2 * MOTION_PROOF_TICKS; ++i) {
      motion_proof_step(&proof, &weak, &azimuth, 0.0f, false, DT_S);
      largest_nm = fmaxf(largest_nm, proof.torque_nm);
    }
    TEST_ASSERT_EQUAL(enough == 1, proof.unanswered);
    CHECK_NEAR("torque, Nm", enough == 1 ? needed_nm : 0.0f, largest_nm, 1e-6);
  }
}

static void test_the_torque_is_a_sine_that_turns_its_sign_from_window_to_window(void) {
  motion_proof proof = {0};
  const double amplitude_nm = 2.0 * (double)(limits.answer_rad_s * motion_proof_impedance(&azimuth, DT_S));
  for (int i = 0; i < 4 * MOTION_PROOF_TICKS; ++i) {
    const double sign = i / MOTION_PROOF_TICKS % 2 == 0 ? 1.0 : -1.0;
    CHECK_NEAR("torque, Nm", sign * amplitude_nm * sin(W_RAD_S * i * 0.001), proof.torque_nm, 1e-6);
    motion_proof_step(&proof, &limits, &azimuth, 0.0f, true, DT_S);
  }
}

/* The axis and its loop at the frequency of the test, in complex numbers: inertia and bristles; PI, and an observer of
 * the first order, d = Q (u - (Jo s + Bo) y), whose estimate is added to the torque; a filter with this phase in the
 * feedback; the position loop. */
static double answer_rad_s(const motion_proof_axis *axis, double phase_rad) {
  const double complex s = W_RAD_S * imaginary;
  const double complex filter = (double)axis->filter_gain * cexp(phase_rad * imaginary);
  const double complex of_observer = (double)axis->observer_inertia_kg_m2 * s + (double)axis->observer_viscous_nm_s_rad;
  const double inertia = (double)axis->inertia_kg_m2, observer = (double)axis->observer_rad_s;
  const double complex plant =
      1.0 / (inertia * s + (double)axis->damping_nm_s_rad + (double)axis->stiffness_nm_rad / s);
  const double complex q = observer / (s + observer);
  const double complex pi = (double)axis->proportional_gain + (double)axis->integral_gain / s;
  const double complex position = (double)axis->position_per_s / s;
  const double complex loop = (pi * (filter + position) + q * of_observer * filter) / (1.0 - q);
  return cabs(plant / (1.0 + plant * loop));
}

static void test_the_impedance_is_more_than_that_of_any_axis_and_loop(void) {
  double largest_ratio = 0.0;
  for (int i = 0; i < 5 * 5 * 5 * 5; ++i) {
    const double stiffness = pow(10.0, i % 5), gains = pow(10.0, i / 5 % 5), observer = pow(6.0, i / 25 % 5);
    const double inertia = pow(10.0, i / 125 - 2);
    const motion_proof_axis axis = {.inertia_kg_m2 = (float)inertia,
                                    .stiffness_nm_rad = (float)(stiffness * 10.0 * inertia),
                                    .damping_nm_s_rad = (float)(0.1 * stiffness * inertia),
                                    .proportional_gain = (float)(gains * inertia),
                                    .integral_gain = (float)(40.0 * gains * inertia),
                                    .filter_gain = (float)(0.3 * (i % 7)),
                                    .position_per_s = (float)(50.0 * (i % 3)),
                                    .observer_rad_s = (float)(observer - 1.0),
                                    .observer_inertia_kg_m2 = (float)(inertia * (1.0 + i % 4)),
                                    .observer_viscous_nm_s_rad = (float)(inertia * 20.0 * (i % 2))};
    for (int phase = 0; phase < 12; ++phase) {
      const double ratio = 1.0 / ((double)motion_proof_impedance(&axis, DT_S) * answer_rad_s(&axis, 0.5236 * phase));
      CHECK_AT_MOST("least answer, as a share of the real one", 1.0001, ratio);
      largest_ratio = fmax(largest_ratio, ratio);
    }
  }
  CHECK_AT_LEAST("the same, at most: it is no idle bound", 0.5, largest_ratio);
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_two_windows_without_an_answer_are_a_fault);
  RUN_TEST(test_half_of_the_least_answer_decides);
  RUN_TEST(test_sensors_that_die_are_found_within_three_windows);
  RUN_TEST(test_no_vibration_at_the_frequency_of_the_test_hides_an_answer);
  RUN_TEST(test_an_axis_that_answers_well_is_swung_less);
  RUN_TEST(test_a_torque_that_could_not_act_proves_nothing);
  RUN_TEST(test_an_axis_that_would_need_too_much_torque_is_not_tested);
  RUN_TEST(test_the_torque_is_a_sine_that_turns_its_sign_from_window_to_window);
  RUN_TEST(test_the_impedance_is_more_than_that_of_any_axis_and_loop);
  return UNITY_END();
}
