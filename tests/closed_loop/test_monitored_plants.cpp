// SPDX-License-Identifier: Apache-2.0
// No monitor of the device trips on a machine that is in order; `sim_host soak --random-plants 1000` tries more.
#include "studies/random_plants/monitored_plants.hpp"

#include <cstdio>

#include "support/test_size.h"
#include "unity.h"

namespace sim = trackservo::sim;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

void test_random_machines_trip_nothing() {
  sim::MonitoredPlantsSetup setup;
  setup.nominal = sim::load_plant("sim_host/plants/tracker.toml");
  setup.scenarios = sim::scenarios_of_experiments("sim_host");
  setup.count = by_size(1, 3, 1000);
  setup.threads = 2;
  const sim::MonitoredPlants result = sim::monitor_plants(setup, [](int, int, const std::string&) {});
  std::printf("%s", sim::print(result).c_str());
  TEST_ASSERT_EQUAL(0, result.false_trips.size());
  TEST_ASSERT_EQUAL(0, result.broken_off.size());
  TEST_ASSERT_TRUE(result.experiments > 100 * result.plants && result.hours > 0.3 * result.plants);
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_random_machines_trip_nothing);
  return UNITY_END();
}
