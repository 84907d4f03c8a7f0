// SPDX-License-Identifier: Apache-2.0
#include <fmt/format.h>

#include <cmath>

#include "check/check_report.hpp"

namespace trackservo::sim {
namespace {

void print(const JudgedFigure& judged) {
  const FigureKey& key = judged.figure.key;
  const char *verdict = !judged.limit ? "no limit" : judged.kept ? "ok" : "NOT MET";
  fmt::print("  {:<16} {:<22} {:<8} {:<22} {:>10.4g} +- {:<8.2g} {:<20} {}\n", key.scenario, key.case_name, key.axis,
             key.name, judged.value, judged.scatter, limit_text(judged), verdict);
}

void print(const Comparison& comparison) {
  fmt::print("\nsince {} ({}): {} figures compared {}, {} worse, {} better, {} otherwise changed\n",
             comparison.baseline.file.string(), comparison.baseline.git, comparison.compared,
             comparison.paired ? "seed by seed" : "by means, because the seeds differ",
             comparison.count(ChangeKind::kWorse), comparison.count(ChangeKind::kBetter),
             comparison.count(ChangeKind::kOther));
  for (const Change& change : comparison.changes) {
    fmt::print("  {}\n", text_of(change));
  }
  if (!comparison.only_before.empty()) {
    fmt::print("  {} figures of the earlier run are missing in this run, the first: {}\n",
               comparison.only_before.size(), text_of(comparison.only_before.front()));
  }
}

}  // namespace

std::string text_of(const Change& change) {
  if (!std::isfinite(change.now) || !std::isfinite(change.before)) {
    return fmt::format("{}: {} {}", change_name(change.kind), text_of(change.key),
                       std::isfinite(change.now) ? "has a value again" : "has no value any more");
  }
  const double share = change.before == 0.0 ? 0.0 : 100.0 * (change.now - change.before) / std::abs(change.before);
  return fmt::format("{}: {} {:.4g} -> {:.4g} {} ({:+.0f} %)", change_name(change.kind), text_of(change.key),
                     change.before, change.now, change.unit, share);
}

void print(const CheckReport& report) {
  fmt::print("plant {}, gains {}, {}, {} seeds, commit {}\n\n", report.plant, report.gains, report.device,
             report.seeds.size(), report.git);
  std::size_t limited = 0;
  std::size_t broken = 0;
  for (const JudgedFigure& judged : report.figures) {
    print(judged);
    limited += judged.limit ? 1 : 0;
    broken += judged.kept ? 0 : 1;
  }
  if (report.comparison) {
    print(*report.comparison);
  }
  fmt::print("\n");
  for (const JudgedFigure& judged : report.figures) {
    if (!judged.kept) {
      fmt::print("NOT MET: {}\n", judged.problem);
    }
  }
  if (report.red_by_baseline()) {
    fmt::print("WORSE: {} figures are worse than in {}\n", report.comparison->count(ChangeKind::kWorse),
               report.comparison->baseline.file.string());
  }
  fmt::print("{} of {} limits met: {}\n", limited - broken, limited, report.kept() ? "passed" : "FAILED");
}

}  // namespace trackservo::sim
