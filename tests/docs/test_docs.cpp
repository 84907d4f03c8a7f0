// SPDX-License-Identifier: Apache-2.0
// Links of the documents work: every link within the repository, and every test that the pages on theory and safety
// name, and every plot of the theory page.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <set>
#include <sstream>
#include <string>
#include <vector>

#include "markdown.hpp"
#include "support/bench.hpp"
#include "support/check.h"

extern "C" void setUp(void) {}
extern "C" void tearDown(void) {}

namespace {

namespace fs = std::filesystem;
using trackservo::sim::plant_keys_markdown;
using trackservo::sim::scenario_keys_markdown;

const fs::path kRoot = TRACKSERVO_SOURCE_DIR;
const std::string kReport = "build/results/report.html";  // missing before the first demo

std::string text_of(const fs::path& file) {
  std::ifstream stream(file);
  TEST_ASSERT_TRUE_MESSAGE(stream.good(), file.c_str());
  return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

std::vector<fs::path> documents() {
  std::vector<fs::path> files{kRoot / "README.md", kRoot / "CONTRIBUTING.md", kRoot / "CHANGELOG.md"};
  for (const auto& entry : fs::recursive_directory_iterator(kRoot / "docs")) {
    if (entry.path().extension() == ".md") {
      files.push_back(entry.path());
    }
  }
  return files;
}

std::vector<std::string> lines_of(const std::string& text) {
  std::istringstream stream(text);
  std::vector<std::string> lines;
  for (std::string line; std::getline(stream, line);) {
    lines.push_back(line);
  }
  return lines;
}

// The text between the two marks, wherever it has no blank.
std::vector<std::string> between(const std::string& text, const std::string& before, char after) {
  std::vector<std::string> found;
  for (std::size_t place = text.find(before); place != std::string::npos; place = text.find(before, place + 1)) {
    const std::size_t begin = place + before.size();
    const std::string part = text.substr(begin, text.find(after, begin) - begin);
    if (part.find_first_of(" \n") == std::string::npos) {
      found.push_back(part);
    }
  }
  return found;
}

std::vector<std::string> links_of(const fs::path& document) {
  std::vector<std::string> links = between(text_of(document), "](", ')');
  links.erase(std::remove_if(links.begin(), links.end(),
                             [](const std::string& link) { return link.find("://") != std::string::npos; }),
              links.end());
  return links;
}

bool has_anchor(const fs::path& document, const std::string& anchor) {
  const std::vector<std::string> lines = lines_of(text_of(document));
  return std::any_of(lines.begin(), lines.end(), [&](const std::string& line) {
    const std::size_t text = line.find_first_not_of('#');
    return text != 0 && text != std::string::npos && trackservo::anchor_of(line.substr(text + 1)) == anchor;
  });
}

// The report's plots are named where the report makes them, and in the experiments' folders.
std::string keys_of_plots() {
  std::string text = text_of(kRoot / "tools/report/trackservo_report/sections.py");
  for (const auto& entry : fs::directory_iterator(kRoot / "sim_host/studies")) {
    const fs::path file = entry.path() / "experiment.toml";
    text += fs::exists(file) ? text_of(file) : "";
  }
  return text;
}

void check_link(const fs::path& document, const std::string& link) {
  const std::string what = document.string() + " links to " + link;
  const std::size_t hash = link.find('#');
  const std::string path = link.substr(0, hash);
  const std::string anchor = hash == std::string::npos ? "" : link.substr(hash + 1);
  const fs::path target = path.empty() ? document : (document.parent_path() / path).lexically_normal();
  if (target.lexically_relative(kRoot.lexically_normal()).generic_string() == kReport) {
    TEST_ASSERT_TRUE_MESSAGE(anchor.empty() || keys_of_plots().find("\"" + anchor + "\"") != std::string::npos,
                             what.c_str());
    return;
  }
  TEST_ASSERT_TRUE_MESSAGE(fs::exists(target), what.c_str());
  TEST_ASSERT_TRUE_MESSAGE(anchor.empty() || has_anchor(target, anchor), what.c_str());
}

void test_every_link_leads_somewhere() {
  int links = 0;
  for (const fs::path& document : documents()) {
    for (const std::string& link : links_of(document)) {
      check_link(document, link);
      ++links;
    }
  }
  LOG_VALUE("links followed", links);
  CHECK_AT_LEAST("links followed", 50, links);
}

void test_the_pages_on_theory_and_safety_name_tests_that_exist() {
  std::set<std::string> known;
  for (const char *folder : {"firmware", "hal", "sim_host", "tests", "tools"}) {
    for (const auto& entry : fs::recursive_directory_iterator(kRoot / folder)) {
      const std::string extension = entry.path().extension().string();
      const bool is_test = entry.path().stem().string().rfind("test_", 0) == 0;
      if (is_test && (extension == ".c" || extension == ".cpp")) {
        known.insert(entry.path().stem().string());
        for (const std::string& name : between(text_of(entry.path()), "RUN_TEST(", ')')) {
          known.insert(name);
        }
      } else if (is_test && extension == ".py") {
        for (const std::string& name : between(text_of(entry.path()), "\ndef test_", '(')) {
          known.insert("test_" + name);
        }
      }
    }
  }
  for (const char *page :
       {"theory.md", "safety.md", "safety/functions.md", "safety/failure-modes.md", "safety/techniques.md"}) {
    const std::vector<std::string> named = between(text_of(kRoot / "docs" / page), "`test_", '`');
    for (const std::string& name : named) {
      TEST_ASSERT_TRUE_MESSAGE(known.count("test_" + name) == 1, name.c_str());
    }
    CHECK_AT_LEAST(page, 3, named.size());
  }
}

// The cells of the row whose block is this header; none when there is no such row.
std::vector<std::string> theory_row_of(const std::string& header) {
  for (const std::string& line : lines_of(text_of(kRoot / "docs/theory.md"))) {
    if (line.rfind("| ", 0) == 0 && line.find("(../firmware/control/" + header + ")") != std::string::npos) {
      std::istringstream stream(line.substr(1));
      std::vector<std::string> cells;
      for (std::string cell; std::getline(stream, cell, '|');) {
        cells.push_back(cell);
      }
      return cells;
    }
  }
  return {};
}

// A newcomer finds the equation, the block, its test and its plot without help.
void test_every_control_block_has_a_row_with_equation_block_test_and_plot() {
  for (const auto& entry : fs::directory_iterator(kRoot / "firmware/control")) {
    const std::string header = entry.path().filename().string();
    if (entry.path().extension() != ".h") {
      continue;
    }
    const std::vector<std::string> cells = theory_row_of(header);
    TEST_ASSERT_EQUAL_MESSAGE(5, cells.size(), header.c_str());
    TEST_ASSERT_TRUE_MESSAGE(cells[1].find("](#") != std::string::npos, header.c_str());
    TEST_ASSERT_TRUE_MESSAGE(cells[3].find("[`test_") != std::string::npos, header.c_str());
    const bool shown = cells[4].find(kReport + "#") != std::string::npos;
    TEST_ASSERT_TRUE_MESSAGE(shown || cells[4].rfind(" none: ", 0) == 0, header.c_str());
  }
}

// The reference pages are printed by tools/update-docs; this test fails when they are out of date.
void test_the_pages_of_the_keys_are_those_that_the_reader_checks_by() {
  TEST_ASSERT_TRUE_MESSAGE(text_of(kRoot / "docs/plant-files.md") == plant_keys_markdown(),
                           "renew with: sim_host keys plant");
  TEST_ASSERT_TRUE_MESSAGE(text_of(kRoot / "docs/scenario-files.md") == scenario_keys_markdown(),
                           "renew with: sim_host keys scenario");
}

}  // namespace

int main() {
  UNITY_BEGIN();
  RUN_TEST(test_every_link_leads_somewhere);
  RUN_TEST(test_the_pages_on_theory_and_safety_name_tests_that_exist);
  RUN_TEST(test_every_control_block_has_a_row_with_equation_block_test_and_plot);
  RUN_TEST(test_the_pages_of_the_keys_are_those_that_the_reader_checks_by);
  return UNITY_END();
}
