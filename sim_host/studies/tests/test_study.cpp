// SPDX-License-Identifier: Apache-2.0
// The figures of a study, the changes of a variation, and the names of a campaign's files.
#include "studies/shared/study.hpp"

#include <cstring>
#include <set>
#include <stdexcept>

#include "design/true_plant.hpp"
#include "studies/identification_value/identification_value.hpp"
#include "studies/sensitivity/sensitivity.hpp"
#include "studies/shared/derived.hpp"
#include "studies/shared/experiment.hpp"
#include "studies/shared/goals.hpp"
#include "studies/shared/run_files.hpp"
#include "support/check.h"

extern "C" void setUp(void) {}
extern "C" void tearDown(void) {}

namespace {

using namespace trackservo::sim;

Experiment shipped(const std::string& name) { return experiment_named(name, load_experiments("sim_host")); }

// A user's scenario: any name, one second, azimuth only.
ScenarioConfig scenario(ScenarioKind kind, double settle_s, double disturbance_rad_s = 0.0) {
  ScenarioConfig config;
  config.name = "my_own";
  config.kind = kind;
  config.duration_s = 1.0;
  config.rest_s = 0.1;
  config.settle_s = settle_s;
  config.axes = {true, false};
  config.disturbance_amplitude_rad_s = disturbance_rad_s;
  return config;
}

std::set<std::string> measured(const ScenarioConfig& config) {
  Study study;
  study.scenario = config;
  Trace trace(1000);
  for (std::size_t i = 0; i < trace.size(); ++i) {
    trace[i].time_s = 1e-3 * static_cast<double>(i);
  }
  std::set<std::string> metrics;
  for (const Figure& figure : measure(study, {"1 deg/s", 0.0175}, trace)) {
    TEST_ASSERT_EQUAL_INT(kAzimuth, figure.axis);
    metrics.insert(figure.metric);
  }
  TEST_ASSERT_TRUE(metrics.count(deciding_metric(study)) == 1);
  return metrics;
}

void test_a_step_without_time_to_settle_is_judged_by_its_start() {
  TEST_ASSERT_TRUE((std::set<std::string>{"time_to_90_percent", "overshoot"}) ==
                   measured(scenario(ScenarioKind::kSpeedStep, 0.0)));
}

void test_a_step_with_time_to_settle_is_judged_by_its_error() {
  TEST_ASSERT_TRUE((std::set<std::string>{"peak_error", "rms_error", "torque_noise"}) ==
                   measured(scenario(ScenarioKind::kSpeedStep, 0.2)));
}

void test_a_disturbed_step_is_judged_by_its_overshoot() {
  TEST_ASSERT_TRUE((std::set<std::string>{"overshoot"}) == measured(scenario(ScenarioKind::kSpeedStep, 0.0, 0.01)));
}

void test_a_sine_is_judged_by_its_error() {
  TEST_ASSERT_TRUE((std::set<std::string>{"peak_error", "rms_error", "torque_noise"}) ==
                   measured(scenario(ScenarioKind::kSpeedSine, 0.0)));
}

void test_a_target_is_judged_by_the_line_of_sight() {
  TEST_ASSERT_TRUE((std::set<std::string>{"tracking_sigma", "torque_noise"}) ==
                   measured(scenario(ScenarioKind::kTracking, 0.2)));
}

// A variation that changes nothing, or has a probe outside all studies, would compare a run with itself.
void test_every_variation_changes_the_shipped_setting_where_it_is_looked_at() {
  const std::vector<Experiment> experiments = load_experiments("sim_host");
  std::vector<Study> studies = studies_of(experiments);
  for (Study& study : studies) {
    study.identified = AssumedPlant{true_plant(study.plant, kAzimuth), true_plant(study.plant, kPitch)};
  }
  for (const Variation& variation : variations(experiments)) {
    for (const CaseFigures& figures : variation.looked_at) {
      int found = 0;
      for (const Study& shipped : studies) {
        for (const StudyCase& study_case : cases_of(shipped)) {
          if (shipped.experiment == figures.experiment && study_case.name == figures.case_name) {
            Study varied = shipped;
            variation.change(varied);
            TEST_ASSERT_TRUE_MESSAGE(variation.setting(shipped) != variation.setting(varied), variation.name.c_str());
            ++found;
          }
        }
      }
      TEST_ASSERT_EQUAL_INT_MESSAGE(1, found, variation.name.c_str());
    }
  }
}

void test_a_case_that_no_study_has_is_refused() {
  const CaseFigures nowhere{"steady_speed", "7 deg/s", {"peak_error"}};
  const std::vector<Experiment> experiments = load_experiments("sim_host");
  const std::vector<Variation> all = variations(experiments);
  const SensitivityJob job{&all.front(), &nowhere, "pi"};
  try {
    run_sensitivity_job(job, studies_of(experiments), {});
    TEST_FAIL_MESSAGE("not refused");
  } catch (const std::invalid_argument& error) {
    TEST_ASSERT_NOT_NULL(std::strstr(error.what(), "7 deg/s"));
  }
}

void test_file_names_have_no_letters_that_shells_dislike() {
  TEST_ASSERT_EQUAL_STRING("sine-1_deg_s__0.1_Hz-pi-seed_3.csv",
                           file_name({"sine", "1 deg/s, 0.1 Hz", "", "pi", "seed_3"}).c_str());
}

// Two figures, two seeds; computed by hand. Wrong parameters have the means 2 and 10.
void test_assumed_plants_are_compared_seed_by_seed_as_shares_of_the_wrong_one() {
  const std::vector<AssumedPlantFigure> figures{{"a", "", "", "", {1.0, 2.0}, {1.0, 1.0}, {1.0, 3.0}},
                                                {"b", "", "", "", {9.0, 10.0}, {8.0, 8.0}, {10.0, 10.0}}};
  const AssumedPlantSum sum = sum_of(figures);
  TEST_ASSERT_DOUBLE_WITHIN(1e-12, 2.0, sum.wrong.mean);
  TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0.5 * (1.0 / 2 + 9.0 / 10 + 2.0 / 2 + 10.0 / 10), sum.identified.mean);
  TEST_ASSERT_DOUBLE_WITHIN(1e-12, 1.0 / 2 + 8.0 / 10, sum.exact.mean);
  TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0.0, sum.exact.standard_error);
  TEST_ASSERT_DOUBLE_WITHIN(1e-12, 3.0 / 2 + 10.0 / 10, sum.worst_wrong);
  // Paired: -0.1 at the first seed, -0.5 at the second.
  TEST_ASSERT_DOUBLE_WITHIN(1e-12, -0.3, sum.identified_less_wrong.mean);
  TEST_ASSERT_DOUBLE_WITHIN(1e-12, 0.2, sum.identified_less_wrong.standard_error);
  TEST_ASSERT_DOUBLE_WITHIN(1e-12, -0.25, gain_of(figures.front()).mean);
}

Cell overshoot(FrictionModel friction, const char *controller, double percent) {
  return {"step_disturbed", "1 deg/s", "p", friction, controller, kAzimuth, "overshoot", "%", {percent}};
}

// "The overshoot increases by 25 %" has two readings.
void test_a_step_is_compared_with_the_friction_free_one_as_points_and_as_a_ratio() {
  const std::vector<Cell> all =
      with_derived({overshoot(FrictionModel::kLugre, "pi", 15.0), overshoot(FrictionModel::kNone, "pi", 12.0),
                    overshoot(FrictionModel::kLugre, "pi_best", 1.5), overshoot(FrictionModel::kNone, "pi_best", 0.5)},
                   load_experiments("sim_host"));
  TEST_ASSERT_EQUAL_INT(8, all.size());
  TEST_ASSERT_EQUAL_STRING("overshoot_above_friction_free", all[4].metric.c_str());
  CHECK_NEAR("points", 3.0, all[4].values[0], 1e-12);
  TEST_ASSERT_EQUAL_STRING("overshoot_over_friction_free", all[5].metric.c_str());
  CHECK_NEAR("ratio", 1.25, all[5].values[0], 1e-12);
  CHECK_NEAR("points", 1.0, all[6].values[0], 1e-12);
  TEST_ASSERT_DOUBLE_IS_NAN_MESSAGE(all[7].values[0], "a ratio to nearly nothing");
}

void test_both_readings_judge_the_compensated_step() {
  Cell cell = overshoot(FrictionModel::kLugre, "pi_vob_ftc", 0.0);
  cell.metric = "overshoot_above_friction_free";
  CHECK_NEAR("points, at most", 2.0, goal_of(cell, shipped(cell.experiment)).value().high, 1e-12);
  cell.metric = "overshoot_over_friction_free";
  CHECK_NEAR("ratio, at least", 0.9, goal_of(cell, shipped(cell.experiment)).value().low, 1e-12);
  CHECK_NEAR("ratio, at most", 1.1, goal_of(cell, shipped(cell.experiment)).value().high, 1e-12);
}

// PI alone has no goal there: the published plant cannot show it. But it must not count as reproduced.
void test_a_figure_of_the_paper_that_has_the_wrong_sign_is_not_reproduced() {
  Cell cell = overshoot(FrictionModel::kLugre, "pi", 0.0);
  cell.metric = "overshoot_above_friction_free";
  TEST_ASSERT_FALSE(goal_of(cell, shipped(cell.experiment)).has_value());
  TEST_ASSERT_FALSE(reproduces_paper(cell, -10.6, shipped(cell.experiment)).value());
  TEST_ASSERT_TRUE(reproduces_paper(cell, 24.0, shipped(cell.experiment)).value());
  cell.metric = "overshoot_over_friction_free";
  TEST_ASSERT_FALSE(reproduces_paper(cell, 0.12, shipped(cell.experiment)).value());
  TEST_ASSERT_TRUE(reproduces_paper(cell, 1.2, shipped(cell.experiment)).value());
  cell.controller = "pi_vob_ftc";
  TEST_ASSERT_FALSE(reproduces_paper(cell, 1.2, shipped(cell.experiment)).has_value());
}

void test_a_figure_of_the_paper_within_the_band_of_calibration_is_reproduced() {
  const Cell sine{"sine", "", "p", FrictionModel::kLugre, "pi", kAzimuth, "peak_error", "deg/s", {}};
  TEST_ASSERT_TRUE(reproduces_paper(sine, 0.248, shipped(sine.experiment)).value());
  TEST_ASSERT_FALSE(reproduces_paper(sine, 0.2, shipped(sine.experiment)).value());
  const Cell start{"low_speed_start",    "0.1 deg/s", "p", FrictionModel::kLugre, "pi", kAzimuth,
                   "time_to_90_percent", "ms",        {}};
  TEST_ASSERT_FALSE_MESSAGE(reproduces_paper(start, 700.0, shipped(start.experiment)).has_value(),
                            "the paper prints no time");
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_a_step_without_time_to_settle_is_judged_by_its_start);
  RUN_TEST(test_a_step_with_time_to_settle_is_judged_by_its_error);
  RUN_TEST(test_a_disturbed_step_is_judged_by_its_overshoot);
  RUN_TEST(test_a_sine_is_judged_by_its_error);
  RUN_TEST(test_a_target_is_judged_by_the_line_of_sight);
  RUN_TEST(test_every_variation_changes_the_shipped_setting_where_it_is_looked_at);
  RUN_TEST(test_a_case_that_no_study_has_is_refused);
  RUN_TEST(test_file_names_have_no_letters_that_shells_dislike);
  RUN_TEST(test_assumed_plants_are_compared_seed_by_seed_as_shares_of_the_wrong_one);
  RUN_TEST(test_a_step_is_compared_with_the_friction_free_one_as_points_and_as_a_ratio);
  RUN_TEST(test_both_readings_judge_the_compensated_step);
  RUN_TEST(test_a_figure_of_the_paper_that_has_the_wrong_sign_is_not_reproduced);
  RUN_TEST(test_a_figure_of_the_paper_within_the_band_of_calibration_is_reproduced);
  return UNITY_END();
}
