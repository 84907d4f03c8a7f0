// Tracking in the running node: the camera's frames come as PDOs, and both axes are in mode -1. It must be as good as
// in sim_host run, which hands the frames over without a bus. The program prints both.
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <string>

#include "bench.hpp"
#include "tracking_bench.hpp"
#include "unity.h"

namespace sim = trackservo::sim;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using bench::designed_tracker;
using bench::Spread;
using bench::tracker_setup;
using bench::tracking_scenario;
using bench::TrackingBench;

Spread spread_by_run(const servo_params& params, std::uint64_t seed) {
  const sim::ScenarioConfig config = tracking_scenario();
  sim::RunRequest request;
  request.plant = &tracker_setup().plant;
  request.scenario = &config;
  request.params = params;
  request.seed = seed;
  Spread spread;
  for (const sim::TraceRow& row : sim::run_scenario(request)) {
    if (row.time_s >= config.settle_s) {
      spread.add({row.axis[0].tracking_error_rad, row.axis[1].tracking_error_rad});
    }
  }
  return spread;
}

// Required: within 10 % of the same by run.
void compare(const char *name, tracker_kind kind, const std::array<double, sim::kAxes>& max_urad) {
  for (const std::uint64_t seed : bench::kSeeds) {
    TrackingBench tracking(tracking_scenario(), seed, designed_tracker(kind));
    const Spread on_bus = tracking.track();
    const Spread by_run = spread_by_run(tracking.node().node().board.app.params, seed);
    for (std::size_t axis = 0; axis < sim::kAxes; ++axis) {
      const std::string text =
          fmt::format("{}, seed {}, {}: {:.2f} urad over the bus, {:.2f} by run", name, seed,
                      axis == sim::kAzimuth ? "azimuth" : "pitch", on_bus.urad(axis), by_run.urad(axis));
      TEST_MESSAGE(text.c_str());
      TEST_ASSERT_TRUE_MESSAGE(on_bus.urad(axis) < 1.1 * by_run.urad(axis), text.c_str());
      TEST_ASSERT_TRUE_MESSAGE(on_bus.urad(axis) < max_urad[axis], text.c_str());
    }
    TEST_ASSERT_EQUAL_UINT32(0, tracking.node().node().tracking.frames.dropped);
  }
}

void test_the_fly_by_with_the_papers_loop() { compare("paper's loop", TRACKER_PI, {15.0, 15.0}); }

void test_the_fly_by_with_the_predictive_loop() { compare("predictive", TRACKER_PREDICTIVE, {2.5, 3.0}); }

// As sim_host passes: 20 m/s, 500 m up. Required: 5 urad.
void test_passes_up_to_85_degrees() {
  for (const double elevation_deg : {60.0, 80.0, 85.0}) {
    sim::ScenarioConfig pass = sim::load_scenario("sim_host/studies/straight_passes/scenario.toml");
    pass.pass->elevation_rad = elevation_deg * sim::kRadPerDeg;
    pass.fly_by = sim::course_of(*pass.pass);
    target_tracker_params tracker = designed_tracker(TRACKER_PREDICTIVE);
    tracker.proportional_per_s = 30.0F;
    tracker.estimator_rad_s = 6.0F;
    TrackingBench tracking(pass, bench::kSeeds[0], tracker);
    const Spread spread = tracking.track();
    const std::string text = fmt::format("pass at {} deg: {:.2f} urad cross-elevation, {:.2f} elevation", elevation_deg,
                                         spread.urad(0), spread.urad(1));
    TEST_MESSAGE(text.c_str());
    TEST_ASSERT_TRUE_MESSAGE(spread.urad(0) < 5.0 && spread.urad(1) < 5.0, text.c_str());
  }
}

// No frame shows the target from 20 s to 21 s: both axes coast.
void test_a_second_without_the_target() {
  sim::ScenarioConfig with = tracking_scenario();
  with.camera.dropouts_at_s = {20.0};
  with.camera.dropout_s = 1.0;
  target_tracker_params tracker = designed_tracker(TRACKER_PREDICTIVE);
  tracker.coast_s = 2.0F;
  TrackingBench tracking(with, bench::kSeeds[0], tracker);
  double largest_step_nm = 0.0;
  std::array<double, sim::kAxes> torque_nm{};
  Spread before;
  Spread after;
  while (tracking.time_s() < 31.5) {
    for (int axis = 0; axis < sim::kAxes; ++axis) {
      const double now_nm = static_cast<double>(tracking.node().machine().firmware(axis).commanded_nm);
      if (tracking.time_s() > 19.0) {
        largest_step_nm = std::max(largest_step_nm, std::abs(now_nm - torque_nm[static_cast<std::size_t>(axis)]));
      }
      torque_nm[static_cast<std::size_t>(axis)] = now_nm;
    }
    if (tracking.time_s() >= 10.0 && tracking.time_s() < 20.0) {
      before.add(tracking.error_rad());
    } else if (tracking.time_s() >= 21.5) {
      after.add(tracking.error_rad());
    }
    tracking.tick();
  }
  const std::string text = fmt::format(
      "10 s before: {:.2f} and {:.2f} urad; from 0.5 s after: {:.2f} and {:.2f}; largest step of the torque {:.2f} Nm",
      before.urad(0), before.urad(1), after.urad(0), after.urad(1), largest_step_nm);
  TEST_MESSAGE(text.c_str());
  TEST_ASSERT_TRUE_MESSAGE(after.urad(0) < 2.0 * before.urad(0) && after.urad(1) < 2.0 * before.urad(1), text.c_str());
  TEST_ASSERT_TRUE_MESSAGE(largest_step_nm < 3.0, text.c_str());
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_the_fly_by_with_the_papers_loop);
  RUN_TEST(test_the_fly_by_with_the_predictive_loop);
  RUN_TEST(test_passes_up_to_85_degrees);
  RUN_TEST(test_a_second_without_the_target);
  return UNITY_END();
}
