// SPDX-License-Identifier: Apache-2.0
// Figures of merit on traces whose result can be computed by hand.
#include "judge/analysis/metrics.hpp"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>

#include "judge/analysis/statistics.hpp"
#include "support/check.h"

extern "C" void setUp(void) {}
extern "C" void tearDown(void) {}

namespace {

using namespace trackservo::sim;

constexpr double kStep_rad_s = 0.1;
constexpr Window kRun{0.0, 1.0};

// One second, a row per tick; `share` of the step as a function of time [s].
Trace run_with(const std::function<double(double)>& share, double step_rad_s = kStep_rad_s) {
  Trace trace;
  for (int tick = 0; tick < 1000; ++tick) {
    TraceRow row{};
    row.time_s = 1e-3 * tick;
    row.axis[0].reference_rad_s = step_rad_s;
    row.axis[0].rate_rad_s = step_rad_s * share(row.time_s);
    trace.push_back(row);
  }
  return trace;
}

// Unity makes isnan a macro.
bool is_no_value(double value) { return (std::isnan)(value); }

double start_ms(const std::function<double(double)>& share) {
  return 1e3 * time_to_90_percent_s(run_with(share), 0, kRun, kStep_rad_s);
}

void test_a_ramp_of_100_ms_is_at_90_percent_after_90_ms() {
  CHECK_NEAR("ms", 90.0, start_ms([](double t) { return std::min(1.0, t / 0.1); }), 1.0);
}

void test_a_touch_that_sags_again_does_not_count() {
  CHECK_NEAR("ms", 300.0, start_ms([](double t) { return t >= 0.003 && t < 0.006 ? 1.0
                                                         : t < 0.3               ? 0.85
                                                                                 : 0.95; }),
             1.0);
}

void test_a_single_row_below_90_percent_starts_the_wait_anew() {
  CHECK_NEAR("ms", 51.0, start_ms([](double t) { return t < 0.0105 || std::abs(t - 0.05) < 5e-4 ? 0.89 : 0.95; }), 0.5);
}

void test_a_gust_after_the_dwell_is_no_part_of_the_start() {
  CHECK_NEAR("ms", 20.0, start_ms([](double t) { return t < 0.0195 || (t > 0.125 && t < 0.2) ? 0.5 : 1.0; }), 0.5);
}

void test_a_gust_within_the_dwell_is_part_of_the_start() {
  CHECK_NEAR("ms", 200.0, start_ms([](double t) { return t < 0.0195 || (t > 0.115 && t < 0.1995) ? 0.5 : 1.0; }), 0.5);
}

void test_a_start_that_never_arrives_has_no_end() {
  constexpr double kNever_ms = std::numeric_limits<double>::infinity();
  TEST_ASSERT_TRUE(start_ms([](double) { return 0.89; }) == kNever_ms);
  TEST_ASSERT_TRUE_MESSAGE(start_ms([](double t) { return t < 0.95 ? 0.0 : 1.0; }) == kNever_ms, "too late to dwell");
}

void test_a_step_backwards_is_judged_as_one_forwards() {
  const auto share = [](double t) { return t < 0.0495 ? 0.0 : 1.25; };
  const Trace backwards = run_with(share, -kStep_rad_s);
  CHECK_NEAR("ms", 50.0, 1e3 * time_to_90_percent_s(backwards, 0, kRun, -kStep_rad_s), 0.5);
  CHECK_NEAR("overshoot", 0.25, overshoot_fraction(backwards, 0, kRun, -kStep_rad_s), 1e-12);
}

void test_a_step_of_zero_has_no_start() {
  const Trace still = run_with([](double) { return 0.0; });
  TEST_ASSERT_TRUE(is_no_value(time_to_90_percent_s(still, 0, kRun, 0.0)));
  TEST_ASSERT_TRUE(is_no_value(overshoot_fraction(still, 0, kRun, 0.0)));
}

void test_an_empty_window_has_no_figures() {
  const Trace trace = run_with([](double) { return 1.0; });
  TEST_ASSERT_TRUE(is_no_value(time_to_90_percent_s(trace, 0, {5.0, 6.0}, kStep_rad_s)));
  TEST_ASSERT_TRUE(is_no_value(peak_rate_error_rad_s(trace, 0, {5.0, 6.0})));
}

void test_statistics_of_a_skewed_handful() {
  const std::vector<double> start_ms = {12.0, 762.0, 100.0, 90.0, 86.0};
  CHECK_NEAR("mean", 210.0, mean(start_ms), 1e-12);
  CHECK_NEAR("median", 90.0, median(start_ms), 1e-12);
  CHECK_NEAR("median of four", 0.5, median({0.0, 1.0, 0.0, 1.0}), 1e-12);
  CHECK_NEAR("95th percentile of 0 to 10", 9.5, quantile({10, 9, 8, 7, 6, 5, 4, 3, 2, 1, 0}, 0.95), 1e-12);
  CHECK_NEAR("largest", 3.0, quantile({3.0, 1.0}, 1.0), 1e-12);
  CHECK_NEAR("correlation of a falling line", -1.0, correlation({1.0, 2.0, 3.0}, {5.0, 3.0, 1.0}), 1e-12);
  CHECK_NEAR("correlation with a constant", 0.0, correlation({1.0, 2.0, 3.0}, {5.0, 5.0, 5.0}), 1e-12);
  CHECK_NEAR("standard deviation", std::sqrt(2.0), standard_deviation({1.0, 3.0}), 1e-12);
  CHECK_NEAR("of one value", 0.0, standard_deviation({3.0}), 0.0);
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_a_ramp_of_100_ms_is_at_90_percent_after_90_ms);
  RUN_TEST(test_a_touch_that_sags_again_does_not_count);
  RUN_TEST(test_a_single_row_below_90_percent_starts_the_wait_anew);
  RUN_TEST(test_a_gust_after_the_dwell_is_no_part_of_the_start);
  RUN_TEST(test_a_gust_within_the_dwell_is_part_of_the_start);
  RUN_TEST(test_a_start_that_never_arrives_has_no_end);
  RUN_TEST(test_a_step_backwards_is_judged_as_one_forwards);
  RUN_TEST(test_a_step_of_zero_has_no_start);
  RUN_TEST(test_an_empty_window_has_no_figures);
  RUN_TEST(test_statistics_of_a_skewed_handful);
  return UNITY_END();
}
