// SPDX-License-Identifier: Apache-2.0
// The core against the architecture manual: small programs (probes/*.c) record their events.
#include <initializer_list>

#include "probe_bench.hpp"
#include "unity.h"

using bench::ProbeBench;

void setUp(void) {}
void tearDown(void) {}

namespace {

constexpr std::uint32_t kEnd = 0xE0D;

void expect_notes(ProbeBench& probe, std::initializer_list<std::uint32_t> expected) {
  const std::vector<std::uint32_t> notes = probe.run();
  for (const std::string& violation : probe.violations.list()) {
    TEST_MESSAGE(violation.c_str());
  }
  TEST_ASSERT_EQUAL_UINT(0, probe.violations.list().size());
  TEST_ASSERT_EQUAL_UINT(expected.size(), notes.size());
  TEST_ASSERT_EQUAL_HEX32_ARRAY(expected.begin(), notes.data(), notes.size());
}

void test_interrupts_nest_by_priority_and_wait_behind_masks() {
  ProbeBench probe("nesting");
  expect_notes(probe, {0x10, 0x20, 0x31, 0x2F, 0x40, 0x1F,  // irq0, irq1, irq2; irq3 chained after irq1
                       0x01, 0x02, 0x40, 0x03,              // PRIMASK
                       0x04, 0x31, 0x05, 0x40, 0x06,        // BASEPRI
                       kEnd});
  TEST_ASSERT_EQUAL_INT(0, probe.exceptions.nesting());
}

void test_an_interrupt_leaves_the_float_registers_alone() {
  ProbeBench probe("floats");
  expect_notes(probe, {0x11, 9, 8, kEnd});
}

void test_faults_reach_their_handler_or_escalate() {
  ProbeBench probe("faults");
  expect_notes(probe, {0x50, 7,                       // SVC
                       0xB0, 0x8200, 0x30000000,      // PRECISERR, BFARVALID, and the address
                       0xF0, 0x00010000, 0x40000000,  // UNDEFINSTR, FORCED
                       0xF0, 0x00000000, 0x40000000,  // an SVC that could not be taken
                       0x99, kEnd});
}

void test_a_guarded_address_is_a_memory_fault_and_others_are_not() {
  ProbeBench probe("guard");
  expect_notes(probe, {0xA0, 0x82, 0x1FFFFFF0,    // DACCVIOL, MMARVALID, and the address
                       0xB0, 0x8200, 0x1FFF7FF0,  // below the region: PRECISERR, BFARVALID
                       0xB0, 0x8200, 0x1FFFFFF0,  // MPU off
                       kEnd});
}

void test_a_fault_in_the_fault_handler_locks_up() {
  ProbeBench probe("lock_up");
  expect_notes(probe, {0xF0});
  TEST_ASSERT_TRUE(probe.core.is_locked_up());
}

void test_time_is_the_documented_estimate() {
  ProbeBench probe("timing");
  const std::vector<std::uint32_t> notes = probe.run();
  TEST_ASSERT_EQUAL_UINT(3, notes.size());
  // A hundred times SUBS, NOP, BNE taken (1 + 1 + 1 + 2), and the instructions around the loop.
  TEST_ASSERT_UINT_WITHIN(10, 500, notes[0]);
  TEST_ASSERT_UINT_WITHIN(60, 10000, notes[1]);
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_interrupts_nest_by_priority_and_wait_behind_masks);
  RUN_TEST(test_an_interrupt_leaves_the_float_registers_alone);
  RUN_TEST(test_faults_reach_their_handler_or_escalate);
  RUN_TEST(test_a_guarded_address_is_a_memory_fault_and_others_are_not);
  RUN_TEST(test_a_fault_in_the_fault_handler_locks_up);
  RUN_TEST(test_time_is_the_documented_estimate);
  return UNITY_END();
}
