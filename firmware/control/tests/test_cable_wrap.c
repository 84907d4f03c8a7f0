/* SPDX-License-Identifier: Apache-2.0 */
/* Which of two joint angles lasts longest, over a table and against a search in steps. */
#include "control/cable_wrap.h"

#include <math.h>
#include <stddef.h>

#include "support/check.h"

void setUp(void) {}
void tearDown(void) {}

#define DEG 0.01745329252f

static const joint_travel kTravel = {-280.0f * DEG, 280.0f * DEG};
static const joint_travel kUnlimited = {0.0f, 0.0f};

typedef struct {
  const char *what;
  float angle_deg;
  float rate_deg_s;
  int turns;
  float lasts_s; /* of the present angle */
} row;

static void test_the_angle_that_lasts_longest_is_chosen(void) {
  static const row rows[] = {
      {"in the middle there is only one", 0.0f, 10.0f, 0, 28.0f},
      {"within 80 degrees as well", -79.0f, -10.0f, 0, 20.1f},
      {"beyond, away from the near end", 100.0f, 10.0f, -1, 18.0f},
      {"beyond, towards the middle: 380 degrees are left", 100.0f, -10.0f, 0, 38.0f},
      {"on the other side", -100.0f, -10.0f, 1, 18.0f},
      {"on the other side, towards the middle", -100.0f, 10.0f, 0, 38.0f},
      {"just inside the near end", 279.0f, 0.5f, -1, 2.0f},
      {"just outside of it", 281.0f, 10.0f, -1, 0.0f},
      {"outside, and coming back: the other one is inside", 281.0f, -10.0f, -1, 0.0f},
      {"at rest all last for ever", 279.0f, 0.0f, 0, INFINITY},
      {"outside, at rest", -281.0f, 0.0f, 1, 0.0f},
      {"a revolution away there is nothing, either", 700.0f, 10.0f, 0, 0.0f},
  };
  for (size_t i = 0; i < sizeof rows / sizeof rows[0]; ++i) {
    const row *r = &rows[i];
    const float angle_rad = r->angle_deg * DEG;
    const float rate_rad_s = r->rate_deg_s * DEG;
    TEST_ASSERT_EQUAL_INT_MESSAGE(r->turns, cable_wrap_turns(&kTravel, angle_rad, rate_rad_s), r->what);
    const float lasts_s = cable_wrap_lasts_s(&kTravel, angle_rad, rate_rad_s);
    TEST_ASSERT_TRUE_MESSAGE(isinf(r->lasts_s) ? isinf(lasts_s) : fabsf(lasts_s - r->lasts_s) < 1e-3f, r->what);
  }
}

/* In steps of 10 ms, for all whole degrees and rates in both directions. */
static void test_no_other_angle_within_the_travel_lasts_longer(void) {
  for (int angle_deg = -300; angle_deg <= 300; ++angle_deg) {
    for (int rate_deg_s = -30; rate_deg_s <= 30; rate_deg_s += 20) {
      int steps[3];
      for (int turns = -1; turns <= 1; ++turns) {
        double deg = (double)angle_deg + 360.0 * turns;
        int *count = &steps[turns + 1];
        for (*count = 0; fabs(deg) <= 280.0; ++*count) {
          deg += 0.01 * rate_deg_s;
        }
      }
      const int chosen = cable_wrap_turns(&kTravel, (float)angle_deg * DEG, (float)rate_deg_s * DEG);
      for (int turns = -1; turns <= 1; ++turns) {
        TEST_ASSERT_TRUE(steps[chosen + 1] >= steps[turns + 1] - 2);
      }
    }
  }
}

static void test_without_a_limit_nothing_is_better_than_to_stay(void) {
  TEST_ASSERT_EQUAL_INT(0, cable_wrap_turns(&kUnlimited, 100.0f, 1.0f));
  TEST_ASSERT_TRUE(isinf(cable_wrap_lasts_s(&kUnlimited, 100.0f, 1.0f)));
  CHECK_SAME("rad", 100.0f, joint_travel_clamp(&kUnlimited, 100.0f));
  CHECK_SAME("rad", 280.0f * DEG, joint_travel_clamp(&kTravel, 100.0f));
}

int main(void) {
  UNITY_BEGIN();
  RUN_TEST(test_the_angle_that_lasts_longest_is_chosen);
  RUN_TEST(test_no_other_angle_within_the_travel_lasts_longer);
  RUN_TEST(test_without_a_limit_nothing_is_better_than_to_stay);
  return UNITY_END();
}
