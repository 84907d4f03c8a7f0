// SPDX-License-Identifier: Apache-2.0
// The result as JUnit XML: a test suite per scenario, a test case per figure that has a limit; the comparison with the
// baseline is a suite of its own.
#include <fmt/format.h>

#include <map>
#include <pugixml.hpp>
#include <stdexcept>

#include "check/check_report.hpp"

namespace trackservo::sim {
namespace {

class Suite {
 public:
  Suite(pugi::xml_node parent, const std::string& name) : node_(parent.append_child("testsuite")) {
    node_.append_attribute("name").set_value(name.c_str());
    for (const char *count : {"tests", "failures"}) {
      node_.append_attribute(count).set_value(0);
    }
  }

  // A failed test case when there is a problem.
  void add(const std::string& class_name, const std::string& name, const std::string& problem) {
    increase("tests");
    pugi::xml_node test = node_.append_child("testcase");
    test.append_attribute("classname").set_value(class_name.c_str());
    test.append_attribute("name").set_value(name.c_str());
    if (!problem.empty()) {
      increase("failures");
      pugi::xml_node failure = test.append_child("failure");
      failure.append_attribute("message").set_value(problem.c_str());
      failure.text().set(problem.c_str());
    }
  }

  int count(const char *name) const { return node_.attribute(name).as_int(); }

 private:
  void increase(const char *name) { node_.attribute(name).set_value(count(name) + 1); }

  pugi::xml_node node_;
};

void add_limits(pugi::xml_node root, const CheckReport& report, std::vector<Suite>& suites) {
  std::map<std::string, std::size_t> place;
  for (const JudgedFigure& judged : report.figures) {
    if (!judged.limit) {
      continue;
    }
    const FigureKey& key = judged.figure.key;
    const auto [found, is_new] = place.emplace(key.scenario, suites.size());
    if (is_new) {
      suites.emplace_back(root, key.scenario);
    }
    suites[found->second].add(fmt::format("{}, {}", key.scenario, key.case_name),
                              fmt::format("{} {}", key.axis, key.name), judged.problem);
  }
}

void add_baseline(pugi::xml_node root, const CheckReport& report, std::vector<Suite>& suites) {
  if (!report.comparison) {
    return;
  }
  suites.emplace_back(root, "baseline");
  std::string worse;
  for (const Change& change : report.comparison->changes) {
    if (change.kind == ChangeKind::kWorse) {
      worse += (worse.empty() ? "" : "\n") + text_of(change);
    }
  }
  suites.back().add("baseline", "no figure is worse than in the baseline", report.worse_is_red ? worse : "");
}

}  // namespace

void write_junit(const CheckReport& report, const std::filesystem::path& file) {
  pugi::xml_document document;
  pugi::xml_node root = document.append_child("testsuites");
  root.append_attribute("name").set_value("sim_host check");
  std::vector<Suite> suites;
  add_limits(root, report, suites);
  add_baseline(root, report, suites);
  for (const char *name : {"tests", "failures"}) {
    int sum = 0;
    for (const Suite& suite : suites) {
      sum += suite.count(name);
    }
    root.append_attribute(name).set_value(sum);
  }
  if (!document.save_file(file.c_str(), " ", pugi::format_default, pugi::encoding_utf8)) {
    throw std::runtime_error(fmt::format("{}: cannot be written; is the folder writable?", file.string()));
  }
}

}  // namespace trackservo::sim
