// SPDX-License-Identifier: Apache-2.0
// Random plants in pieces: interrupted and continued, or on several machines, they give the results of one run.
#include "studies/random_plants/random_plants_log.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>
#include <sstream>
#include <stdexcept>

#include "bench.hpp"
#include "judge/analysis/statistics.hpp"
#include "studies/random_plants/random_plant.hpp"
#include "studies/random_plants/random_plants_report.hpp"
#include "unity.h"

extern "C" void setUp() {}
extern "C" void tearDown() {}

namespace {

using namespace trackservo::sim;

// One speed for a second: a plant takes some hundredths of a second.
RandomPlantsSetup setup_of(std::uint64_t first, std::uint64_t count, const std::filesystem::path& log = {}) {
  RandomPlantsSetup setup;
  setup.study = bench::study("steady_speed", "tracker");
  setup.study.scenario.speeds_rad_s = {1.0 * bench::kRadPerDeg};
  setup.study.scenario.settle_s = 0.5;
  setup.study.scenario.duration_s = setup.study.scenario.rest_s + 1.0;
  setup.paper = experiment_named("steady_speed", load_experiments("sim_host")).paper;
  setup.seed = first;
  setup.count = count;
  setup.threads = 1;
  setup.log = log;
  setup.origin = {"1234567", "tracker.toml", "00000001", "00000002"};
  return setup;
}

TriedPlant refuse(const RandomPlantsSetup&, const servo_params&, std::uint64_t seed) {
  throw std::invalid_argument("the firmware refuses \"" + std::to_string(seed) + "\"\n");
}

std::filesystem::path folder(const std::string& name) {
  const std::filesystem::path made = std::filesystem::temp_directory_path() / ("test_random_plants_log_" + name);
  std::filesystem::remove_all(made);
  std::filesystem::create_directories(made);
  return made;
}

std::string text_of(const std::filesystem::path& file) {
  std::ostringstream text;
  text << std::ifstream(file, std::ios::binary).rdbuf();
  return text.str();
}

void write(const std::filesystem::path& file, const std::string& text) {
  std::ofstream(file, std::ios::binary | std::ios::trunc) << text;
}

RandomPlants run(const RandomPlantsSetup& setup, const TryPlant& try_one = try_plant) {
  return try_random_plants(
      setup, [](int, int, const std::string&) {}, try_one);
}

// The contents of both result files.
std::string files_of(const RandomPlants& tried) {
  const std::filesystem::path out = folder("out");
  write_random_plants(tried, summary_of(tried), "1234567", out);
  return text_of(out / "random_plants.json") + text_of(out / "random_plants.csv");
}

std::string merge_error(const std::vector<std::filesystem::path>& logs, const RandomPlantsSetup& setup,
                        bool all_of_setup) {
  try {
    (void)merge_random_plants(setup, logs, all_of_setup);
  } catch (const std::runtime_error& error) {
    return error.what();
  }
  return "";
}

void check_says(const std::string& text, const std::string& part) {
  TEST_ASSERT_TRUE_MESSAGE(text.find(part) != std::string::npos, (part + " in: " + text).c_str());
}

void test_every_value_of_a_plant_comes_back() {
  TriedPlant wrote;
  wrote.seed = 18446744073709551615U;
  wrote.axis[kAzimuth] = {{1.0 / 3.0, 1e-300}, 0.1, std::numeric_limits<double>::infinity(), 41.5, false, true};
  wrote.axis[kPitch] = {{-0.0, std::numeric_limits<double>::quiet_NaN()}, 2e10, 7.0, -3.25, true, false};
  const std::string line = line_of(wrote);
  const auto read = std::get<TriedPlant>(*result_of(line.substr(0, line.size() - 1), 2));
  TEST_ASSERT_EQUAL_STRING(line.c_str(), line_of(read).c_str());
  TEST_ASSERT_TRUE(read.seed == wrote.seed);
  TEST_ASSERT_TRUE(read.axis[kAzimuth].peak_error_deg_s == wrote.axis[kAzimuth].peak_error_deg_s);
  TEST_ASSERT_TRUE(!read.axis[kAzimuth].stable && !read.axis[kPitch].stable_at_zenith);
  TEST_ASSERT_TRUE(read.axis[kAzimuth].gain_margin_db == wrote.axis[kAzimuth].gain_margin_db);
  TEST_ASSERT_FALSE(result_of(line.substr(0, line.size() - 1), 3));
  TEST_ASSERT_FALSE(result_of(line.substr(0, line.size() - 3), 2));
}

void test_a_run_that_is_continued_equals_one_that_runs_through() {
  const std::filesystem::path log = folder("continued") / "log.csv";
  const std::string through = files_of(run(setup_of(1, 6)));
  (void)run(setup_of(3, 2, log));
  const std::string two = text_of(log);
  RandomPlantsSetup rest = setup_of(1, 6, log);
  rest.threads = 3;
  TEST_ASSERT_EQUAL_STRING(through.c_str(), files_of(run(rest)).c_str());
  TEST_ASSERT_EQUAL_STRING(two.c_str(), text_of(log).substr(0, two.size()).c_str());  // not run again
  const std::string whole = text_of(log);
  TEST_ASSERT_EQUAL(8, std::count(whole.begin(), whole.end(), '\n'));
  write(log, whole.substr(0, whole.size() - 20));  // killed within its last line
  TEST_ASSERT_EQUAL_STRING(through.c_str(), files_of(run(rest)).c_str());
  TEST_ASSERT_EQUAL_STRING(whole.c_str(), text_of(log).c_str());
}

void test_shards_give_the_files_of_one_run_in_any_order() {
  const std::filesystem::path in = folder("shards");
  const std::string through = files_of(run(setup_of(1, 6)));
  (void)run(setup_of(1, 2, in / "a.csv"));
  (void)run(setup_of(3, 4, in / "b.csv"));
  const RandomPlantsSetup any = setup_of(1, 2);
  TEST_ASSERT_EQUAL_STRING(through.c_str(),
                           files_of(merge_random_plants(any, {in / "b.csv", in / "a.csv"}, false)).c_str());
  TEST_ASSERT_EQUAL_STRING(through.c_str(),
                           files_of(merge_random_plants(setup_of(1, 6), {in / "a.csv", in / "b.csv"}, true)).c_str());
}

void test_shards_that_do_not_fit_are_refused_with_file_and_line() {
  const std::filesystem::path in = folder("misfits");
  (void)run(setup_of(1, 2, in / "a.csv"));
  (void)run(setup_of(5, 1, in / "b.csv"));
  const std::string a = text_of(in / "a.csv");
  const std::string b = text_of(in / "b.csv");
  const RandomPlantsSetup any = setup_of(1, 2);
  check_says(merge_error({in / "a.csv", in / "b.csv"}, any, false), "b.csv: no line for the seeds 3-4; run them");
  check_says(merge_error({in / "a.csv"}, setup_of(1, 3), true), "a.csv: no line for the seeds 3;");
  check_says(merge_error({in / "b.csv"}, setup_of(1, 4), true), "b.csv:3: has seed 5; the seeds are 1 to 4");
  check_says(merge_error({in / "a.csv", in / "a.csv"}, any, false), "a.csv:3: has seed 1, which ");
  write(in / "c.csv", b.substr(0, b.size() - 5));
  check_says(merge_error({in / "a.csv", in / "c.csv"}, setup_of(1, 3), true),
             "c.csv:3: the file ends within this line");
  write(in / "c.csv", a.substr(0, a.size() - 20));  // one of its two seeds
  check_says(merge_error({in / "c.csv"}, any, false), "c.csv:4: the file ends within this line; continue its run");
  write(in / "d.csv", a + "3,4\n");
  check_says(merge_error({in / "d.csv"}, any, false), "d.csv:5: is not a result of sim_host random-plants");
  for (const char *part : {"1234567", "tracker.toml", "00000001", "share 0.3", "00000002", "1 deg/s"}) {
    std::string other = b;
    other.replace(other.find(part), 1, "x");
    write(in / "e.csv", other);
    check_says(merge_error({in / "a.csv", in / "e.csv"}, any, false),
               fmt::format("e.csv:{}: is not \"", part == std::string("1 deg/s") ? 2 : 1));
  }
  TEST_ASSERT_EQUAL_STRING(a.c_str(), text_of(in / "a.csv").c_str());
}

void test_a_plant_that_fails_is_a_line_and_no_end() {
  const std::filesystem::path log = folder("failed") / "log.csv";
  (void)run(setup_of(1, 2, log));
  const RandomPlants tried = run(setup_of(1, 4, log), refuse);
  TEST_ASSERT_EQUAL(2, tried.plants.size());
  TEST_ASSERT_EQUAL(2, tried.failed.size());
  TEST_ASSERT_TRUE(tried.failed[1].seed == 4);
  check_says(text_of(log), "\n4,\"failed: the firmware refuses '4' \"\n");
  check_says(files_of(tried), "\"without_result\": [\n  {\n   \"seed\": 3,");
  const RandomPlants again = run(setup_of(1, 4, log));  // nothing is run, nothing is lost
  TEST_ASSERT_EQUAL_STRING(files_of(tried).c_str(), files_of(again).c_str());
}

void test_without_any_result_the_reason_is_the_error() {
  const RandomPlants tried = run(setup_of(1, 2), refuse);
  std::string error;
  try {
    (void)summary_of(tried);
  } catch (const std::runtime_error& caught) {
    error = caught.what();
  }
  check_says(error, "no plant has a result; seed 1: the firmware refuses");
}

TriedPlant plant_with(double azimuth_deg_s, double pitch_deg_s) {
  TriedPlant plant;
  plant.axis[kAzimuth].peak_error_deg_s = {azimuth_deg_s};
  plant.axis[kPitch].peak_error_deg_s = {pitch_deg_s};
  return plant;
}

void test_plants_above_the_paper_count_once() {
  RandomPlants tried = run(setup_of(1, 1));
  tried.paper_deg_s = {0.014};
  tried.plants = {plant_with(0.01, 0.01), plant_with(0.02, 0.01), plant_with(0.02, 0.02), plant_with(0.01, 0.02),
                  plant_with(0.01, 0.02)};
  const RandomPlantsSummary summary = summary_of(tried);
  TEST_ASSERT_EQUAL(2, summary.failing);
  TEST_ASSERT_EQUAL(2, summary.axis[kAzimuth].above_paper);
  TEST_ASSERT_EQUAL(3, summary.axis[kPitch].above_paper);
  TEST_ASSERT_EQUAL(4, summary.above_paper);
}

// The sums over one pass against the formula over all deviations.
void test_correlations_of_one_pass_are_those_of_the_formula() {
  const RandomPlants tried = run(setup_of(1, 8));
  TEST_ASSERT_TRUE(tried.plants.front().axis[kAzimuth].peak_error_deg_s.front() > 1e-3);
  const Influence strongest = summary_of(tried).axis[kAzimuth].influences.front();
  std::vector<double> factors;
  std::vector<double> ratios;
  for (const TriedPlant& plant : tried.plants) {
    for (const Deviation& deviation : random_plant(tried.nominal, tried.share, plant.seed).deviations) {
      if (deviation.key == strongest.key) {
        factors.push_back(deviation.factor);
      }
    }
    ratios.push_back(worst_ratio(plant.axis[kAzimuth], tried.paper_deg_s));
  }
  TEST_ASSERT_TRUE(std::abs(strongest.correlation) > 0.1);
  TEST_ASSERT_DOUBLE_WITHIN(1e-12, correlation(factors, ratios), strongest.correlation);
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_every_value_of_a_plant_comes_back);
  RUN_TEST(test_a_run_that_is_continued_equals_one_that_runs_through);
  RUN_TEST(test_shards_give_the_files_of_one_run_in_any_order);
  RUN_TEST(test_shards_that_do_not_fit_are_refused_with_file_and_line);
  RUN_TEST(test_a_plant_that_fails_is_a_line_and_no_end);
  RUN_TEST(test_without_any_result_the_reason_is_the_error);
  RUN_TEST(test_plants_above_the_paper_count_once);
  RUN_TEST(test_correlations_of_one_pass_are_those_of_the_formula);
  return UNITY_END();
}
