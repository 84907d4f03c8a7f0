// SPDX-License-Identifier: Apache-2.0
// The firmware's pointing of both axes in the simulated machine: straight passes, a turned camera, evasion, dropouts.
#include <cmath>

#include "analysis/metrics.hpp"
#include "design/control_design.hpp"
#include "run/scenario_check.hpp"
#include "run/scenario_run.hpp"
#include "support/bench.hpp"
#include "support/check.h"

extern "C" void setUp(void) {}
extern "C" void tearDown(void) {}

namespace {

using namespace bench;

ScenarioConfig pass_at(double elevation_deg) {
  ScenarioConfig scenario =
      load_scenario(std::string(TRACKSERVO_SOURCE_DIR) + "/sim_host/studies/straight_passes/scenario.toml");
  scenario.pass->elevation_rad = elevation_deg * kRadPerDeg;
  scenario.fly_by = course_of(*scenario.pass);
  return scenario;
}

Trace run(const ScenarioConfig& scenario) {
  const PlantConfig plant = shipped_plant("tracker");
  RunRequest request;
  request.plant = &plant;
  request.scenario = &scenario;
  DesignOptions design;
  design.tracker = TRACKER_PREDICTIVE;
  request.params = design_controller(plant, controller_spec("pi_vob_ftc"), design);
  return run_scenario(request);
}

double sigma_urad(const Trace& trace, int axis, double from_s, double to_s) {
  return 1e6 * tracking_sigma_rad(trace, axis, {from_s, to_s});
}

double worst_sigma_urad(const ScenarioConfig& scenario) {
  const Trace trace = run(scenario);
  return std::max(sigma_urad(trace, kAzimuth, scenario.settle_s, scenario.duration_s),
                  sigma_urad(trace, kPitch, scenario.settle_s, scenario.duration_s));
}

void test_a_pass_at_85_degrees_is_held_within_5_urad() {
  const double one_loop_urad = worst_sigma_urad(pass_at(85.0));
  ScenarioConfig apart = pass_at(85.0);
  apart.pointing = Pointing::kPerAxis;
  const double per_axis_urad = worst_sigma_urad(apart);
  LOG_VALUE("one loop for the line of sight, urad", one_loop_urad);
  LOG_VALUE("a loop per axis, urad", per_axis_urad);
  CHECK_AT_MOST("urad", 5.0, one_loop_urad);
  CHECK_AT_LEAST("urad", 5.0 * one_loop_urad, per_axis_urad);
}

// Far from the zenith the two ways to track are the same loop.
void test_the_fly_by_of_the_paper_is_held_as_well_as_by_a_loop_per_axis() {
  const ScenarioConfig apart = shipped_scenario("tracking");
  ScenarioConfig together = apart;
  together.camera.geometry = CameraGeometry::kLineOfSight;
  together.pointing = Pointing::kLineOfSight;
  const Trace per_axis = run(apart);
  const Trace one_loop = run(together);
  for (int axis = 0; axis < kAxes; ++axis) {
    const double per_axis_urad = sigma_urad(per_axis, axis, apart.settle_s, apart.duration_s);
    const double one_loop_urad = sigma_urad(one_loop, axis, apart.settle_s, apart.duration_s);
    LOG_VALUE("one loop for the line of sight, urad", one_loop_urad);
    CHECK_RELATIVE("urad", per_axis_urad, one_loop_urad, 0.05);
  }
}

void test_a_turned_camera_with_a_boresight_offset_holds_the_target_at_the_boresight() {
  ScenarioConfig scenario = pass_at(80.0);
  scenario.camera.mounting = {40.0 * kRadPerDeg, 1e-3, -0.5e-3};
  const Trace trace = run(scenario);
  for (int axis = 0; axis < kAxes; ++axis) {
    double mean_urad = 0.0;
    int rows = 0;
    for (const TraceRow& row : trace) {
      if (row.time_s >= scenario.settle_s) {
        mean_urad += 1e6 * row.axis[static_cast<std::size_t>(axis)].tracking_error_rad;
        ++rows;
      }
    }
    CHECK_NEAR("mean error, urad", 0.0, mean_urad / rows, 3.0);
    CHECK_AT_MOST("urad", 5.0, sigma_urad(trace, axis, scenario.settle_s, scenario.duration_s));
  }
}

void test_after_a_dropout_the_error_is_back_within_half_a_second() {
  ScenarioConfig scenario = pass_at(60.0);
  scenario.camera.dropouts_at_s = {20.0};
  scenario.camera.dropout_s = 0.4;
  const Trace trace = run(scenario);
  for (int axis = 0; axis < kAxes; ++axis) {
    LOG_VALUE("in the dropout, urad", sigma_urad(trace, axis, 20.0, 20.4));
    CHECK_AT_MOST("after it, urad", 5.0, sigma_urad(trace, axis, 20.9, 25.0));
  }
}

void test_an_evading_target_stays_in_the_picture() {
  ScenarioConfig scenario = pass_at(60.0);
  scenario.pass->evasive_m_s2 = 5.0;
  scenario.fly_by = course_of(*scenario.pass);
  const double urad = worst_sigma_urad(scenario);
  LOG_VALUE("5 m/s2, period 4 s, urad", urad);
  CHECK_AT_MOST("urad", 1000.0, urad);
}

void test_a_pass_through_the_zenith_is_a_scenario() {
  const PlantConfig plant = shipped_plant("tracker");
  TEST_ASSERT_EQUAL(0, check_scenario(plant, pass_at(90.0)).size());
  const Trace trace = run(pass_at(90.0));
  for (const TraceRow& row : trace) {
    TEST_ASSERT_TRUE(std::isfinite(row.axis[kAzimuth].joint_angle_rad));
  }
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_a_pass_at_85_degrees_is_held_within_5_urad);
  RUN_TEST(test_the_fly_by_of_the_paper_is_held_as_well_as_by_a_loop_per_axis);
  RUN_TEST(test_a_turned_camera_with_a_boresight_offset_holds_the_target_at_the_boresight);
  RUN_TEST(test_after_a_dropout_the_error_is_back_within_half_a_second);
  RUN_TEST(test_an_evading_target_stays_in_the_picture);
  RUN_TEST(test_a_pass_through_the_zenith_is_a_scenario);
  return UNITY_END();
}
