// A campaign that is interrupted and continued has the results of one that runs through.
#include "attack/attack_log.hpp"

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <stdexcept>

#include "attack/attack_campaign.hpp"
#include "unity.h"

namespace sim = trackservo::sim;

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

const sim::AttackLogOrigin kOrigin{"1234567", "tracker.toml"};

const sim::AttackBench& bench() {
  static const sim::AttackBench made(sim::load_plant("sim_host/plants/tracker.toml"));
  return made;
}

std::filesystem::path new_file(const std::string& name) {
  const std::filesystem::path file = std::filesystem::temp_directory_path() / ("test_attack_log_" + name + ".csv");
  std::filesystem::remove(file);
  return file;
}

sim::AttackCampaign run(std::uint64_t first, std::uint64_t seeds, const std::filesystem::path& log) {
  sim::AttackOptions options;
  options.first_seed = first;
  options.seeds = seeds;
  options.threads = 1;
  options.log = log;
  options.origin = kOrigin;
  return sim::run_attacks(bench(), options, [](int, int, const std::string&) {});
}

std::vector<std::uint64_t> seeds_in(const std::filesystem::path& file) {
  std::vector<std::uint64_t> seeds;
  const sim::AttackLog log(file, kOrigin, [&](const sim::AttackResult& one) { seeds.push_back(one.seed); });
  return seeds;
}

std::string text_of(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

std::string error_of(const std::filesystem::path& file, const sim::AttackLogOrigin& origin) {
  try {
    const sim::AttackLog log(file, origin, [](const sim::AttackResult&) {});
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

// What makes a difference in each column.
sim::AttackResult full_result() {
  sim::AttackResult result;
  result.seed = 18446744073709551615U;
  result.theme = sim::Theme::kStorage;
  result.narrow = true;
  result.harm.not_finite = true;
  result.answers = false;
  result.writes = 321;
  result.refusals = 12;
  result.harm.axis[sim::kAzimuth] = {{3, 0.1, 1.0 / 3.0, 4e2, 5.5}, 1.25, sim::Runaway::kTooFast, 2.5};
  result.harm.axis[sim::kPitch] = {{4, 1e-9, 7.25, 8.0, 9.0}, 10.0, sim::Runaway::kNotStopped, 11.0};
  return result;
}

void test_every_value_of_a_result_comes_back() {
  const std::filesystem::path file = new_file("values");
  const sim::AttackResult wrote = full_result();
  sim::AttackLog(file, kOrigin, [](const sim::AttackResult&) {}).append({wrote, wrote});
  const std::string text = text_of(file);
  int results = 0;
  sim::AttackLog log(file, kOrigin, [&](const sim::AttackResult& read) {
    ++results;
    TEST_ASSERT_TRUE(read.seed == wrote.seed && read.theme == wrote.theme && read.narrow == wrote.narrow);
    TEST_ASSERT_TRUE(read.writes == wrote.writes && read.refusals == wrote.refusals);
    TEST_ASSERT_TRUE(read.answers == wrote.answers && read.harm.not_finite == wrote.harm.not_finite);
    for (std::size_t i = 0; i < sim::kAxes; ++i) {
      const sim::AxisHarm& a = read.harm.axis[i];
      const sim::AxisHarm& b = wrote.harm.axis[i];
      TEST_ASSERT_TRUE(a.contacts.count == b.contacts.count && a.contacts.speed_rad_s == b.contacts.speed_rad_s);
      TEST_ASSERT_TRUE(a.contacts.energy_j == b.contacts.energy_j && a.contacts.torque_nm == b.contacts.torque_nm);
      TEST_ASSERT_TRUE(a.contacts.first_time_s == b.contacts.first_time_s && a.max_rate_rad_s == b.max_rate_rad_s);
      TEST_ASSERT_TRUE(a.runaway == b.runaway && a.runaway_time_s == b.runaway_time_s);
    }
  });
  TEST_ASSERT_EQUAL(2, results);
  log.append({});
  TEST_ASSERT_EQUAL_STRING(text.c_str(), text_of(file).c_str());
}

void test_a_continued_campaign_equals_one_that_runs_through() {
  const std::filesystem::path file = new_file("continued");
  const sim::AttackCampaign through = run(1, 6, {});
  (void)run(2, 3, file);
  const sim::AttackCampaign continued = run(1, 6, file);
  TEST_ASSERT_EQUAL_STRING(sim::print(through).c_str(), sim::print(continued).c_str());
  const std::vector<std::uint64_t> seeds = seeds_in(file);
  const std::vector<std::uint64_t> expected = {2, 3, 4, 1, 5, 6};
  TEST_ASSERT_TRUE(seeds == expected);
  (void)run(1, 6, file);  // nothing is left to do
  TEST_ASSERT_TRUE(seeds_in(file) == expected);
}

// At any byte.
void test_a_file_that_a_killed_process_has_left_is_continued() {
  const std::filesystem::path file = new_file("killed");
  sim::AttackResult first = full_result();
  first.seed = 1;
  sim::AttackResult second = full_result();
  second.seed = 2;
  sim::AttackLog(file, kOrigin, [](const sim::AttackResult&) {}).append({first, second});
  const std::string whole = text_of(file);
  for (std::size_t size = 0; size < whole.size(); ++size) {
    std::ofstream(file, std::ios::binary | std::ios::trunc) << whole.substr(0, size);
    const std::size_t lines = static_cast<std::size_t>(std::count(whole.begin(), whole.begin() + size, '\n'));
    TEST_ASSERT_EQUAL(lines < 2 ? 0 : lines - 2, seeds_in(file).size());
    sim::AttackLog(file, kOrigin, [](const sim::AttackResult&) {}).append({second});
    TEST_ASSERT_EQUAL(lines < 2 ? 1 : lines - 1, seeds_in(file).size());
  }
}

void test_a_file_of_something_else_is_refused_and_left_alone() {
  const std::filesystem::path file = new_file("other");
  sim::AttackLog(file, kOrigin, [](const sim::AttackResult&) {}).append({full_result()});
  const std::string whole = text_of(file);
  TEST_ASSERT_TRUE(error_of(file, {"7654321", "tracker.toml"}).find("commit 7654321, plant tracker.toml") !=
                   std::string::npos);
  TEST_ASSERT_TRUE(error_of(file, {"1234567", "mine.toml"}).find("give another file") != std::string::npos);
  TEST_ASSERT_EQUAL_STRING(whole.c_str(), text_of(file).c_str());
  const std::string wrong = whole + "1,2,3\n";
  std::ofstream(file, std::ios::binary | std::ios::trunc) << wrong;
  TEST_ASSERT_TRUE(error_of(file, kOrigin).find("line 4 is not a result") != std::string::npos);
  TEST_ASSERT_EQUAL_STRING(wrong.c_str(), text_of(file).c_str());
  std::ofstream(file, std::ios::binary | std::ios::trunc) << "my notes\n";
  TEST_ASSERT_FALSE(error_of(file, kOrigin).empty());
  TEST_ASSERT_EQUAL_STRING("my notes\n", text_of(file).c_str());
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_every_value_of_a_result_comes_back);
  RUN_TEST(test_a_continued_campaign_equals_one_that_runs_through);
  RUN_TEST(test_a_file_that_a_killed_process_has_left_is_continued);
  RUN_TEST(test_a_file_of_something_else_is_refused_and_left_alone);
  return UNITY_END();
}
