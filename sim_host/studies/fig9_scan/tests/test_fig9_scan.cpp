// The scan for numbers that would reproduce Fig. 7 and Fig. 9 of the paper together.
#include "studies/fig9_scan/fig9_scan.hpp"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <stdexcept>

#include "support/check.h"

extern "C" void setUp(void) {}
extern "C" void tearDown(void) {}

namespace {

using namespace trackservo::sim;

Fig9Setup setup() {
  Fig9Setup setup;
  setup.axis = load_plant("sim_host/plants/paper_simulation.toml").axis[kAzimuth];
  setup.sine = load_scenario("sim_host/scenarios/sine.toml");
  setup.disturbed_step = load_scenario("sim_host/scenarios/step_disturbed.toml");
  return setup;
}

constexpr Fig9Paper kPaper{25.0, 1.25};

void nothing(int /*done*/, int /*total*/, const std::string& /*what*/) {}

// Motor, sensors, delays and the firmware's own PI, on the shipped plant.
double overshoot_of_the_machine(FrictionModel friction) {
  Study study;
  study.experiment = "step_disturbed";
  study.plant = load_plant("sim_host/plants/paper_simulation.toml");
  study.scenario = load_scenario("sim_host/scenarios/step_disturbed.toml");
  RunChoice choice;
  choice.controller = &controller_spec("pi");
  choice.friction = friction;
  const StudyCase step = cases_of(study).front();
  for (const Figure& figure : measure(study, step, run_case(study, step, choice))) {
    if (figure.axis == kAzimuth && figure.metric == "overshoot") {
      return figure.value;
    }
  }
  TEST_FAIL_MESSAGE("no overshoot");
  return 0.0;
}

void test_the_shipped_numbers_overshoot_as_the_whole_machine_does() {
  const Fig9Outcome outcome = try_fig9_set(setup(), {});
  CHECK_NEAR("with friction, %", overshoot_of_the_machine(FrictionModel::kLugre), outcome.overshoot, 0.2);
  CHECK_NEAR("without, %", overshoot_of_the_machine(FrictionModel::kNone), outcome.free_overshoot, 0.2);
  CHECK_NEAR("sine, deg/s", 0.248, outcome.sine_error_deg_s, 0.01);
  TEST_ASSERT_TRUE(outcome.matches_fig7());
}

// zeta = 0.6 and no set-point weight: the textbook's second-order system, and the addition of the disturbance.
void test_without_friction_the_step_is_that_of_a_second_order_system() {
  Fig9Set set;
  set.natural_frequency_rad_s = 5.65;
  set.damping = 0.6;
  set.setpoint_weight = 0.0;
  Fig9Setup quiet = setup();
  quiet.disturbed_step.disturbance_amplitude_rad_s = 0.0;
  CHECK_NEAR("overshoot, %", 100.0 * std::exp(-kPi * 0.6 / 0.8), try_fig9_set(quiet, set).free_overshoot, 0.3);
}

// J dv/dt = torque + J dd/dt moves v + d as J dv/dt = torque moves the measured v + d: the same only without friction.
void test_without_friction_it_does_not_matter_where_the_disturbance_enters() {
  Fig9Set set;
  const double as_torque = try_fig9_set(setup(), set).free_overshoot;
  set.disturbance = Fig9Disturbance::kSpeed;
  CHECK_NEAR("overshoot, %", as_torque, try_fig9_set(setup(), set).free_overshoot, 0.05);
}

void test_sets_stay_in_their_ranges_and_use_them() {
  int speeds = 0;
  int weights[3] = {0, 0, 0};
  double min_nm = 40.0;
  double max_nm = 0.2;
  for (int i = 0; i < 2000; ++i) {
    const Fig9Set set = fig9_set(7, i);
    TEST_ASSERT_TRUE(set.coulomb_nm >= 0.2 && set.coulomb_nm <= 40.0);
    TEST_ASSERT_TRUE(set.breakaway_share >= 1.0 && set.breakaway_share <= 2.5);
    TEST_ASSERT_TRUE(set.stribeck_speed_deg_s >= 0.05 && set.stribeck_speed_deg_s <= 3.0);
    TEST_ASSERT_TRUE(set.natural_frequency_rad_s >= 1.6 && set.natural_frequency_rad_s <= 100.0);
    TEST_ASSERT_TRUE(set.damping >= 0.3 && set.damping <= 2.0);
    TEST_ASSERT_TRUE(set.disturbance_phase_rad >= 0.0 && set.disturbance_phase_rad <= 2.0 * kPi);
    min_nm = std::min(min_nm, set.coulomb_nm);
    max_nm = std::max(max_nm, set.coulomb_nm);
    ++weights[static_cast<int>(2.0 * set.setpoint_weight)];
    speeds += set.disturbance == Fig9Disturbance::kSpeed ? 1 : 0;
  }
  TEST_ASSERT_TRUE(min_nm < 0.3 && max_nm > 30.0);
  TEST_ASSERT_TRUE(weights[0] > 500 && weights[1] > 500 && weights[2] > 500);
  TEST_ASSERT_TRUE(speeds > 800 && speeds < 1200);
}

void test_the_number_of_threads_changes_nothing() {
  Fig9Setup few = setup();
  few.samples = 12;
  few.threads = 1;
  const std::vector<Fig9Outcome> alone = scan_fig9(few, nothing);
  few.threads = 3;
  const std::vector<Fig9Outcome> together = scan_fig9(few, nothing);
  for (std::size_t i = 0; i < alone.size(); ++i) {
    CHECK_NEAR("overshoot", alone[i].overshoot, together[i].overshoot, 0.0);
    CHECK_NEAR("sine", alone[i].sine_error_deg_s, together[i].sine_error_deg_s, 0.0);
  }
}

// The finding: read as points, no set of Fig. 7 comes close to Fig. 9.
void test_no_set_that_gives_fig_7_overshoots_by_25_points_more() {
  Fig9Setup few = setup();
  few.samples = 300;
  const Fig9Summary summary = summary_of(scan_fig9(few, nothing), kPaper);
  TEST_ASSERT_TRUE(summary.matching >= 10 && summary.matching <= 45);
  TEST_ASSERT_EQUAL_INT(0, summary.matching_points);
  TEST_ASSERT_TRUE(summary.max_points.points() < 5.0);
}

// The other finding: read as a ratio, there are such sets. The scan found this one.
void test_a_set_that_gives_fig_7_overshoots_1_25_times_as_far() {
  Fig9Set set;
  set.coulomb_nm = 0.433;
  set.breakaway_share = 1.06 / 0.433;
  set.stribeck_speed_deg_s = 1.45;
  set.natural_frequency_rad_s = 5.38;
  set.damping = 0.894;
  set.setpoint_weight = 0.5;
  const Fig9Outcome outcome = try_fig9_set(setup(), set);
  TEST_ASSERT_TRUE(outcome.matches_fig7() && outcome.has_ratio());
  TEST_ASSERT_TRUE(outcome.ratio() >= kPaper.ratio);
  TEST_ASSERT_TRUE(outcome.points() < 2.0);
}

Fig9Outcome outcome(double sine_deg_s, double overshoot, double free) { return {{}, sine_deg_s, overshoot, free}; }

void test_the_summary_counts_matching_sets_and_both_readings() {
  const Fig9Summary summary = summary_of(
      {
          outcome(0.25, 12.0, 10.0),  // + 2 points, x 1.2
          outcome(0.30, 6.5, 5.0),    // + 1.5 points, x 1.3, at the edge of the band
          outcome(0.25, 3.4, 0.9),    // + 2.5 points; no ratio to less than 1 %
          outcome(0.25, 9.0, 5.0),    // + 4 points, x 1.8
          outcome(0.31, 60.0, 5.0),   // not Fig. 7
          outcome(0.19, 40.0, 5.0),   // not Fig. 7
      },
      kPaper);
  TEST_ASSERT_EQUAL_INT(4, summary.matching);
  TEST_ASSERT_EQUAL_INT(0, summary.matching_points);
  TEST_ASSERT_EQUAL_INT(2, summary.matching_ratio);
  CHECK_NEAR("most points", 4.0, summary.max_points.points(), 1e-12);
  CHECK_NEAR("nearest ratio", 1.2, summary.nearest_ratio.ratio(), 0.11);
  CHECK_NEAR("largest ratio", 1.8, summary.max_ratio.ratio(), 1e-12);
  TEST_ASSERT_EQUAL_INT(2, summary.any_points);
  CHECK_NEAR("most of all", 55.0, summary.any_most_points, 1e-12);
}

void test_a_scan_without_a_matching_set_says_what_to_do() {
  try {
    (void)summary_of({outcome(1.0, 5.0, 5.0)}, kPaper);
    TEST_FAIL_MESSAGE("not refused");
  } catch (const std::runtime_error& error) {
    TEST_ASSERT_NOT_NULL(std::strstr(error.what(), "--samples"));
  }
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_the_shipped_numbers_overshoot_as_the_whole_machine_does);
  RUN_TEST(test_without_friction_the_step_is_that_of_a_second_order_system);
  RUN_TEST(test_without_friction_it_does_not_matter_where_the_disturbance_enters);
  RUN_TEST(test_sets_stay_in_their_ranges_and_use_them);
  RUN_TEST(test_the_number_of_threads_changes_nothing);
  RUN_TEST(test_no_set_that_gives_fig_7_overshoots_by_25_points_more);
  RUN_TEST(test_a_set_that_gives_fig_7_overshoots_1_25_times_as_far);
  RUN_TEST(test_the_summary_counts_matching_sets_and_both_readings);
  RUN_TEST(test_a_scan_without_a_matching_set_says_what_to_do);
  return UNITY_END();
}
