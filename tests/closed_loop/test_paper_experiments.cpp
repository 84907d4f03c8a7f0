// SPDX-License-Identifier: Apache-2.0
// The paper's experiments as regressions: the baseline must stay at the paper's values, the result at ours.
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "bench.hpp"
#include "unity.h"

using bench::mean_figure;
using bench::study;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

void must_be_within(double low, double high, double value, const char *what) {
  char text[120];
  (void)std::snprintf(text, sizeof text, "%s: %.5g, band %.5g .. %.5g", what, value, low, high);
  TEST_MESSAGE(text);
  TEST_ASSERT_TRUE_MESSAGE(value >= low && value <= high, text);
}

void test_sine_through_standstill_pi_alone_errs_as_in_the_paper() {
  must_be_within(0.24, 0.26, mean_figure(study("sine", "paper_simulation"), "pi", 0, "peak_error"), "deg/s, PI");
}

void test_sine_through_standstill_with_observer_and_feedforward_stays_below_a_hundredth() {
  must_be_within(0.0, 0.010, mean_figure(study("sine", "paper_simulation"), "pi_vob_ftc", 0, "peak_error"),
                 "deg/s, PI + VOB + FTC");
}

void test_each_ingredient_of_the_sine_helps() {
  const auto sine = study("sine", "paper_simulation");
  const double pi = mean_figure(sine, "pi", 0, "rms_error");
  const double ftc = mean_figure(sine, "pi_ftc", 0, "rms_error");
  const double vob = mean_figure(sine, "pi_vob", 0, "rms_error");
  const double both = mean_figure(sine, "pi_vob_ftc", 0, "rms_error");
  TEST_ASSERT_TRUE(ftc < 0.3 * pi);
  TEST_ASSERT_TRUE(vob < 0.1 * pi);
  TEST_ASSERT_TRUE(both < vob);
}

void test_steady_speed_pi_alone_errs_as_in_table_2() {
  const auto steady = study("steady_speed", "tracker");
  const double table_2[] = {0.086, 0.084, 0.095, 0.078, 0.082};
  for (std::size_t i = 0; i < 5; ++i) {
    // 15 % of calibration and, with two seeds instead of five, 8 % for the seeds.
    must_be_within(0.77 * table_2[i], 1.23 * table_2[i], mean_figure(steady, "pi", i, "peak_error"), "deg/s, PI");
  }
}

void test_steady_speed_with_observer_and_feedforward_stays_below_the_paper() {
  const auto steady = study("steady_speed", "tracker");
  for (std::size_t i = 0; i < 5; ++i) {
    must_be_within(0.0, 0.014, mean_figure(steady, "pi_vob_ftc", i, "peak_error"), "deg/s, PI + VOB + FTC");
  }
}

void test_start_up_at_a_tenth_of_a_degree_waits_without_feedforward() {
  must_be_within(100.0, 2000.0, mean_figure(study("low_speed_start", "tracker"), "pi", 0, "time_to_90_percent"),
                 "ms, PI");
}

void test_start_up_at_a_tenth_of_a_degree_is_quick_with_feedforward() {
  const auto start = study("low_speed_start", "tracker");
  must_be_within(5.0, 30.0, mean_figure(start, "pi_vob_ftc", 0, "time_to_90_percent"), "ms, PI + VOB + FTC");
  must_be_within(0.0, 12.0, mean_figure(start, "pi_vob_ftc", 0, "overshoot"), "% overshoot");
}

// The figure's dwell does not make it small: with compensation the speed stays up to the end of the run.
void test_start_up_with_compensation_never_falls_back_below_90_percent() {
  const auto start = study("low_speed_start", "tracker");
  const double speed_rad_s = start.scenario.speeds_rad_s.front();
  for (const std::uint64_t seed : bench::kSeeds) {
    double lowest_rad_s = speed_rad_s;
    for (const trackservo::sim::TraceRow& row : bench::run(start, "pi_vob_ftc", 0, seed)) {
      if (row.time_s >= start.scenario.rest_s + 0.030) {
        lowest_rad_s = std::min(lowest_rad_s, row.axis[trackservo::sim::kAzimuth].rate_rad_s);
      }
    }
    must_be_within(0.9, 1.0, lowest_rad_s / speed_rad_s, "of the set-point, lowest from 30 ms on");
  }
}

// The report's statement beside Table 2: the wind causes the uncompensated column, not friction.
void test_without_wind_pi_alone_has_no_error_worth_compensating() {
  auto steady = study("steady_speed", "tracker");
  for (auto& axis : steady.plant.axis) {
    axis.load.wind_mean_nm = 0.0;
    axis.load.wind_gust_rms_nm = 0.0;
  }
  must_be_within(0.0, 0.010, mean_figure(steady, "pi", 0, "peak_error"), "deg/s, PI without wind");
}

void test_step_with_disturbance_overshoots_as_without_friction() {
  auto step = study("step_disturbed", "paper_simulation");
  const double with_friction = mean_figure(step, "pi_vob_ftc", 0, "overshoot");
  step.plant.friction_model = trackservo::sim::FrictionModel::kNone;
  const double without = mean_figure(step, "pi_vob_ftc", 0, "overshoot");
  must_be_within(-2.0, 2.0, with_friction - without, "points above friction-free");
}

void test_tracking_with_the_papers_loop_stays_below_twelve_microradians() {
  const auto tracking = study("tracking", "tracker");
  must_be_within(42.0, 70.0, mean_figure(tracking, "pi", 0, "tracking_sigma"), "urad, PI");
  must_be_within(0.0, 12.0, mean_figure(tracking, "pi_vob_ftc", 0, "tracking_sigma"), "urad, PI + VOB + FTC");
}

void test_tracking_with_prediction_stays_below_six_microradians() {
  must_be_within(0.0, 6.0,
                 mean_figure(study("tracking", "tracker", TRACKER_PREDICTIVE), "pi_vob_ftc", 0, "tracking_sigma"),
                 "urad, PI + VOB + FTC, improved loop");
}

void test_compensation_helps_on_friction_that_is_not_its_own_model() {
  auto steady = study("steady_speed", "tracker");
  steady.plant.friction_model = trackservo::sim::FrictionModel::kMaxwellSlip;
  const double pi = mean_figure(steady, "pi", 0, "peak_error");
  must_be_within(0.0, 0.25 * pi, mean_figure(steady, "pi_vob_ftc", 0, "peak_error"), "deg/s on Maxwell-slip");
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_sine_through_standstill_pi_alone_errs_as_in_the_paper);
  RUN_TEST(test_sine_through_standstill_with_observer_and_feedforward_stays_below_a_hundredth);
  RUN_TEST(test_each_ingredient_of_the_sine_helps);
  RUN_TEST(test_steady_speed_pi_alone_errs_as_in_table_2);
  RUN_TEST(test_steady_speed_with_observer_and_feedforward_stays_below_the_paper);
  RUN_TEST(test_start_up_at_a_tenth_of_a_degree_waits_without_feedforward);
  RUN_TEST(test_start_up_at_a_tenth_of_a_degree_is_quick_with_feedforward);
  RUN_TEST(test_start_up_with_compensation_never_falls_back_below_90_percent);
  RUN_TEST(test_without_wind_pi_alone_has_no_error_worth_compensating);
  RUN_TEST(test_step_with_disturbance_overshoots_as_without_friction);
  RUN_TEST(test_tracking_with_the_papers_loop_stays_below_twelve_microradians);
  RUN_TEST(test_tracking_with_prediction_stays_below_six_microradians);
  RUN_TEST(test_compensation_helps_on_friction_that_is_not_its_own_model);
  return UNITY_END();
}
