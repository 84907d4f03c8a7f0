// SPDX-License-Identifier: Apache-2.0
// The result as one HTML page that opens without a network: verdict, missed limits, changes, every figure with its
// limits as a bar.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <pugixml.hpp>
#include <sstream>
#include <stdexcept>

#include "check/check_report.hpp"

namespace trackservo::sim {
namespace {

constexpr const char *kStyle =
    "body{font:15px/1.5 system-ui,sans-serif;max-width:76em;margin:2em auto;padding:0 "
    "1em;color:#1c2430;background:#fff}"
    "h1{font-size:1.6em}h2{font-size:1.15em;margin-top:2em}table{border-collapse:collapse;width:100%}"
    "th,td{text-align:left;padding:.25em .7em;border-bottom:1px solid #dde2e8}td.n{text-align:right;"
    "font-variant-numeric:tabular-nums}.good{color:#136c2e}.bad{color:#b3151b;font-weight:600}.dim{color:#667080}"
    ".bar{background:#e7ebf0;width:9em;height:.8em;position:relative}.fill{background:#4b7bb5;height:100%}"
    ".fill.over{background:#b3151b}";

pugi::xml_node add(pugi::xml_node parent, const char *tag, const std::string& text = "", const char *css = nullptr) {
  pugi::xml_node node = parent.append_child(tag);
  if (css != nullptr) {
    node.append_attribute("class").set_value(css);
  }
  if (!text.empty()) {
    node.text().set(text.c_str());
  }
  return node;
}

pugi::xml_node add_table(pugi::xml_node body, const std::vector<const char *>& heads) {
  pugi::xml_node table = add(body, "table");
  pugi::xml_node row = add(table, "tr");
  for (const char *head : heads) {
    add(row, "th", head);
  }
  return table;
}

void add_key(pugi::xml_node row, const FigureKey& key) {
  for (const std::string& word : {key.scenario, key.case_name, key.axis, key.name}) {
    add(row, "td", word);
  }
}

std::string value_text(double value) { return std::isfinite(value) ? fmt::format("{:.4g}", value) : "no value"; }

// Used share of a figure's limit: of a maximum upwards, of a minimum downwards.
double used_share(const JudgedFigure& judged) {
  const Limit& limit = *judged.limit;
  if (!std::isfinite(judged.value)) {
    return 1.0;
  }
  if (limit.max && limit.min) {
    const double middle = 0.5 * (*limit.max + *limit.min);
    const double half = 0.5 * (*limit.max - *limit.min);
    return half > 0.0 ? std::abs(judged.value - middle) / half : 1.0;
  }
  if (limit.max) {
    return *limit.max != 0.0 ? judged.value / *limit.max : 1.0;
  }
  return judged.value != 0.0 ? *limit.min / judged.value : 1.0;
}

void add_bar(pugi::xml_node row, const JudgedFigure& judged) {
  pugi::xml_node cell = add(row, "td");
  if (!judged.limit) {
    return;
  }
  const double percent = std::clamp(100.0 * used_share(judged), 0.0, 100.0);
  pugi::xml_node fill = add(add(cell, "div", "", "bar"), "div", "", judged.kept ? "fill" : "fill over");
  fill.append_attribute("style").set_value(fmt::format("width:{:.0f}%", percent).c_str());
}

void add_head(pugi::xml_node body, const CheckReport& report) {
  const auto limited = std::count_if(report.figures.begin(), report.figures.end(),
                                     [](const JudgedFigure& judged) { return judged.limit.has_value(); });
  const auto broken = std::count_if(report.figures.begin(), report.figures.end(),
                                    [](const JudgedFigure& judged) { return !judged.kept; });
  add(body, "h1",
      fmt::format("{}: {} of {} limits met", report.kept() ? "Passed" : "Failed", limited - broken, limited),
      report.kept() ? "good" : "bad");
  add(body, "p",
      fmt::format("Plant {}, gains {}, {}, {} seeds, limits {}, commit {}.", report.plant, report.gains, report.device,
                  report.seeds.size(), report.limits.empty() ? "learned from this run" : report.limits, report.git),
      "dim");
  for (const JudgedFigure& judged : report.figures) {
    if (!judged.kept) {
      add(body, "p", judged.problem, "bad");
    }
  }
}

void add_changes(pugi::xml_node body, const Comparison& comparison) {
  add(body, "h2", fmt::format("Since {}", comparison.baseline.git));
  add(body, "p",
      fmt::format("{} figures compared {}. Listed: figures that changed by more than the scatter of the seeds: {} "
                  "worse, {} better, {} otherwise changed.",
                  comparison.compared, comparison.paired ? "seed by seed" : "by means, because the seeds differ",
                  comparison.count(ChangeKind::kWorse), comparison.count(ChangeKind::kBetter),
                  comparison.count(ChangeKind::kOther)));
  if (comparison.changes.empty()) {
    return;
  }
  pugi::xml_node table = add_table(body, {"", "scenario", "case", "axis", "figure", "before", "now", "counts from"});
  for (const Change& change : comparison.changes) {
    pugi::xml_node row = add(table, "tr");
    const char *css = change.kind == ChangeKind::kWorse ? "bad" : change.kind == ChangeKind::kBetter ? "good" : "dim";
    add(row, "td", change_name(change.kind), css);
    add_key(row, change.key);
    add(row, "td", value_text(change.before), "n");
    add(row, "td", value_text(change.now), "n");
    add(row, "td", fmt::format("+-{:.2g} {}", change.threshold, change.unit), "n");
  }
}

void add_figures(pugi::xml_node body, const CheckReport& report) {
  add(body, "h2", "All figures");
  pugi::xml_node table =
      add_table(body, {"scenario", "case", "axis", "figure", "mean", "scatter", "unit", "limit", "used", ""});
  for (const JudgedFigure& judged : report.figures) {
    pugi::xml_node row = add(table, "tr");
    add_key(row, judged.figure.key);
    add(row, "td", value_text(judged.value), "n");
    add(row, "td", std::isfinite(judged.scatter) ? fmt::format("{:.2g}", judged.scatter) : "", "n");
    add(row, "td", judged.figure.unit);
    add(row, "td", limit_text(judged), "n");
    add_bar(row, judged);
    add(row, "td",
        !judged.limit ? "no limit"
        : judged.kept ? "kept"
                      : "not met",
        !judged.limit ? "dim"
        : judged.kept ? "good"
                      : "bad");
  }
}

}  // namespace

void write_page(const CheckReport& report, const std::filesystem::path& file) {
  pugi::xml_document document;
  pugi::xml_node html = document.append_child("html");
  html.append_attribute("lang").set_value("en");
  pugi::xml_node head = add(html, "head");
  add(head, "meta").append_attribute("charset").set_value("utf-8");
  add(head, "title", fmt::format("{}: sim_host check of {}", report.kept() ? "Passed" : "Failed", report.plant));
  add(head, "style", kStyle);
  pugi::xml_node body = add(html, "body");
  add_head(body, report);
  if (report.comparison) {
    add_changes(body, *report.comparison);
  }
  add_figures(body, report);
  std::ostringstream text;
  document.save(text, "", pugi::format_raw | pugi::format_no_declaration | pugi::format_no_empty_element_tags,
                pugi::encoding_utf8);
  std::ofstream stream(file);
  stream << "<!DOCTYPE html>\n" << text.str() << "\n";
  if (!stream.flush()) {
    throw std::runtime_error(fmt::format("{}: cannot be written; is the folder writable?", file.string()));
  }
}

}  // namespace trackservo::sim
