// SPDX-License-Identifier: Apache-2.0
// Progress of a long job for people and logs: nothing is rewritten in a file, and there is always output.
#include "machine/base/progress.hpp"

#include <algorithm>
#include <string>
#include <vector>

#include "support/check.h"

extern "C" void setUp(void) {}
extern "C" void tearDown(void) {}

namespace {

using trackservo::sim::duration_words;
using trackservo::sim::ProgressPrinter;

struct Step {
  double time_s;
  int done;
  const char *what;
};

// Output of a printer for jobs that end at given times, of 100 units of work.
std::string printed(bool is_terminal, const std::vector<Step>& steps) {
  std::FILE *file = std::tmpfile();
  TEST_ASSERT_NOT_NULL(file);
  double now_s = 0.0;
  ProgressPrinter printer(file, is_terminal, [&] { return now_s; });
  for (const Step& step : steps) {
    now_s = step.time_s;
    printer.show(step.done, 100, step.what);
  }
  std::string text(static_cast<std::size_t>(std::ftell(file)), '\0');
  std::rewind(file);
  TEST_ASSERT_EQUAL_UINT(text.size(), std::fread(text.data(), 1, text.size(), file));
  (void)std::fclose(file);
  return text;
}

void test_a_file_gets_a_line_per_finished_part_with_the_time_left() {
  TEST_ASSERT_EQUAL_STRING(
      "[ 30 %] a: done; about 9 s left\n"
      "[ 60 %] b: done; about 4 s left\n"
      "[100 %] c: done; took 9 s\n",
      printed(false, {{2, 20, "a"}, {4, 30, "b"}, {5, 50, "b"}, {6, 60, "c"}, {9, 100, "c"}}).c_str());
}

void test_a_file_is_never_silent_for_long() {
  TEST_ASSERT_EQUAL_STRING(
      "[ 10 %] a; about 1 min 40 s left\n"
      "[ 25 %] a; about 65 s left\n"
      "[100 %] a: done; took 30 s\n",
      printed(false, {{11, 10, "a"}, {15, 20, "a"}, {22, 25, "a"}, {30, 100, "a"}}).c_str());
}

void test_threads_that_finish_jobs_of_two_parts_in_turn_do_not_repeat_a_line() {
  TEST_ASSERT_EQUAL_STRING(
      "[ 20 %] a: done; about 8 s left\n[100 %] b: done; took 5 s\n",
      printed(false, {{1, 10, "a"}, {2, 20, "b"}, {3, 30, "a"}, {4, 40, "b"}, {5, 100, "b"}}).c_str());
}

void test_a_second_piece_of_work_starts_from_zero() {
  TEST_ASSERT_EQUAL_STRING("[100 %] a: done; took 50 s\n[100 %] b: done; took 5 s\n",
                           printed(false, {{50, 100, "a"}, {60, 50, "b"}, {65, 100, "b"}}).c_str());
}

void test_a_terminal_rewrites_one_line() {
  const std::string text = printed(true, {{2, 20, "a"}, {4, 40, "b"}, {10, 100, "b"}});
  TEST_ASSERT_EQUAL_INT(3, std::count(text.begin(), text.end(), '\r'));
  TEST_ASSERT_EQUAL_INT(1, std::count(text.begin(), text.end(), '\n'));
  TEST_ASSERT_TRUE(text.find("about 8 s left") != std::string::npos);
}

void test_durations_are_as_exact_as_an_estimate() {
  TEST_ASSERT_EQUAL_STRING("1 s", duration_words(0.3).c_str());
  TEST_ASSERT_EQUAL_STRING("40 s", duration_words(41.0).c_str());
  TEST_ASSERT_EQUAL_STRING("2 min", duration_words(121.0).c_str());
  TEST_ASSERT_EQUAL_STRING("3 min 20 s", duration_words(201.0).c_str());
  TEST_ASSERT_EQUAL_STRING("2 h 05 min", duration_words(7500.0).c_str());
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_a_file_gets_a_line_per_finished_part_with_the_time_left);
  RUN_TEST(test_a_file_is_never_silent_for_long);
  RUN_TEST(test_threads_that_finish_jobs_of_two_parts_in_turn_do_not_repeat_a_line);
  RUN_TEST(test_a_second_piece_of_work_starts_from_zero);
  RUN_TEST(test_a_terminal_rewrites_one_line);
  RUN_TEST(test_durations_are_as_exact_as_an_estimate);
  return UNITY_END();
}
