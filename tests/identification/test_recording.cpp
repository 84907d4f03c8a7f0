// SPDX-License-Identifier: Apache-2.0
// The required form of a recording, and the messages for errors.
#include <sstream>
#include <string>

#include "identification/recording.hpp"
#include "unity.h"

namespace identification = trackservo::identification;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

const std::string kHeader = std::string(identification::kRecordingHeader) + "\n";

identification::Recording read(const std::string& text) {
  std::istringstream input(text);
  return identification::read_recording(input, "runs.csv");
}

void expect_refusal(const std::string& text, const char *beginning, const char *advice) {
  try {
    (void)read(text);
  } catch (const identification::RecordingError& error) {
    const std::string message = error.what();
    TEST_ASSERT_EQUAL_STRING(beginning, message.substr(0, std::string(beginning).size()).c_str());
    TEST_ASSERT_TRUE_MESSAGE(message.find(advice) != std::string::npos, message.c_str());
    return;
  }
  TEST_FAIL_MESSAGE("was read");
}

void test_rows_are_read_and_a_gap_begins_a_new_stretch() {
  const identification::Recording recording = read(kHeader +
                                                   "0.000,1,1,0.1,0.5,0.51,2.5,0.5\n"
                                                   "0.001,1,1,0.1005,0.5,,2.5,0.5\n"
                                                   "0.500,2,3,0.2,0.5,nan,-1e-3,0\n"
                                                   "0.501,2,3,0.2005,0.5,0.5,1,0\n");
  TEST_ASSERT_EQUAL(4, recording.ticks());
  TEST_ASSERT_EQUAL_DOUBLE(-1e-3, recording.torque_nm[2]);
  TEST_ASSERT_FALSE(recording.has_gyro());
  TEST_ASSERT_TRUE(recording.has(identification::RunKind::kHysteresis));
  TEST_ASSERT_FALSE(recording.has(identification::RunKind::kBreakaway));
  const auto stretches = identification::stretches(recording);
  TEST_ASSERT_EQUAL(2, stretches.size());
  TEST_ASSERT_EQUAL(2, stretches[1].first);
  TEST_ASSERT_EQUAL(4, stretches[1].last);
}

void test_a_wrong_header_is_shown_with_the_right_one() {
  expect_refusal("time,angle\n", "runs.csv:1: the first line is 'time,angle'", "it must be 'time_s,run,kind,");
  expect_refusal("", "runs.csv:1: ", "it must be 'time_s,run,kind,");
}

void test_a_wrong_value_is_named_with_its_line_and_column() {
  const std::string good = kHeader + "0.000,1,1,0.1,0.5,0.51,2.5,0.5\n";
  expect_refusal(good + "0.001,1,1,0.1005,fast,0.5,2.5,0.5\n", "runs.csv:3: joint_rate_rad_s is 'fast'",
                 "finite decimal number");
  expect_refusal(good + "0.001,1,1,0.1005,0.5,0.5,inf,0.5\n", "runs.csv:3: torque_nm is 'inf'", "finite");
  expect_refusal(good + "0.001,1,1,nan,0.5,0.5,1,0.5\n", "runs.csv:3: joint_angle_rad is 'nan'", "finite");
  expect_refusal(good + "0.001,1,7,0.1005,0.5,0.5,1,0.5\n", "runs.csv:3: kind is 7", "a whole number 1..5");
  expect_refusal(good + "0.001,1,1,0.1005,0.5\n", "runs.csv:3: this row has 5 values", "it must have 8");
  expect_refusal(good + "0.001,1,1,0.1005,0.5,0.5,1,0.5,9\n", "runs.csv:3: this row has 9 values", "it must have 8");
}

void test_time_and_runs_that_go_back_are_refused() {
  const std::string good = kHeader + "0.100,2,1,0.1,0.5,0.51,2.5,0.5\n";
  expect_refusal(good + "0.100,2,1,0.1,0.5,0.5,1,0.5\n", "runs.csv:3: time_s advances by 0 s",
                 "0.001 s apart, or separated by a gap");
  expect_refusal(good + "0.101,1,1,0.1,0.5,0.5,1,0.5\n", "runs.csv:3: run decreases from 2 to 1", "it must increase");
}

void test_degrees_beside_radians_are_noticed() {
  std::string text = kHeader;
  for (int tick = 0; tick < 100; ++tick) {
    text += std::to_string(tick * 1e-3) + ",1,1," + std::to_string(0.5e-3 * tick) + ",28.6,28.6,1,0.5\n";
  }
  expect_refusal(text, "runs.csv: joint_rate_rad_s is 57.2 times", "both must be in rad");
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_rows_are_read_and_a_gap_begins_a_new_stretch);
  RUN_TEST(test_a_wrong_header_is_shown_with_the_right_one);
  RUN_TEST(test_a_wrong_value_is_named_with_its_line_and_column);
  RUN_TEST(test_time_and_runs_that_go_back_are_refused);
  RUN_TEST(test_degrees_beside_radians_are_noticed);
  return UNITY_END();
}
