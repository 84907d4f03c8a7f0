// SPDX-License-Identifier: Apache-2.0
// A scenario whose axes move one at a time: each in a run of its own, put together as one trace.
#include "design/control_design.hpp"
#include "machine/run/scenario_run.hpp"
#include "support/bench.hpp"
#include "support/check.h"

extern "C" void setUp(void) {}
extern "C" void tearDown(void) {}

namespace {

using namespace bench;

Trace run_at_2_deg_s(AxesMove axes_move, std::array<bool, kAxes> axes) {
  const PlantConfig plant = shipped_plant("tracker");
  ScenarioConfig scenario = shipped_scenario("steady_speed");
  scenario.duration_s = 4.0;
  scenario.axes_move = axes_move;
  scenario.axes = axes;
  const servo_params params = design_controller(plant, controller_spec("pi"), DesignOptions{});
  return run_scenario({&plant, &scenario, 2.0 * kRadPerDeg, params, 1});
}

void test_each_axis_moves_as_it_does_alone() {
  const Trace trace = run_at_2_deg_s(AxesMove::kOneAtATime, {true, true});
  const Trace azimuth = run_at_2_deg_s(AxesMove::kTogether, {true, false});
  const Trace pitch = run_at_2_deg_s(AxesMove::kTogether, {false, true});
  TEST_ASSERT_EQUAL(4000, trace.size());
  for (std::size_t row = 0; row < trace.size(); ++row) {
    CHECK_SAME("azimuth, rad/s", azimuth[row].axis[kAzimuth].rate_rad_s, trace[row].axis[kAzimuth].rate_rad_s);
    CHECK_SAME("pitch, rad/s", pitch[row].axis[kPitch].rate_rad_s, trace[row].axis[kPitch].rate_rad_s);
  }
}

void test_the_azimuth_does_not_see_the_pitch_move() {
  const Trace together = run_at_2_deg_s(AxesMove::kTogether, {true, true});
  const Trace alone = run_at_2_deg_s(AxesMove::kOneAtATime, {true, true});
  const auto angle_rad = [](const Trace& trace, int axis) {
    return trace.back().axis[static_cast<std::size_t>(axis)].joint_angle_rad;
  };
  CHECK_NEAR("pitch, rad", angle_rad(together, kPitch), angle_rad(alone, kPitch), 2e-3);
  CHECK_AT_LEAST("pitch, rad", 6.0 * kRadPerDeg, angle_rad(alone, kPitch));
  TEST_ASSERT_FALSE(together.back().axis[kAzimuth].rate_rad_s == alone.back().axis[kAzimuth].rate_rad_s);
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_each_axis_moves_as_it_does_alone);
  RUN_TEST(test_the_azimuth_does_not_see_the_pitch_move);
  return UNITY_END();
}
