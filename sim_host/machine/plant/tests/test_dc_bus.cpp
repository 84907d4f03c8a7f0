// SPDX-License-Identifier: Apache-2.0
// The bus of the bridges: a stiff supply, a capacitor that takes returned current, a brake resistor.
#include <cmath>

#include "machine/plant/dc_bus.hpp"
#include "unity.h"

namespace sim = trackservo::sim;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

constexpr double kStep_s = sim::kPwmPeriod_s;

sim::SupplyConfig with_capacitor() {
  sim::SupplyConfig supply;
  supply.voltage_v = 48.0;
  supply.source_resistance_ohm = 0.05;
  supply.capacitance_f = 2e-3;
  return supply;
}

void run(sim::DcBus& bus, double drawn_a, double seconds) {
  for (int i = 0; i < static_cast<int>(std::lround(seconds / kStep_s)); ++i) {
    bus.step(drawn_a);
  }
}

void test_without_a_capacitor_the_supply_takes_current_too() {
  sim::SupplyConfig supply = with_capacitor();
  supply.capacitance_f = 0.0;
  sim::DcBus bus(supply, kStep_s);
  bus.step(-10.0);
  TEST_ASSERT_EQUAL_DOUBLE(48.5, bus.voltage_v());
  bus.step(16.0);
  TEST_ASSERT_EQUAL_DOUBLE(47.2, bus.voltage_v());
}

void test_with_a_capacitor_a_load_settles_at_the_same_voltage() {
  sim::DcBus bus(with_capacitor(), kStep_s);
  run(bus, 16.0, 0.01);
  TEST_ASSERT_DOUBLE_WITHIN(1e-6, 47.2, bus.voltage_v());
}

void test_returned_charge_stays_in_the_capacitor() {
  sim::DcBus bus(with_capacitor(), kStep_s);
  run(bus, -4.0, 0.005);  // 20 mC
  TEST_ASSERT_DOUBLE_WITHIN(1e-6, 58.0, bus.voltage_v());
  run(bus, 0.0, 1.0);
  TEST_ASSERT_DOUBLE_WITHIN(1e-6, 58.0, bus.voltage_v());
  run(bus, 4.0, 0.01);
  TEST_ASSERT_DOUBLE_WITHIN(1e-3, 47.8, bus.voltage_v());
}

void test_an_old_capacitor_rises_further() {
  sim::DcBus bus(with_capacitor(), kStep_s);
  bus.age_capacitor(0.5);
  run(bus, -4.0, 0.005);
  TEST_ASSERT_DOUBLE_WITHIN(1e-6, 68.0, bus.voltage_v());
}

void test_the_brake_resistor_limits_the_voltage() {
  sim::SupplyConfig supply = with_capacitor();
  supply.brake_resistor_ohm = 5.0;
  supply.brake_resistor_v = 55.0;
  sim::DcBus bus(supply, kStep_s);
  double highest_v = 0.0;
  for (int i = 0; i < 20000; ++i) {
    bus.step(-8.0);  // the resistor takes 11 A
    highest_v = std::fmax(highest_v, bus.voltage_v());
  }
  TEST_ASSERT_TRUE(highest_v > 55.0 && highest_v < 55.5);
  TEST_ASSERT_TRUE(bus.voltage_v() > 53.5);
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_without_a_capacitor_the_supply_takes_current_too);
  RUN_TEST(test_with_a_capacitor_a_load_settles_at_the_same_voltage);
  RUN_TEST(test_returned_charge_stays_in_the_capacitor);
  RUN_TEST(test_an_old_capacitor_rises_further);
  RUN_TEST(test_the_brake_resistor_limits_the_voltage);
  return UNITY_END();
}
