// SPDX-License-Identifier: Apache-2.0
// experiment.toml: the shipped experiments, their goals, and the refusals with file, line, reason and remedy.
#include "studies/shared/experiment.hpp"

#include <unistd.h>

#include <algorithm>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "machine/config/config_error.hpp"
#include "support/check.h"

namespace fs = std::filesystem;

namespace {

fs::path data;  // a data folder with the plants and one experiment

}  // namespace

extern "C" void setUp(void) {
  data = fs::temp_directory_path() / ("trackservo_experiment_" + std::to_string(getpid()));
  fs::create_directories(data / "studies/mine");
  fs::copy("sim_host/plants", data / "plants");
}

extern "C" void tearDown(void) { fs::remove_all(data); }

namespace {

using namespace trackservo::sim;

std::string text_of(const fs::path& file) {
  std::ifstream stream(file);
  std::stringstream text;
  text << stream.rdbuf();
  return text.str();
}

void write(const fs::path& file, const std::string& text) { std::ofstream(file) << text; }

// Those of the paper; a new experiment changes nothing here.
const std::vector<std::string> kOfThePaper = {"sine", "step_disturbed", "low_speed_start", "steady_speed", "tracking"};

bool is_of_the_paper(const std::string& name) {
  return std::find(kOfThePaper.begin(), kOfThePaper.end(), name) != kOfThePaper.end();
}

void test_the_shipped_experiments_come_in_the_order_of_the_papers_figures() {
  std::vector<std::string> names;
  int order = 0;
  for (const Experiment& experiment : load_experiments("sim_host")) {
    if (is_of_the_paper(experiment.name)) {
      names.push_back(experiment.name);
    }
    TEST_ASSERT_TRUE_MESSAGE(experiment.order >= order, experiment.name.c_str());
    order = experiment.order;
    TEST_ASSERT_EQUAL_STRING(experiment.name.c_str(), experiment.studies.front().scenario.name.c_str());
    TEST_ASSERT_FALSE_MESSAGE(experiment.goals.empty(), experiment.name.c_str());
    TEST_ASSERT_FALSE_MESSAGE(experiment.compared.empty(), experiment.name.c_str());
  }
  TEST_ASSERT_TRUE(names == kOfThePaper);
}

void test_the_scenario_of_an_experiment_is_also_at_its_old_path() {
  for (const std::string& name : kOfThePaper) {
    const fs::path old = "sim_host/scenarios/" + name + ".toml";
    TEST_ASSERT_TRUE_MESSAGE(fs::equivalent(old, "sim_host/studies/" + name + "/scenario.toml"), old.c_str());
  }
}

void test_a_data_folder_without_experiments_has_the_shipped_ones_on_its_own_scenarios() {
  fs::remove_all(data / "studies");
  fs::create_directories(data / "scenarios");
  std::string text = text_of("sim_host/studies/sine/scenario.toml");
  text.replace(text.find("speeds_deg_s = [1.0]"), 20, "speeds_deg_s = [1.0, 3.0]");
  write(data / "scenarios/sine.toml", text);
  const std::vector<Experiment> experiments = load_experiments(data, "sim_host");
  TEST_ASSERT_EQUAL_INT(load_experiments("sim_host").size(), experiments.size());
  TEST_ASSERT_EQUAL_INT(2, experiment_named("sine", experiments).studies.front().scenario.speeds_rad_s.size());
  TEST_ASSERT_EQUAL_INT(3,
                        experiment_named("low_speed_start", experiments).studies.front().scenario.speeds_rad_s.size());
}

// One change to the shipped sine, and what the refusal must say. `line` counts from the changed line.
struct Refusal {
  const char *from;
  const char *to;
  int line;
  const char *reason;
  const char *remedy;
};

constexpr Refusal kRefusals[] = {
    {"plant = \"paper_simulation\"", "plant = \"papre\"", 0, "plant: \"papre\": there is no", "a file in plants/"},
    {"metric = \"peak_error\"", "metric = \"overshoot\"", 0, "metric: \"overshoot\" is unknown",
     "peak_error, rms_error"},
    {"order = 7", "order = \"first\"", 0, "order:", "integer"},
    {"title = ", "titl = ", 0, "titl:", "title"},
    {"frictions = [\"lugre\"", "frictions = [\"dahl\"", 0, "holds \"dahl\"", "lugre, maxwell_slip, none"},
    {"figure = ", "derived = [\"overshoot_over_friction_free\"]\nfigure = ", 0, "overshoot_over_friction_free",
     "add \"none\" to frictions"},
    {"figure = ", "trackers = [\"pi\", \"predictive\"]\nfigure = ", 0, "several loops", "only a scenario that tracks"},
    {"case = \"1 deg/s, 0.1 Hz\"", "case = \"1 deg/s\"", 0, "compared[0].case: \"1 deg/s\" is unknown",
     "1 deg/s, 0.1 Hz"},
    {"controller = \"pi_vob_ftc\"", "controller = \"pid\"", 0, "goal[1].controller: \"pid\"", "pi_vob_ftc"},
    {"high = 0.010", "low = 0.02\nhigh = 0.010", 0, "goal[1].low: 0.02 is above high = 0.01", "exchange"},
    {"high = 0.010\n", "", -3, "goal[1].high: is missing", "give one of them"},
    {"within_percent = 4\n", "", 1, "goal[0].high: is missing", "within_percent"},
};

void test_a_wrong_experiment_is_refused_with_file_line_reason_and_remedy() {
  const std::string shipped = text_of("sim_host/studies/sine/experiment.toml");
  fs::copy("sim_host/studies/sine/scenario.toml", data / "studies/mine/scenario.toml");
  for (const Refusal& refusal : kRefusals) {
    std::string text = shipped;
    const std::size_t place = text.find(refusal.from);
    TEST_ASSERT_TRUE_MESSAGE(place != std::string::npos, refusal.from);
    text.replace(place, std::string(refusal.from).size(), refusal.to);
    const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(place), '\n');
    write(data / "studies/mine/experiment.toml", text);
    try {
      load_experiments(data);
      TEST_FAIL_MESSAGE(refusal.to);
    } catch (const ConfigError& error) {
      const std::string said = error.what();
      const std::string where = "mine/experiment.toml:" + std::to_string(line + refusal.line) + ":";
      TEST_ASSERT_TRUE_MESSAGE(said.find(where) != std::string::npos, (where + " not in " + said).c_str());
      TEST_ASSERT_TRUE_MESSAGE(said.find(refusal.reason) != std::string::npos, said.c_str());
      TEST_ASSERT_TRUE_MESSAGE(said.find(refusal.remedy) != std::string::npos, said.c_str());
      TEST_ASSERT_TRUE_MESSAGE(said.find('\n') == std::string::npos, said.c_str());
    }
  }
}

void test_a_folder_without_any_experiment_is_refused() {
  try {
    load_experiments(data / "plants");
    TEST_FAIL_MESSAGE("not refused");
  } catch (const ConfigError& error) {
    TEST_ASSERT_TRUE(std::string(error.what()).find("experiment.toml") != std::string::npos);
  }
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_the_shipped_experiments_come_in_the_order_of_the_papers_figures);
  RUN_TEST(test_the_scenario_of_an_experiment_is_also_at_its_old_path);
  RUN_TEST(test_a_data_folder_without_experiments_has_the_shipped_ones_on_its_own_scenarios);
  RUN_TEST(test_a_wrong_experiment_is_refused_with_file_line_reason_and_remedy);
  RUN_TEST(test_a_folder_without_any_experiment_is_refused);
  return UNITY_END();
}
