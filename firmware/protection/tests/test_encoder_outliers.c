/* SPDX-License-Identifier: Apache-2.0 */
/* Encoder readings that are wrong in some ticks only. */
#include "protection/encoder_outliers.h"

#include "support/check.h"
#include "unity.h"

#define LIMIT_RAD 1.5e-5f

void setUp(void) {}
void tearDown(void) {}

/* Ticks until the fault at an outlier in every `period`-th tick; 0: not within 10,000. */
static int ticks_until(int period, float change_rad) {
  encoder_outliers outliers = {0};
  for (int i = 1; i <= 10000; ++i) {
    const bool wrong = i % period == 0;
    const encoder_verdict verdict = encoder_outliers_step(&outliers, LIMIT_RAD, wrong ? change_rad : 0.0f, 0.0f);
    if (verdict == ENCODER_ERRATIC) {
      return i;
    }
    TEST_ASSERT_EQUAL(wrong ? ENCODER_OUTLIER : ENCODER_FITS, verdict);
  }
  return 0;
}

static void test_four_outliers_in_a_row_are_a_fault_and_three_are_none(void) {
  TEST_ASSERT_EQUAL(4, ticks_until(1, 1e-4f));
  TEST_ASSERT_EQUAL(4, ticks_until(1, -1e-4f));
  encoder_outliers outliers = {0};
  for (int i = 0; i < 1000; ++i) {
    const bool wrong = i % 100 < 3;
    TEST_ASSERT_EQUAL(wrong ? ENCODER_OUTLIER : ENCODER_FITS,
                      encoder_outliers_step(&outliers, LIMIT_RAD, wrong ? 1e-4f : 0.0f, 0.0f));
  }
}

static void test_one_outlier_in_five_ticks_is_a_fault_soon_and_one_in_thirty_never(void) {
  TEST_ASSERT_EQUAL(25, ticks_until(5, 1e-4f));
  TEST_ASSERT_EQUAL(0, ticks_until(30, 1e-4f));
}

static void test_a_change_within_the_limit_or_shown_by_the_gyro_is_no_outlier(void) {
  static const struct {
    float encoder_rad;
    float gyro_rad;
    encoder_verdict verdict;
  } cases[] = {
      {0.9f * LIMIT_RAD, 0.0f, ENCODER_FITS},
      {1e-3f, 1e-3f, ENCODER_FITS},
      {1.4e-3f, 1e-3f, ENCODER_FITS}, /* the gyro is slower */
      {0.0f, 1e-2f, ENCODER_FITS},    /* it is the gyro that jumps */
      {1.6e-3f, 1e-3f, ENCODER_OUTLIER},
      {1.5e-3f + 0.9f * LIMIT_RAD, 1e-3f, ENCODER_FITS}, /* half of its change, and the limit */
      {1.5e-3f + 1.1f * LIMIT_RAD, 1e-3f, ENCODER_OUTLIER},
      {-1.5e-3f - 0.9f * LIMIT_RAD, -1e-3f, ENCODER_FITS},
      {-1.5e-3f - 1.1f * LIMIT_RAD, -1e-3f, ENCODER_OUTLIER},
      {-1.1f * LIMIT_RAD, 0.0f, ENCODER_OUTLIER},
  };
  for (unsigned i = 0; i < sizeof cases / sizeof cases[0]; ++i) {
    encoder_outliers outliers = {0};
    TEST_ASSERT_EQUAL(cases[i].verdict,
                      encoder_outliers_step(&outliers, LIMIT_RAD, cases[i].encoder_rad, cases[i].gyro_rad));
  }
}

static void test_a_fault_lasts_until_a_tick_without_an_outlier(void) {
  encoder_outliers outliers = {0};
  for (int i = 0; i < 1000; ++i) {
    (void)encoder_outliers_step(&outliers, LIMIT_RAD, 1e-4f, 0.0f);
  }
  TEST_ASSERT_EQUAL(ENCODER_OUTLIERS_FAULT, outliers.score);
  TEST_ASSERT_EQUAL(ENCODER_FITS, encoder_outliers_step(&outliers, LIMIT_RAD, 0.0f, 0.0f));
  TEST_ASSERT_EQUAL(ENCODER_ERRATIC, encoder_outliers_step(&outliers, LIMIT_RAD, 1e-4f, 0.0f));
  for (int i = 0; i < 1000; ++i) {
    (void)encoder_outliers_step(&outliers, LIMIT_RAD, 0.0f, 0.0f);
  }
  TEST_ASSERT_EQUAL(0, outliers.score);
}

static void test_a_limit_of_0_finds_nothing(void) {
  encoder_outliers outliers = {0};
  for (int i = 0; i < 100; ++i) {
    TEST_ASSERT_EQUAL(ENCODER_FITS, encoder_outliers_step(&outliers, 0.0f, 1.0f, 0.0f));
  }
  TEST_ASSERT_EQUAL(0, outliers.score);
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_four_outliers_in_a_row_are_a_fault_and_three_are_none);
  RUN_TEST(test_one_outlier_in_five_ticks_is_a_fault_soon_and_one_in_thirty_never);
  RUN_TEST(test_a_change_within_the_limit_or_shown_by_the_gyro_is_no_outlier);
  RUN_TEST(test_a_fault_lasts_until_a_tick_without_an_outlier);
  RUN_TEST(test_a_limit_of_0_finds_nothing);
  return UNITY_END();
}
