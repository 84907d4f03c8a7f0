// SPDX-License-Identifier: Apache-2.0
// Requirements beside measured values: the worst seed decides, and the rows of a study replace its own in results.json.
#include "studies/shared/requirement.hpp"

#include <filesystem>
#include <fstream>
#include <limits>
#include <nlohmann/json.hpp>
#include <stdexcept>

#include "support/check.h"

extern "C" void setUp(void) {}
extern "C" void tearDown(void) {}

namespace {

using namespace trackservo::sim;

constexpr double kNever = std::numeric_limits<double>::infinity();

nlohmann::json read(const std::filesystem::path& file) {
  std::ifstream stream(file);
  return nlohmann::json::parse(stream);
}

std::filesystem::path folder_with(const std::string& text) {
  const std::filesystem::path folder = std::filesystem::temp_directory_path() / "trackservo_test_requirement";
  std::filesystem::remove_all(folder);
  std::filesystem::create_directories(folder);
  if (!text.empty()) {
    std::ofstream(folder / "results.json") << text;
  }
  return folder;
}

void test_the_worst_seed_decides() {
  const Requirement upper{"fly-by", "pitch", "sigma", "urad", 3.0, {2.0, 3.0}};
  CHECK_SAME("largest", 3.0, worst_of(upper));
  TEST_ASSERT_TRUE(is_met(upper));
  TEST_ASSERT_EQUAL_STRING("<= 3", goal_text(upper).c_str());
  Requirement lower{"isolation", "", "isolation", "dB", 40.0, {41.0, 39.9}, Bound::kAtLeast};
  CHECK_SAME("smallest", 39.9, worst_of(lower));
  TEST_ASSERT_FALSE(is_met(lower));
  TEST_ASSERT_EQUAL_STRING(">= 40", goal_text(lower).c_str());
}

void test_what_never_came_and_what_is_no_number_miss_every_requirement() {
  TEST_ASSERT_FALSE(is_met({"pass", "", "time_lost", "s", 1.2, {0.5, kNever}}));
  TEST_ASSERT_FALSE(is_met({"pass", "", "sigma", "urad", 1.2, {std::numeric_limits<double>::quiet_NaN()}}));
}

void test_a_study_replaces_its_own_rows_only() {
  const auto folder = folder_with(R"({"rows": [1], "requirements": []})");
  TEST_ASSERT_TRUE(
      record_requirements({"sim_host a", "abc", "tracker"}, {{"x", "", "sigma", "urad", 1.0, {0.5}}}, folder));
  TEST_ASSERT_TRUE(
      record_requirements({"sim_host b", "abc", "tracker"}, {{"y", "", "time_lost", "s", 1.0, {kNever}}}, folder));
  TEST_ASSERT_TRUE(
      record_requirements({"sim_host a", "abc", "tracker"}, {{"x", "azimuth", "sigma", "urad", 1.0, {2.0}}}, folder));
  const nlohmann::json results = read(folder / "results.json");
  TEST_ASSERT_EQUAL(1, results["rows"][0].get<int>());
  TEST_ASSERT_EQUAL(2, results["requirements"].size());
  const nlohmann::json& never = results["requirements"][0];
  TEST_ASSERT_TRUE(never["value"].is_null() && never["axis"].is_null() && !never["met"].get<bool>());
  const nlohmann::json& again = results["requirements"][1];
  TEST_ASSERT_EQUAL_STRING("sim_host a", again["command"].get<std::string>().c_str());
  CHECK_SAME("value", 2.0, again["value"].get<double>());
  TEST_ASSERT_EQUAL_STRING("azimuth", again["axis"].get<std::string>().c_str());
}

void test_results_in_another_encoding_are_read() {
  const auto folder = folder_with("\xEF\xBB\xBF{\"requirements\": []}\r\n");
  TEST_ASSERT_TRUE(
      record_requirements({"sim_host a", "abc", "tracker"}, {{"x", "", "sigma", "urad", 1.0, {0.5}}}, folder));
  TEST_ASSERT_EQUAL(1, read(folder / "results.json")["requirements"].size());
}

void test_what_is_no_json_is_named_with_its_line() {
  const auto folder = folder_with("{\"requirements\":\n [1e400]}\n");
  try {
    record_requirements({"sim_host a", "abc", "tracker"}, {}, folder);
    TEST_FAIL_MESSAGE("it was not refused");
  } catch (const std::runtime_error& error) {
    TEST_ASSERT_TRUE(std::string(error.what()).find("results.json:2: ") != std::string::npos);
  }
}

void test_without_results_nothing_is_written() {
  const auto folder = folder_with("");
  TEST_ASSERT_FALSE(record_requirements({"sim_host a", "abc", "tracker"}, {}, folder));
  TEST_ASSERT_FALSE(std::filesystem::exists(folder / "results.json"));
}

void test_a_file_of_something_else_is_refused_and_stays() {
  for (const char *text : {"no json", "[]", R"({"rows": []})"}) {
    const auto folder = folder_with(text);
    try {
      record_requirements({"sim_host a", "abc", "tracker"}, {}, folder);
      TEST_FAIL_MESSAGE("it was not refused");
    } catch (const std::runtime_error& error) {
      TEST_ASSERT_TRUE(std::string(error.what()).find("run sim_host experiments") != std::string::npos);
    }
    std::ifstream stream(folder / "results.json");
    std::string kept;
    std::getline(stream, kept);
    TEST_ASSERT_EQUAL_STRING(text, kept.c_str());
  }
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_the_worst_seed_decides);
  RUN_TEST(test_what_never_came_and_what_is_no_number_miss_every_requirement);
  RUN_TEST(test_a_study_replaces_its_own_rows_only);
  RUN_TEST(test_results_in_another_encoding_are_read);
  RUN_TEST(test_what_is_no_json_is_named_with_its_line);
  RUN_TEST(test_without_results_nothing_is_written);
  RUN_TEST(test_a_file_of_something_else_is_refused_and_stays);
  return UNITY_END();
}
