/* SPDX-License-Identifier: Apache-2.0 */
/* Conversions between the integers of CiA 402 and the core: round trips, roundings, ends. Truth is in long double. */
#include "drive/drive_units.h"

#include <float.h>
#include <math.h>

#include "support/check.h"
#include "support/random.h"

void setUp(void) {}
void tearDown(void) {}

static const long double two_pi = 6.283185307179586476925286766559L;

static double counts_of(drive_angle angle) { return (double)((long double)angle * two_pi * 1e7L / 4294967296.0L); }

static void test_positions_are_the_nearest_count_to_the_angle(void) {
  random_source random = {.state = 1};
  double worst = 0.0;
  for (int i = 0; i < random_cases(1000000); ++i) {
    const drive_angle angle = (drive_angle)random_uniform(&random, -1.46e11, 1.46e11);
    worst = fmax(worst, fabs((double)drive_position_from_angle(angle) - counts_of(angle)));
  }
  LOG_VALUE("largest rounding, counts", worst);
  CHECK_AT_MOST("rounding in counts", 0.5 + 1e-7, worst);
}

static void test_every_position_comes_back_through_an_angle(void) {
  const int64_t stride = INT64_C(4300000000) / random_cases(4312901); /* 997 on the host, and all around the edges */
  for (int64_t position = INT32_MIN; position <= INT32_MAX; position += stride) {
    const int32_t there = (int32_t)position;
    if (drive_position_from_angle(drive_angle_from_position(there)) != there) {
      TEST_ASSERT_EQUAL_INT32(there, drive_position_from_angle(drive_angle_from_position(there)));
    }
  }
  const int64_t edges[] = {INT32_MIN, -62831853, -31415927, -65536, 0, 65536, 31415927, 62831853, INT32_MAX};
  for (unsigned i = 0; i < sizeof edges / sizeof edges[0]; ++i) {
    for (int64_t near = edges[i] - 2000; near <= edges[i] + 2000; ++near) {
      if (near >= INT32_MIN && near <= INT32_MAX) {
        TEST_ASSERT_EQUAL_INT32((int32_t)near, drive_position_from_angle(drive_angle_from_position((int32_t)near)));
      }
    }
  }
}

static void test_angles_of_positions_are_within_half_a_unit(void) {
  random_source random = {.state = 2};
  for (int i = 0; i < random_cases(1000000); ++i) {
    const int32_t position = (int32_t)random_bits(&random);
    const double exact = (double)((long double)position * 4294967296.0L / (two_pi * 1e7L));
    CHECK_NEAR("angle in 2^-32 turn", exact, (double)drive_angle_from_position(position), 0.5 + 1e-4);
  }
}

static void test_a_turn_is_two_pi_in_counts(void) {
  TEST_ASSERT_EQUAL_INT32(62831853, drive_position_from_angle(INT64_C(1) << 32));
  TEST_ASSERT_EQUAL_INT32(-31415927, drive_position_from_angle(-(INT64_C(1) << 31)));
  TEST_ASSERT_EQUAL_INT32(2136283004, drive_position_from_angle(INT64_C(34) << 32)); /* 34 turns: the last whole one */
}

static void test_positions_saturate_beyond_34_turns(void) {
  TEST_ASSERT_EQUAL_INT32(INT32_MAX, drive_position_from_angle(INT64_C(35) << 32));
  TEST_ASSERT_EQUAL_INT32(INT32_MIN, drive_position_from_angle(-(INT64_C(35) << 32)));
  TEST_ASSERT_EQUAL_INT32(INT32_MAX, drive_position_from_angle(INT64_C(1) << 38));
  TEST_ASSERT_EQUAL_INT32(INT32_MIN, drive_position_from_angle(-(INT64_C(1) << 38)));
  TEST_ASSERT_EQUAL_INT32(INT32_MAX, drive_position_from_angle(INT64_MAX));
  TEST_ASSERT_EQUAL_INT32(INT32_MIN, drive_position_from_angle(INT64_MIN));
}

static void test_positions_of_many_turns_become_the_nearest_angle(void) {
  random_source random = {.state = 6};
  for (int i = 0; i < random_cases(1000000); ++i) {
    const int64_t magnitude = (int64_t)random_decades(&random, 1.0, 7e16);
    const int64_t position = i % 2 == 0 ? magnitude : -magnitude;
    const long double exact = (long double)position * 4294967296.0L / (two_pi * 1e7L);
    const double error = (double)((long double)drive_angle_from_position(position) - exact);
    const double reference = (double)LDBL_EPSILON * fabs((double)exact); /* long double is double on a Cortex-M4F */
    CHECK_NEAR("error in 2^-32 turn", 0.0, error, 0.5 + 1e-4 + reference);
  }
}

static void test_an_angle_wraps_by_64_turns_to_within_32(void) {
  const drive_angle turn = INT64_C(1) << 32;
  random_source random = {.state = 7};
  for (int i = 0; i < random_cases(100000); ++i) {
    const drive_angle within = (drive_angle)random_uniform(&random, -1.37e11, 1.37e11);
    const int ranges = (int)(random_bits(&random) % 2001) - 1000;
    TEST_ASSERT_EQUAL_INT64(within, drive_angle_wrap(within + ranges * 64 * turn));
  }
  TEST_ASSERT_EQUAL_INT64(-32 * turn, drive_angle_wrap(32 * turn));
  TEST_ASSERT_EQUAL_INT64(-32 * turn, drive_angle_wrap(-32 * turn));
  TEST_ASSERT_EQUAL_INT64(32 * turn - 1, drive_angle_wrap(-32 * turn - 1));
  TEST_ASSERT_EQUAL_INT32(DRIVE_RANGE_END, drive_position_from_angle(32 * turn - 1));
  TEST_ASSERT_EQUAL_INT32(-DRIVE_RANGE_END, drive_position_from_angle(-32 * turn));
}

static void test_an_encoder_is_unwrapped_over_many_turns_in_both_directions(void) {
  random_source random = {.state = 3};
  drive_angle truth = 12345;
  drive_angle angle = drive_angle_unwrap(0, (angle_turn32)truth);
  for (int i = 0; i < random_cases(1000000); ++i) {
    truth += (drive_angle)random_uniform(&random, -2.0e9, i < random_cases(500000) ? 2.1e9 : 1.9e9);
    angle = drive_angle_unwrap(angle, (angle_turn32)(uint64_t)truth);
    TEST_ASSERT_TRUE(truth == angle);
  }
  LOG_VALUE("turns at the end", (double)angle / 4294967296.0);
}

static void test_the_first_angle_is_within_half_a_turn_of_zero(void) {
  TEST_ASSERT_EQUAL_INT32(-31415927, drive_position_from_angle(drive_angle_unwrap(0, 0x80000000u)));
  TEST_ASSERT_EQUAL_INT32(31415927, drive_position_from_angle(drive_angle_unwrap(0, 0x7FFFFFFFu)));
}

static void test_velocities_are_the_exact_product_rounded_once(void) {
  random_source random = {.state = 4};
  for (int i = 0; i < random_cases(1000000); ++i) {
    const float magnitude = (float)random_decades(&random, 1e-8, 2100.0);
    const float rate_rad_s = i % 2 == 0 ? magnitude : -magnitude;
    const double exact = round((double)rate_rad_s * 1e6); /* 24 bits times 20 fit a double */
    if ((double)drive_velocity_from_rate(rate_rad_s) != exact) {
      CHECK_SAME("velocity", exact, drive_velocity_from_rate(rate_rad_s));
    }
  }
}

static void test_velocities_below_16_rad_s_come_back_exactly_and_faster_ones_within_60_ppb(void) {
  for (int32_t velocity = -16000000; velocity <= 16000000; velocity += 32000000 / random_cases(4571428)) {
    if (drive_velocity_from_rate(drive_rate_from_velocity(velocity)) != velocity) {
      TEST_ASSERT_EQUAL_INT32(velocity, drive_velocity_from_rate(drive_rate_from_velocity(velocity)));
    }
  }
  random_source random = {.state = 5};
  for (int i = 0; i < random_cases(1000000); ++i) {
    const int32_t velocity = (int32_t)random_bits(&random);
    CHECK_NEAR("velocity", velocity, drive_velocity_from_rate(drive_rate_from_velocity(velocity)),
               1.2e-7 * fabs((double)velocity) + 0.5);
  }
}

static void test_velocities_saturate_and_nan_is_zero(void) {
  TEST_ASSERT_EQUAL_INT32(INT32_MAX, drive_velocity_from_rate(2147.5f));
  TEST_ASSERT_EQUAL_INT32(INT32_MIN, drive_velocity_from_rate(-2147.5f));
  TEST_ASSERT_EQUAL_INT32(INT32_MAX, drive_velocity_from_rate(1e7f));
  TEST_ASSERT_EQUAL_INT32(INT32_MIN, drive_velocity_from_rate(-1e7f));
  TEST_ASSERT_EQUAL_INT32(INT32_MAX, drive_velocity_from_rate(3e38f));
  TEST_ASSERT_EQUAL_INT32(INT32_MIN, drive_velocity_from_rate(-3e38f));
  TEST_ASSERT_EQUAL_INT32(INT32_MAX, drive_velocity_from_rate(INFINITY));
  TEST_ASSERT_EQUAL_INT32(INT32_MIN, drive_velocity_from_rate(-INFINITY));
  TEST_ASSERT_EQUAL_INT32(0, drive_velocity_from_rate(NAN));
  TEST_ASSERT_EQUAL_INT32(0, drive_velocity_from_rate(0.0f));
  TEST_ASSERT_EQUAL_INT32(0, drive_velocity_from_rate(1e-45f));
}

static void test_every_permille_comes_back_through_a_torque(void) {
  const uint32_t rated_mnm[] = {1, 7, 40000, 1000000, UINT32_MAX};
  for (unsigned i = 0; i < 5; ++i) {
    for (int32_t permille = INT16_MIN; permille <= INT16_MAX; ++permille) {
      const float torque_nm = drive_torque_from_permille(permille, rated_mnm[i]);
      TEST_ASSERT_EQUAL_INT16((int16_t)permille, drive_permille_from_torque(torque_nm, rated_mnm[i]));
    }
  }
  CHECK_RELATIVE("50 % of 40 Nm", 20.0, drive_torque_from_permille(500, 40000), 1e-7);
}

static void test_torques_saturate_and_are_zero_without_a_rated_torque(void) {
  TEST_ASSERT_EQUAL_INT16(INT16_MAX, drive_permille_from_torque(1e9f, 1000));
  TEST_ASSERT_EQUAL_INT16(INT16_MIN, drive_permille_from_torque(-INFINITY, 1000));
  TEST_ASSERT_EQUAL_INT16(0, drive_permille_from_torque(NAN, 1000));
  TEST_ASSERT_EQUAL_INT16(0, drive_permille_from_torque(5.0f, 0));
  CHECK_SAME("torque", 0.0, drive_torque_from_permille(1000, 0));
}

static void test_sums_saturate(void) {
  TEST_ASSERT_EQUAL_INT32(INT32_MAX, drive_add(INT32_MAX, 1));
  TEST_ASSERT_EQUAL_INT32(INT32_MIN, drive_add(INT32_MIN, -1));
  TEST_ASSERT_EQUAL_INT32(-1, drive_add(INT32_MAX, INT32_MIN));
}

static void test_a_limit_of_0_counts_as_1(void) {
  CHECK_SAME("0", drive_limit_from_counts(1), drive_limit_from_counts(0));
  CHECK_RELATIVE("2 rad/s", 2.0, drive_limit_from_counts(2000000), 1e-7);
  CHECK_RELATIVE("largest", 4294.967295, drive_limit_from_counts(UINT32_MAX), 1e-7);
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_positions_are_the_nearest_count_to_the_angle);
  RUN_TEST(test_every_position_comes_back_through_an_angle);
  RUN_TEST(test_angles_of_positions_are_within_half_a_unit);
  RUN_TEST(test_a_turn_is_two_pi_in_counts);
  RUN_TEST(test_positions_saturate_beyond_34_turns);
  RUN_TEST(test_positions_of_many_turns_become_the_nearest_angle);
  RUN_TEST(test_an_angle_wraps_by_64_turns_to_within_32);
  RUN_TEST(test_an_encoder_is_unwrapped_over_many_turns_in_both_directions);
  RUN_TEST(test_the_first_angle_is_within_half_a_turn_of_zero);
  RUN_TEST(test_velocities_are_the_exact_product_rounded_once);
  RUN_TEST(test_velocities_below_16_rad_s_come_back_exactly_and_faster_ones_within_60_ppb);
  RUN_TEST(test_velocities_saturate_and_nan_is_zero);
  RUN_TEST(test_every_permille_comes_back_through_a_torque);
  RUN_TEST(test_torques_saturate_and_are_zero_without_a_rated_torque);
  RUN_TEST(test_sums_saturate);
  RUN_TEST(test_a_limit_of_0_counts_as_1);
  return UNITY_END();
}
