/* SPDX-License-Identifier: Apache-2.0 */
/* Scalar arithmetic and the wrap of the joint angle, against the C library in double. */
#include "base/scalar.h"

#include <float.h>
#include <string.h>

#include "base/angle.h"
#include "support/check.h"
#include "support/random.h"

void setUp(void) {}
void tearDown(void) {}

/* In units of the last place of the exact value. */
static double ulps(double exact, float computed) {
  int exponent;
  (void)frexp(exact, &exponent);
  return fabs((double)computed - exact) / ldexp(1.0, exponent - FLT_MANT_DIG);
}

/* Every exponent of x, and as many of its fractions as time allows. */
static void test_exp_is_within_1_25_ulp_over_the_whole_range(void) {
  double worst = 0.0;
  const float end = 87.0f;
  uint32_t last;
  memcpy(&last, &end, sizeof last);
  const uint32_t stride = last / (uint32_t)random_cases(2000000);
  for (uint32_t bits = 0; bits < last; bits += stride) {
    float x;
    memcpy(&x, &bits, sizeof x);
    worst = fmax(worst, ulps(exp(-(double)x), scalar_exp_minus(x)));
  }
  for (int i = 0; i < random_cases(870000); ++i) {
    const float x = (float)i * (87.0f / (float)random_cases(870000));
    worst = fmax(worst, ulps(exp(-(double)x), scalar_exp_minus(x)));
  }
  LOG_VALUE("largest error of exp, ulp", worst);
  CHECK_AT_MOST("error of exp, ulp", 1.25, worst);
}

static void test_exp_is_exactly_one_at_zero_and_exactly_zero_beyond_87(void) {
  CHECK_SAME("exp(0)", 1.0, scalar_exp_minus(0.0f));
  CHECK_SAME("exp(-87)", 0.0, scalar_exp_minus(87.0f));
  CHECK_SAME("exp(-1e30)", 0.0, scalar_exp_minus(1e30f));
  const float below = nextafterf(87.0f, 0.0f);
  CHECK_AT_MOST("exp just below 87, ulp", 1.25, ulps(exp(-(double)below), scalar_exp_minus(below)));
}

static void test_sin_and_cos_are_within_4e_7_from_0_to_pi(void) {
  double worst = 0.0;
  const int steps = random_cases(200000);
  for (int i = 0; i <= steps; ++i) {
    const float angle_rad = scalar_min(SCALAR_PI * ((float)i / (float)steps), SCALAR_PI);
    worst = fmax(worst, fabs((double)scalar_sin(angle_rad) - sin((double)angle_rad)));
    worst = fmax(worst, fabs((double)scalar_cos(angle_rad) - cos((double)angle_rad)));
  }
  LOG_VALUE("largest absolute error of sin and cos", worst);
  CHECK_AT_MOST("error of sin and cos", 4e-7, worst);
}

static void test_atan2_is_within_3e_7_of_itself_in_every_direction_and_for_every_exponent(void) {
  double worst = 0.0;
  for (int i = 0; i < random_cases(400000); ++i) {
    const double angle_rad = 6.283185307179586 * (double)i / (double)random_cases(400000) - 3.141592653589793;
    const float x = (float)cos(angle_rad);
    const float y = (float)sin(angle_rad);
    const double exact = atan2((double)y, (double)x);
    worst = fmax(worst, fabs((double)scalar_atan2(y, x) - exact) / fmax(fabs(exact), 1e-30));
  }
  for (int exponent = -100; exponent < 100; ++exponent) {
    const float y = ldexpf(1.3f, exponent);
    worst = fmax(worst, fabs((double)scalar_atan2(y, 1.0f) / atan2((double)y, 1.0) - 1.0));
  }
  LOG_VALUE("largest relative error of atan2", worst);
  CHECK_AT_MOST("relative error of atan2", 3e-7, worst);
}

static void test_atan2_of_the_axes_and_of_nothing(void) {
  CHECK_SAME("nothing", 0.0, scalar_atan2(0.0f, 0.0f));
  CHECK_SAME("forward", 0.0, scalar_atan2(0.0f, 2.0f));
  CHECK_SAME("backward", SCALAR_PI, scalar_atan2(0.0f, -2.0f));
  CHECK_SAME("left", 0.5f * SCALAR_PI, scalar_atan2(2.0f, 0.0f));
  CHECK_SAME("right", -0.5f * SCALAR_PI, scalar_atan2(-2.0f, 0.0f));
  TEST_ASSERT_TRUE(isnan(scalar_atan2(NAN, 1.0f)) && isnan(scalar_atan2(1.0f, NAN)));
}

static void test_min_max_abs_and_clamp_pick_the_right_value(void) {
  CHECK_SAME("min", -2.0, scalar_min(-2.0f, 3.0f));
  CHECK_SAME("min", -2.0, scalar_min(3.0f, -2.0f));
  CHECK_SAME("max", 3.0, scalar_max(-2.0f, 3.0f));
  CHECK_SAME("max", 3.0, scalar_max(3.0f, -2.0f));
  CHECK_SAME("abs", 2.5, scalar_abs(-2.5f));
  CHECK_SAME("abs", 2.5, scalar_abs(2.5f));
  CHECK_SAME("clamp below", 1.0, scalar_clamp(-5.0f, 1.0f, 4.0f));
  CHECK_SAME("clamp above", 4.0, scalar_clamp(5.0f, 1.0f, 4.0f));
  CHECK_SAME("clamp inside", 2.0, scalar_clamp(2.0f, 1.0f, 4.0f));
  CHECK_SAME("clamp to one point", 3.0, scalar_clamp(2.0f, 3.0f, 3.0f));
  TEST_ASSERT_TRUE(isnan(scalar_clamp(NAN, -1.0f, 1.0f)));
  TEST_ASSERT_TRUE(scalar_within(-3.0f, 3.0f) && scalar_within(3.0f, 3.0f));
  TEST_ASSERT_FALSE(scalar_within(3.1f, 3.0f) || scalar_within(-3.1f, 3.0f));
  TEST_ASSERT_FALSE(scalar_within(NAN, 3.0f) || scalar_within(-INFINITY, 3.0f));
}

static control_status check_one(float value) {
  const scalar_range range = {value, -1.0f, 2.0f};
  return scalar_check_ranges(&range, 1);
}

static void test_round_is_roundf_for_every_exponent_and_at_halves(void) {
  const uint32_t stride = UINT32_MAX / (uint32_t)random_cases(2000000);
  for (uint64_t bits = 0; bits <= UINT32_MAX; bits += stride) {
    const uint32_t word = (uint32_t)bits;
    float x;
    memcpy(&x, &word, sizeof x);
    TEST_ASSERT_TRUE(scalar_round(x) == roundf(x) || isnan(x));
  }
  const float odd[] = {0.5f, -0.5f, 1.5f, -1.5f, 0.49999997f, -0.49999997f, 8388607.5f, -8388607.5f, 8388608.0f};
  for (unsigned i = 0; i < sizeof odd / sizeof odd[0]; ++i) {
    TEST_ASSERT_TRUE(scalar_round(odd[i]) == roundf(odd[i]));
  }
  TEST_ASSERT_TRUE(isnan(scalar_round(NAN)));
}

static void test_a_range_includes_its_ends_and_refuses_what_is_beyond(void) {
  CHECK_STATUS(CONTROL_OK, check_one(-1.0f));
  CHECK_STATUS(CONTROL_OK, check_one(2.0f));
  CHECK_STATUS(CONTROL_OUT_OF_RANGE, check_one(nextafterf(-1.0f, -2.0f)));
  CHECK_STATUS(CONTROL_OUT_OF_RANGE, check_one(nextafterf(2.0f, 3.0f)));
}

static void test_a_range_refuses_nan_and_both_infinities(void) {
  CHECK_STATUS(CONTROL_NOT_FINITE, check_one(NAN));
  CHECK_STATUS(CONTROL_NOT_FINITE, check_one(INFINITY));
  CHECK_STATUS(CONTROL_NOT_FINITE, check_one(-INFINITY));
}

static void test_the_first_error_of_several_ranges_is_answered(void) {
  const scalar_range ranges[] = {{0.0f, 0.0f, 1.0f}, {3.0f, 0.0f, 1.0f}, {NAN, 0.0f, 1.0f}};
  CHECK_STATUS(CONTROL_OUT_OF_RANGE, scalar_check_ranges(ranges, 3));
  CHECK_STATUS(CONTROL_NOT_FINITE, scalar_check_ranges(ranges + 2, 1));
  CHECK_STATUS(CONTROL_OK, scalar_check_ranges(ranges, 1));
  CHECK_STATUS(CONTROL_OK, scalar_check_ranges(ranges, 0));
}

static void test_angle_differences_keep_single_counts_across_zero(void) {
  const double count_rad = 6.283185307179586 / 4294967296.0;
  CHECK_RELATIVE("one count up through zero", count_rad, angle_difference_rad(0u, 0xFFFFFFFFu), 1e-6);
  CHECK_RELATIVE("one count down through zero", -count_rad, angle_difference_rad(0xFFFFFFFFu, 0u), 1e-6);
  CHECK_SAME("no turn", 0.0, angle_difference_rad(12345u, 12345u));
}

static void test_half_a_turn_is_minus_pi_and_less_is_positive(void) {
  CHECK_RELATIVE("half a turn", -3.14159265358979, angle_difference_rad(0x80000000u, 0u), 1e-6);
  CHECK_RELATIVE("a quarter", 1.570796326794897, angle_difference_rad(0x40000000u, 0u), 1e-6);
  CHECK_RELATIVE("three quarters", -1.570796326794897, angle_difference_rad(0xC0000000u, 0u), 1e-6);
}

static void test_a_turn_fraction_becomes_an_integer_beyond_32_bits_too(void) {
  const float wholes[] = {0.0f,          1.0f,           -1.0f, 2147483520.0f, -2147483520.0f,
                          2147483648.0f, -2147483648.0f, 1e12f, -1e12f};
  for (unsigned i = 0; i < sizeof wholes / sizeof wholes[0]; ++i) {
    TEST_ASSERT_EQUAL_INT64((int64_t)wholes[i], angle_integer(wholes[i]));
  }
}

static void test_angle_differences_take_the_shorter_path_between_any_two_angles(void) {
  random_source source = {2};
  const double count_rad = 6.283185307179586 / 4294967296.0;
  for (int i = 0; i < 10000; ++i) {
    const angle_turn32 to = (angle_turn32)(random_bits(&source) >> 32);
    const angle_turn32 from = (angle_turn32)(random_bits(&source) >> 32);
    const double expected_rad = remainder((double)to * count_rad - (double)from * count_rad, 6.283185307179586);
    CHECK_NEAR("shorter path", expected_rad, angle_difference_rad(to, from), 5e-7);
  }
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_exp_is_within_1_25_ulp_over_the_whole_range);
  RUN_TEST(test_exp_is_exactly_one_at_zero_and_exactly_zero_beyond_87);
  RUN_TEST(test_sin_and_cos_are_within_4e_7_from_0_to_pi);
  RUN_TEST(test_atan2_is_within_3e_7_of_itself_in_every_direction_and_for_every_exponent);
  RUN_TEST(test_atan2_of_the_axes_and_of_nothing);
  RUN_TEST(test_min_max_abs_and_clamp_pick_the_right_value);
  RUN_TEST(test_round_is_roundf_for_every_exponent_and_at_halves);
  RUN_TEST(test_a_range_includes_its_ends_and_refuses_what_is_beyond);
  RUN_TEST(test_a_range_refuses_nan_and_both_infinities);
  RUN_TEST(test_the_first_error_of_several_ranges_is_answered);
  RUN_TEST(test_angle_differences_keep_single_counts_across_zero);
  RUN_TEST(test_half_a_turn_is_minus_pi_and_less_is_positive);
  RUN_TEST(test_a_turn_fraction_becomes_an_integer_beyond_32_bits_too);
  RUN_TEST(test_angle_differences_take_the_shorter_path_between_any_two_angles);
  return UNITY_END();
}
