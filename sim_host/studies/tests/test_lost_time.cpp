// SPDX-License-Identifier: Apache-2.0
// The time-optimal plan of a pass that is faster than the azimuth.
#include "studies/shared/lost_time.hpp"

#include <cmath>

#include "support/bench.hpp"
#include "support/check.h"

extern "C" void setUp(void) {}
extern "C" void tearDown(void) {}

namespace {

using namespace bench;

constexpr double kLimit_rad_s = 60.0 * kRadPerDeg;

PassConfig pass_at(double elevation_deg) { return {20.0, 500.0, elevation_deg * kRadPerDeg, 25.0, 0.0, 4.0}; }

void test_the_time_optimal_plan_is_none_below_the_limit_and_a_half_turn_at_the_zenith() {
  CHECK_SAME("26 deg/s", 0.0, optimal_lost_s(pass_at(85.0), {kLimit_rad_s}));
  CHECK_NEAR("zenith, s", 3.0, optimal_lost_s(pass_at(90.0), {kLimit_rad_s}), 2e-3);
  CHECK_NEAR("zenith, 1 rad/s2, s", 3.0 + kLimit_rad_s, optimal_lost_s(pass_at(90.0), {kLimit_rad_s, 1.0}), 2e-3);
  // Between them it begins where the target reaches the limit, and the azimuth grows by what the limit allows.
  const double lost_s = optimal_lost_s(pass_at(88.0), {kLimit_rad_s});
  const double tau_s = 500.0 / std::tan(88.0 * kRadPerDeg) / 20.0;
  const double begin_s = -tau_s * std::sqrt(1.0 / (tau_s * kLimit_rad_s) - 1.0);
  CHECK_NEAR("azimuth, rad", kLimit_rad_s * lost_s, std::atan((begin_s + lost_s) / tau_s) - std::atan(begin_s / tau_s),
             2e-3);
  CHECK_AT_LEAST("s", 0.5, lost_s);
  CHECK_AT_LEAST("with 1 rad/s2, s", lost_s, optimal_lost_s(pass_at(88.0), {kLimit_rad_s, 1.0}));
}

// The azimuth of the target on both sides of a turn at the limit, from any beginning.
void test_no_plan_that_begins_earlier_is_shorter() {
  const double tau_s = 500.0 / std::tan(88.5 * kRadPerDeg) / 20.0;
  const double lost_s = optimal_lost_s(pass_at(88.5), {kLimit_rad_s});
  const double too_fast_from_s = -tau_s * std::sqrt(1.0 / (tau_s * kLimit_rad_s) - 1.0);
  for (int i = 0; - 3.0 + 0.01 * i < too_fast_from_s; ++i) {
    const double begin_s = -3.0 + 0.01 * i;
    double end_s = 0.0;
    while (std::atan(end_s / tau_s) - std::atan(begin_s / tau_s) > kLimit_rad_s * (end_s - begin_s) ||
           1.0 / (tau_s * (1.0 + end_s * end_s / tau_s / tau_s)) > kLimit_rad_s) {
      end_s += 1e-3;
    }
    CHECK_AT_LEAST("s", lost_s - 5e-3, end_s - begin_s);
  }
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_the_time_optimal_plan_is_none_below_the_limit_and_a_half_turn_at_the_zenith);
  RUN_TEST(test_no_plan_that_begins_earlier_is_shorter);
  return UNITY_END();
}
