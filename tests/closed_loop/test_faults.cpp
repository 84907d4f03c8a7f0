// SPDX-License-Identifier: Apache-2.0
// Every fault injection: the firmware must detect it in time, react as its table says, and meet its requirements.
#include <fmt/format.h>

#include <cstdio>

#include "bench.hpp"
#include "judge/fault_injection/fault_matrix.hpp"
#include "judge/fault_injection/fault_scenario.hpp"
#include "judge/fault_injection/soak.hpp"
#include "support/test_size.h"
#include "unity.h"

namespace sim = trackservo::sim;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

sim::PlantConfig tracker_plant() { return sim::load_plant("sim_host/plants/tracker.toml"); }

// Random instants of each, in wind and in calm air; `sim_host faults` uses twenty.
void test_every_fault_injection_in_every_motion_is_seen_in_time_and_ends_as_promised() {
  sim::MatrixOptions options;
  options.moments = by_size(1, 2, 20);
  const auto stride = static_cast<std::size_t>(by_size(4, 1, 1));
  for (std::size_t i = 0; i < sim::fault_injections().size(); i += stride) {
    options.only.push_back(sim::fault_injections()[i].name);
  }
  const std::vector<sim::MatrixRow> rows = sim::run_fault_matrix(tracker_plant(), options);
  std::printf("%s\n", sim::print_fault_matrix(rows).c_str());
  fault_set expected = 0;
  fault_set reported = 0;
  for (const sim::MatrixRow& row : rows) {
    const bool always = row.fault_injection->detection == sim::Detection::kAlways;
    expected |= always ? fault_bit(row.fault_injection->expected) : 0;
    for (const auto& [fault, count] : row.taken_for) {
      reported |= fault_bit(fault);
    }
    TEST_ASSERT_TRUE_MESSAGE(row.hidden.empty() || !row.fault_injection->hidden_because.empty() || !always,
                             row.fault_injection->name.c_str());
    TEST_ASSERT_EQUAL_MESSAGE(10 * options.moments, row.injection_runs, row.fault_injection->name.c_str());
    TEST_ASSERT_TRUE_MESSAGE(row.seen > 0 || !always, row.fault_injection->name.c_str());
    for (const std::string& error : row.errors) {
      TEST_ASSERT_EQUAL_MESSAGE(sim::Detection::kNotAlways, row.fault_injection->detection, error.c_str());
    }
    TEST_ASSERT_EQUAL_MESSAGE(sim::kLaterFaults * row.injection_runs, row.later_faults,
                              row.fault_injection->name.c_str());
    TEST_ASSERT_TRUE_MESSAGE(sim::is_as_stated(row), (row.fault_injection->name + ": change `detection`").c_str());
  }
  for (int fault = 1; fault < FAULT_COUNT; ++fault) {
    TEST_ASSERT_TRUE_MESSAGE(((expected & ~reported) >> fault & 1U) == 0,
                             fmt::format("fault {} is expected, and another one is always reported", fault).c_str());
  }
}

// `sim_host soak --hours 24` does more.
void test_work_with_nothing_broken_trips_nothing() {
  const double hours = 0.1 * by_size(1, 10, 240);
  const sim::SoakResult result = sim::run_soak(tracker_plant(), hours, 1, 2);
  std::printf("%s\n", sim::print_soak(result).c_str());
  TEST_ASSERT_EQUAL(0, result.false_trips.size());
  TEST_ASSERT_TRUE(result.hours >= hours);
}

// The requirements can be violated: an axis without protection violates most of them.
void test_without_protection_the_same_injection_runs_find_it_out() {
  sim::NodeSetup setup(tracker_plant());
  for (protection_limits& limits : setup.limits) {
    limits.encoder_jump_rad = 1.0F;
    limits.base_rate_rad_s = 1e3F;
    limits.stuck_s = 0.0F;
    limits.speed_error_rad_s = 1e3F;
    limits.overspeed_rad_s = 1e3F;
    limits.stall_s = 60.0F;
    limits.motor_tolerance = 0.0F;
    limits.fixed_base_rad = 0.0F;
    limits.encoder_outlier_rad = 0.0F;
  }
  const sim::InjectionRunResult stuck = sim::run_injection_run(
      setup, {&sim::fault_injection("encoder stuck"), sim::Motion::kFast, sim::kAzimuth, 7, true});
  std::printf("an encoder that is stuck and not monitored: %.2f rad/s\n", stuck.speed_most_rad_s);
  TEST_ASSERT_TRUE(stuck.showed);
  TEST_ASSERT_EQUAL(FAULT_NONE, stuck.seen);
}

void test_a_scenario_file_says_what_breaks_when() {
  const sim::FaultScenario scenario = sim::load_fault_scenario("sim_host/scenarios/faults_example.toml");
  const std::string reported = sim::run_fault_scenario(tracker_plant(), scenario);
  std::printf("%s\n", reported.c_str());
  for (const char *line : {"1.200 s  azimuth  encoder lost", "1.200 s  azimuth  fault 1 (0x7320) at ",
                           "1.500 s  pitch    driven against the motor", "pitch    fault 19 (0x7122)", "at rest"}) {
    TEST_ASSERT_TRUE_MESSAGE(reported.find(line) != std::string::npos, line);
  }
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_every_fault_injection_in_every_motion_is_seen_in_time_and_ends_as_promised);
  RUN_TEST(test_work_with_nothing_broken_trips_nothing);
  RUN_TEST(test_without_protection_the_same_injection_runs_find_it_out);
  RUN_TEST(test_a_scenario_file_says_what_breaks_when);
  return UNITY_END();
}
