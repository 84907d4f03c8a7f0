// SPDX-License-Identifier: Apache-2.0
// The paper's own identification: its worked example, and its curve fit on known torques.
#include <cmath>
#include <vector>

#include "identification/paper_method.hpp"
#include "identification/stribeck_fit.hpp"
#include "support/check.h"

namespace identification = trackservo::identification;
using identification::DirectionFriction;
using identification::SteadyPoint;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

// Section II.C: slope 308.1, J = 23.5, zeta = 0.707 give sigma1 = 108.46 with the sigma2 that follows from it.
void test_worked_example_of_the_paper_gives_108_46() {
  const double damping =
      identification::paper_damping_nm_s_rad(23.5, 308.1, 11.876, identification::kPaperDampingRatio);
  CHECK_NEAR("sigma1", 108.46, damping, 0.005);
  CHECK_NEAR("the ratio back", std::sqrt(0.5), identification::presliding_damping_ratio(23.5, 308.1, damping, 11.876),
             1e-12);
}

std::vector<SteadyPoint> points_of(const DirectionFriction& truth, const std::vector<double>& speeds) {
  std::vector<SteadyPoint> points;
  for (const double speed : speeds) {
    points.push_back({speed, truth.steady_nm(speed), 1.0});
  }
  return points;
}

const std::vector<double> kSpeeds{0.5e-3, 1e-3, 2e-3, 4e-3, 8e-3, 16e-3, 32e-3, 64e-3};

void test_stribeck_curve_is_found_from_exact_torques() {
  const DirectionFriction truth{6.0, 9.0, 5.2e-3, 8.0};
  const auto found = identification::fit_stribeck(points_of(truth, kSpeeds));
  TEST_ASSERT_TRUE(found.has_value());
  CHECK_RELATIVE("Tc", truth.coulomb_nm, found->coulomb_nm, 1e-3);
  CHECK_RELATIVE("Ts", truth.breakaway_nm, found->breakaway_nm, 5e-3);
  CHECK_RELATIVE("vs", truth.stribeck_speed_rad_s, found->stribeck_speed_rad_s, 1e-2);
  CHECK_RELATIVE("sigma2", truth.viscous_nm_s_rad, found->viscous_nm_s_rad, 1e-2);
}

void test_friction_without_a_stribeck_effect_is_no_trouble() {
  const DirectionFriction truth{6.0, 6.0, 5e-3, 8.0};
  const auto found = identification::fit_stribeck(points_of(truth, kSpeeds));
  TEST_ASSERT_TRUE(found.has_value());
  CHECK_RELATIVE("Tc", 6.0, found->coulomb_nm, 1e-6);
  CHECK_RELATIVE("sigma2", 8.0, found->viscous_nm_s_rad, 1e-6);
}

void test_three_speeds_or_torques_that_push_are_refused() {
  const DirectionFriction truth{6.0, 9.0, 5.2e-3, 8.0};
  TEST_ASSERT_FALSE(identification::fit_stribeck(points_of(truth, {1e-3, 2e-3, 4e-3})).has_value());
  std::vector<SteadyPoint> pushing = points_of(truth, kSpeeds);
  for (SteadyPoint& point : pushing) {
    point.friction_nm = -point.friction_nm;
  }
  TEST_ASSERT_FALSE(identification::fit_stribeck(pushing).has_value());
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_worked_example_of_the_paper_gives_108_46);
  RUN_TEST(test_stribeck_curve_is_found_from_exact_torques);
  RUN_TEST(test_friction_without_a_stribeck_effect_is_no_trouble);
  RUN_TEST(test_three_speeds_or_torques_that_push_are_refused);
  return UNITY_END();
}
