// SPDX-License-Identifier: Apache-2.0
// A target that evades: always the same acceleration, in directions that change, and never far from its course.
#include "machine/target/evasion.hpp"

#include <algorithm>
#include <cmath>

#include "support/check.h"

extern "C" void setUp(void) {}
extern "C" void tearDown(void) {}

namespace {

using namespace trackservo::sim;

constexpr double kAcceleration_m_s2 = 5.0;
constexpr double kStep_s = 1e-4;

void test_velocity_and_acceleration_are_the_slopes_of_the_path() {
  const Evasion evasion(kAcceleration_m_s2, 1);
  for (double t = 0.05; t < 60.0; t += 0.317) {
    const Evaded before = evasion.at(t - kStep_s);
    const Evaded after = evasion.at(t + kStep_s);
    CHECK_NEAR("m/s", 0.0,
               ((after.position_m - before.position_m) / (2.0 * kStep_s) - evasion.at(t).velocity_m_s).norm(), 1e-3);
    CHECK_NEAR("m/s2", kAcceleration_m_s2, evasion.at(t).acceleration_m_s2.norm(), 1e-12);
  }
}

void test_the_direction_changes_and_the_target_stays_near_its_course() {
  const Evasion evasion(kAcceleration_m_s2, 1);
  int changes = 0;
  double farthest_m = 0.0;
  for (double t = 0.0; t < 60.0; t += 0.01) {
    const Evaded now = evasion.at(t);
    changes += (now.acceleration_m_s2 - evasion.at(t + 0.01).acceleration_m_s2).norm() > 1e-9 ? 1 : 0;
    farthest_m = std::max(farthest_m, now.position_m.norm());
  }
  CHECK_AT_LEAST("changes in a minute", 30, changes);
  CHECK_AT_LEAST("m", 5.0, farthest_m);
  CHECK_AT_MOST("m", kAcceleration_m_s2 * 1.5 * 1.5, farthest_m);
}

void test_seeds_differ_and_a_seed_repeats() {
  const Evaded first = Evasion(kAcceleration_m_s2, 1).at(10.0);
  CHECK_SAME("m", first.position_m.x(), Evasion(kAcceleration_m_s2, 1).at(10.0).position_m.x());
  TEST_ASSERT_TRUE((first.position_m - Evasion(kAcceleration_m_s2, 2).at(10.0).position_m).norm() > 1e-3);
}

void test_without_acceleration_and_before_the_start_it_stays_on_course() {
  TEST_ASSERT_TRUE(Evasion(0.0, 1).at(10.0).position_m.isZero());
  TEST_ASSERT_TRUE(Evasion(kAcceleration_m_s2, 1).at(-1.0).acceleration_m_s2.isZero());
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_velocity_and_acceleration_are_the_slopes_of_the_path);
  RUN_TEST(test_the_direction_changes_and_the_target_stays_near_its_course);
  RUN_TEST(test_seeds_differ_and_a_seed_repeats);
  RUN_TEST(test_without_acceleration_and_before_the_start_it_stays_on_course);
  return UNITY_END();
}
