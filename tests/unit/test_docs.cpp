// Documents lead somewhere: every link within the repository, and every test and plot that the theory page names.
#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <regex>
#include <set>
#include <string>
#include <vector>

#include "support/bench.hpp"
#include "support/check.h"

extern "C" void setUp(void) {}
extern "C" void tearDown(void) {}

namespace {

namespace fs = std::filesystem;
using trackservo::sim::plant_keys_markdown;
using trackservo::sim::scenario_keys_markdown;

const fs::path kRoot = TRACKSERVO_SOURCE_DIR;
const std::string kReport = "build/results/report.html";  // not there before the first demo

std::string text_of(const fs::path& file) {
  std::ifstream stream(file);
  TEST_ASSERT_TRUE_MESSAGE(stream.good(), file.c_str());
  return {std::istreambuf_iterator<char>(stream), std::istreambuf_iterator<char>()};
}

std::vector<fs::path> documents() {
  std::vector<fs::path> files{kRoot / "README.md", kRoot / "CHANGELOG.md"};
  for (const auto& entry : fs::recursive_directory_iterator(kRoot / "docs")) {
    if (entry.path().extension() == ".md") {
      files.push_back(entry.path());
    }
  }
  return files;
}

// What stands in the first group of every match.
std::vector<std::string> matches(const std::string& text, const char *pattern) {
  const std::regex expression(pattern);
  std::vector<std::string> found;
  for (std::sregex_iterator match(text.begin(), text.end(), expression), end; match != end; ++match) {
    found.push_back((*match)[1].str());
  }
  return found;
}

std::vector<std::string> links_of(const fs::path& document) {
  std::vector<std::string> links = matches(text_of(document), R"(\]\(([^()\s]+)\))");
  links.erase(std::remove_if(links.begin(), links.end(),
                             [](const std::string& link) { return link.find("://") != std::string::npos; }),
              links.end());
  return links;
}

// The name that a heading's link has: lower case, blanks as hyphens, other signs left out.
std::string anchor_of(const std::string& heading) {
  std::string anchor;
  for (const char letter : heading) {
    if (letter == ' ' || letter == '-') {
      anchor += '-';
    } else if (std::isalnum(static_cast<unsigned char>(letter)) != 0 || letter == '_') {
      anchor += static_cast<char>(std::tolower(static_cast<unsigned char>(letter)));
    }
  }
  return anchor;
}

bool has_anchor(const fs::path& document, const std::string& anchor) {
  const std::vector<std::string> headings = matches(text_of(document), R"((?:^|\n)#+ ([^\n]+))");
  return std::any_of(headings.begin(), headings.end(),
                     [&](const std::string& heading) { return anchor_of(heading) == anchor; });
}

void check_link(const fs::path& document, const std::string& link) {
  const std::string what = document.string() + " links to " + link;
  const std::size_t hash = link.find('#');
  const std::string path = link.substr(0, hash);
  const std::string anchor = hash == std::string::npos ? "" : link.substr(hash + 1);
  const fs::path target = path.empty() ? document : (document.parent_path() / path).lexically_normal();
  if (target.lexically_relative(kRoot.lexically_normal()).generic_string() == kReport) {
    const std::string sections = text_of(kRoot / "tools/report/trackservo_report/sections.py");
    TEST_ASSERT_TRUE_MESSAGE(anchor.empty() || sections.find("\"" + anchor + "\"") != std::string::npos, what.c_str());
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

void test_the_theory_page_names_tests_that_exist() {
  std::set<std::string> known;
  for (const char *folder : {"tests/unit", "tests/closed_loop"}) {
    for (const auto& entry : fs::directory_iterator(kRoot / folder)) {
      const std::string extension = entry.path().extension().string();
      if (extension == ".c" || extension == ".cpp") {
        known.insert(entry.path().stem().string());
        for (const std::string& name : matches(text_of(entry.path()), R"(RUN_TEST\((\w+)\))")) {
          known.insert(name);
        }
      }
    }
  }
  const std::vector<std::string> named = matches(text_of(kRoot / "docs/theory.md"), R"(`(test_\w+)`)");
  for (const std::string& name : named) {
    TEST_ASSERT_TRUE_MESSAGE(known.count(name) == 1, name.c_str());
  }
  CHECK_AT_LEAST("tests named", 30, named.size());
}

// Issue 2: "a newcomer finds the equation, the block, its test and its plot without help".
void test_every_control_block_has_a_row_with_equation_block_test_and_plot() {
  const std::string page = text_of(kRoot / "docs/theory.md");
  for (const auto& entry : fs::directory_iterator(kRoot / "firmware/control")) {
    const std::string name = entry.path().stem().string();
    const std::set<std::string> tools{"angle", "scalar", "status"};  // used by blocks, none themselves
    if (entry.path().extension() != ".h" || tools.count(name) == 1) {
      continue;
    }
    const std::regex row(R"(\n\| [^|\n]+ \| \[[^|\n]+\]\(#[^|\n]+\) \| [^|\n]*\(\.\./firmware/control/)" + name +
                         R"(\.h\)[^|\n]* \| \[`test_[^|\n]+ \| [^|\n]+ \|)");
    TEST_ASSERT_TRUE_MESSAGE(std::regex_search(page, row), name.c_str());
  }
}

// The reference pages are printed by tools/update-docs; this tells when that was forgotten.
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
  RUN_TEST(test_the_theory_page_names_tests_that_exist);
  RUN_TEST(test_every_control_block_has_a_row_with_equation_block_test_and_plot);
  RUN_TEST(test_the_pages_of_the_keys_are_those_that_the_reader_checks_by);
  return UNITY_END();
}
