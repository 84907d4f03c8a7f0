// SPDX-License-Identifier: Apache-2.0
// Every fault of the table is caused by some test, and the named tests exist.
#include <fmt/format.h>

#include <algorithm>
#include <fstream>
#include <iterator>

#include "judge/fault_injection/fault_account.hpp"
#include "unity.h"

namespace sim = trackservo::sim;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

std::string contents(const std::string& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

bool is_in_a_list(fault_id fault) {
  const auto& tests = sim::fault_tests();
  return std::any_of(tests.begin(), tests.end(), [fault](const sim::FaultTest& one) { return one.fault == fault; });
}

void test_every_fault_is_broken_in_the_simulator_or_in_a_test_that_is_named() {
  for (int i = FAULT_NONE + 1; i < FAULT_COUNT; ++i) {
    const auto fault = static_cast<fault_id>(i);
    TEST_ASSERT_TRUE_MESSAGE(!sim::fault_injections_of(fault).empty() || is_in_a_list(fault),
                             fmt::format("nothing tries fault {}", i).c_str());
  }
}

void test_every_test_that_is_named_is_run() {
  for (const sim::FaultTest& one : sim::fault_tests()) {
    TEST_ASSERT_TRUE_MESSAGE(contents(one.file).find("RUN_TEST(" + one.test + ")") != std::string::npos,
                             (one.file + ": " + one.test).c_str());
  }
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_every_fault_is_broken_in_the_simulator_or_in_a_test_that_is_named);
  RUN_TEST(test_every_test_that_is_named_is_run);
  return UNITY_END();
}
