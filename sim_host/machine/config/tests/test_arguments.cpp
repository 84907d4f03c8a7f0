// SPDX-License-Identifier: Apache-2.0
// Arguments of sim_host that parsers accept and that would cost a run, or overwrite the wrong file.
#include <unistd.h>

#include <fstream>

#include "machine/config/arguments.hpp"
#include "support/check.h"

using namespace trackservo::sim;

namespace {

std::filesystem::path folder;

bool says(const std::string& problem, const char *part) { return problem.find(part) != std::string::npos; }

void test_seeds_are_digits_below_2_to_the_64() {
  TEST_ASSERT_EQUAL_STRING("", seed_problem("0").c_str());
  TEST_ASSERT_EQUAL_STRING("", seed_problem("18446744073709551615").c_str());
  for (const char *text : {"-1", "", "1.5", "0x10", "7 ", " 7", "+7", "18446744073709551616", "1e3", "seven"}) {
    TEST_ASSERT_TRUE_MESSAGE(says(seed_problem(text), "expected an integer from 0 to 18446744073709551615"), text);
  }
}

void test_an_output_file_needs_a_folder_and_is_none() {
  TEST_ASSERT_EQUAL_STRING("", output_file_problem(folder / "run.csv").c_str());
  TEST_ASSERT_EQUAL_STRING("", output_file_problem("run.csv").c_str());
  TEST_ASSERT_TRUE(says(output_file_problem(folder), "is a folder"));
  TEST_ASSERT_TRUE(says(output_file_problem(folder / ""), "is a folder"));
  TEST_ASSERT_TRUE(says(output_file_problem(folder / "none" / "run.csv"), "does not exist"));
  TEST_ASSERT_FALSE_MESSAGE(std::filesystem::exists(folder / "run.csv"), "looking must not make the file");
}

void test_an_output_folder_is_made_where_it_can_be() {
  TEST_ASSERT_EQUAL_STRING("", output_folder_problem(folder / "a" / "b").c_str());
  TEST_ASSERT_TRUE(std::filesystem::is_directory(folder / "a" / "b"));
  std::ofstream(folder / "file") << "text";
  TEST_ASSERT_TRUE(says(output_folder_problem(folder / "file"), "cannot be created as a folder"));
  TEST_ASSERT_TRUE(says(output_folder_problem(folder / "file" / "sub"), "cannot be created as a folder"));
  TEST_ASSERT_TRUE(says(output_folder_problem(""), "is not a folder"));
}

// Root can write everywhere: then there is nothing to test.
void test_places_without_permission_are_refused() {
  if (geteuid() == 0) {
    TEST_MESSAGE("run as root, who may write everywhere: nothing to see");
    return;
  }
  std::filesystem::permissions(folder, std::filesystem::perms::owner_read | std::filesystem::perms::owner_exec);
  TEST_ASSERT_TRUE(says(output_file_problem(folder / "run.csv"), "cannot be written"));
  TEST_ASSERT_TRUE(says(output_folder_problem(folder), "cannot be written"));
  std::filesystem::permissions(folder, std::filesystem::perms::owner_all);
}

}  // namespace

extern "C" void setUp(void) {
  folder = std::filesystem::temp_directory_path() / ("trackservo_arguments_" + std::to_string(getpid()));
  std::filesystem::create_directories(folder);
}

extern "C" void tearDown(void) { std::filesystem::remove_all(folder); }

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_seeds_are_digits_below_2_to_the_64);
  RUN_TEST(test_an_output_file_needs_a_folder_and_is_none);
  RUN_TEST(test_an_output_folder_is_made_where_it_can_be);
  RUN_TEST(test_places_without_permission_are_refused);
  return UNITY_END();
}
