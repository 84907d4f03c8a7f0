/* SPDX-License-Identifier: Apache-2.0 */
/* Sine and cosine of a binary angle, against the C library in double. */
#include "base/rotation.h"

#include "support/check.h"
#include "support/random.h"

void setUp(void) {}
void tearDown(void) {}

static const double kRadPerTurn32 = 6.283185307179586 / 4294967296.0;

static double error_at(angle_turn32 angle) {
  const rotation found = rotation_of(angle);
  const double angle_rad = (double)angle * kRadPerTurn32;
  CHECK_SAME("the cosine alone", found.cosine, rotation_cosine(angle));
  return fmax(fabs((double)found.sine - sin(angle_rad)), fabs((double)found.cosine - cos(angle_rad)));
}

static void test_sine_and_cosine_are_within_1_2e_7_over_the_whole_turn(void) {
  double worst = 0.0;
  const uint32_t stride = UINT32_MAX / (uint32_t)random_cases(2000000);
  for (uint64_t angle = 0; angle <= UINT32_MAX; angle += stride) {
    worst = fmax(worst, error_at((angle_turn32)angle));
  }
  LOG_VALUE("largest error of sine and cosine", worst);
  CHECK_AT_MOST("error of sine and cosine", 1.2e-7, worst);
}

static void test_both_sides_of_each_eighth_of_the_turn_agree(void) {
  for (uint32_t eighth = 0; eighth < 8; ++eighth) {
    const angle_turn32 edge = eighth << 29;
    CHECK_AT_MOST("error below the edge", 1.2e-7, error_at(edge - 1u));
    CHECK_AT_MOST("error at the edge", 1.2e-7, error_at(edge));
  }
}

static void test_whole_quarters_are_exact(void) {
  static const rotation quarters[] = {{0.0f, 1.0f}, {1.0f, 0.0f}, {0.0f, -1.0f}, {-1.0f, 0.0f}};
  for (uint32_t quarter = 0; quarter < 4; ++quarter) {
    const rotation found = rotation_of(quarter << 30);
    CHECK_SAME("sine", quarters[quarter].sine, found.sine);
    CHECK_SAME("cosine", quarters[quarter].cosine, found.cosine);
  }
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_sine_and_cosine_are_within_1_2e_7_over_the_whole_turn);
  RUN_TEST(test_both_sides_of_each_eighth_of_the_turn_agree);
  RUN_TEST(test_whole_quarters_are_exact);
  return UNITY_END();
}
