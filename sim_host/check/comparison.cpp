// SPDX-License-Identifier: Apache-2.0
#include "check/comparison.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <boost/math/distributions/students_t.hpp>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>

#include "check/results_file.hpp"
#include "json_text.hpp"
#include "judge/analysis/statistics.hpp"
#include "machine/config/config_error.hpp"

namespace trackservo::sim {
namespace {

constexpr double kSignificance = 0.001;  // two-sided
constexpr double kRelevantShare = 0.02;

double student(double degrees_of_freedom) {
  const boost::math::students_t distribution(degrees_of_freedom);
  return boost::math::quantile(boost::math::complement(distribution, 0.5 * kSignificance));
}

double paired_scatter(const std::vector<double>& before, const std::vector<double>& now) {
  std::vector<double> differences(now.size());
  std::transform(now.begin(), now.end(), before.begin(), differences.begin(), std::minus<>());
  const auto n = static_cast<double>(now.size());
  return n < 2.0 ? 0.0 : student(n - 1.0) * standard_deviation(differences) / std::sqrt(n);
}

// Welch's, with Satterthwaite's degrees of freedom.
double unpaired_scatter(const std::vector<double>& before, const std::vector<double>& now) {
  const auto share = [](const std::vector<double>& values) {
    const double deviation = standard_deviation(values);
    return deviation * deviation / static_cast<double>(values.size());
  };
  const double a = share(before);
  const double b = share(now);
  if (before.size() < 2 || now.size() < 2 || a + b <= 0.0) {
    return 0.0;
  }
  const double freedom = (a + b) * (a + b) /
                         (a * a / static_cast<double>(before.size() - 1) + b * b / static_cast<double>(now.size() - 1));
  return student(freedom) * std::sqrt(a + b);
}

ChangeKind kind_of(Better better, double difference) {
  if (better == Better::kNeither) {
    return ChangeKind::kOther;
  }
  return (difference < 0.0) == (better == Better::kLower) ? ChangeKind::kBetter : ChangeKind::kWorse;
}

// A figure that had values and has none now is worse; the reverse is better.
void add_change(Comparison& comparison, const CheckFigure& before, const CheckFigure& now) {
  const double mean_before = mean_of(before);
  const double mean_now = mean_of(now);
  Change change{now.key, now.unit, ChangeKind::kOther, mean_before, mean_now, 0.0};
  if (!std::isfinite(mean_before) || !std::isfinite(mean_now)) {
    if (std::isfinite(mean_before) != std::isfinite(mean_now)) {
      change.kind = std::isfinite(mean_now) ? ChangeKind::kBetter : ChangeKind::kWorse;
      comparison.changes.push_back(change);
    }
    return;
  }
  const double scatter =
      comparison.paired ? paired_scatter(before.values, now.values) : unpaired_scatter(before.values, now.values);
  change.threshold = std::max(scatter, kRelevantShare * std::abs(mean_before));
  if (std::abs(mean_now - mean_before) > change.threshold) {
    change.kind = kind_of(now.better, mean_now - mean_before);
    comparison.changes.push_back(change);
  }
}

const CheckFigure *find(const std::vector<CheckFigure>& figures, const FigureKey& key) {
  const auto found =
      std::find_if(figures.begin(), figures.end(), [&](const CheckFigure& figure) { return figure.key == key; });
  return found == figures.end() ? nullptr : &*found;
}

CheckFigure figure_of(const nlohmann::json& row, std::size_t seeds) {
  CheckFigure figure;
  figure.key = {row.at("scenario"), row.at("case"), row.at("axis"), row.at("figure")};
  figure.unit = row.at("unit");
  figure.better = better_of(figure.key.name);
  for (const nlohmann::json& value : row.at("values")) {
    figure.values.push_back(value.is_null() ? std::numeric_limits<double>::quiet_NaN() : value.get<double>());
  }
  if (figure.values.size() != seeds) {
    throw ConfigError(fmt::format("{} has {} values for {} seeds", text_of(figure.key), figure.values.size(), seeds));
  }
  return figure;
}

}  // namespace

std::size_t Comparison::count(ChangeKind kind) const {
  return static_cast<std::size_t>(
      std::count_if(changes.begin(), changes.end(), [&](const Change& change) { return change.kind == kind; }));
}

Baseline read_baseline(const std::filesystem::path& file) {
  try {
    const nlohmann::json json = parse_json(read_text(file));
    if (json.at("format") != kResultsFormat) {
      throw ConfigError(fmt::format("its format is not {}", kResultsFormat));
    }
    Baseline baseline{file, json.at("git"), json.at("plant"), json.at("device"), json.at("seeds"), {}};
    for (const nlohmann::json& row : json.at("figures")) {
      baseline.figures.push_back(figure_of(row, baseline.seeds.size()));
    }
    return baseline;
  } catch (const TextFileError& error) {
    throw ConfigError(fmt::format("{}:{}: {}; give a results.json of sim_host check, or omit --baseline", file.string(),
                                  error.line(), error.what()));
  } catch (const std::exception& error) {
    throw ConfigError(fmt::format("{}: is not a results.json of sim_host check ({}); give one, or omit --baseline",
                                  file.string(), error.what()));
  }
}

Comparison compare(const Baseline& baseline, const std::vector<CheckFigure>& figures,
                   const std::vector<std::uint64_t>& seeds) {
  Comparison comparison{baseline, baseline.seeds == seeds, {}, {}, 0};
  for (const CheckFigure& now : figures) {
    if (const CheckFigure *before = find(baseline.figures, now.key)) {
      ++comparison.compared;
      add_change(comparison, *before, now);
    }
  }
  for (const CheckFigure& before : baseline.figures) {
    if (find(figures, before.key) == nullptr) {
      comparison.only_before.push_back(before.key);
    }
  }
  const auto rank = [](const Change& change) { return change.kind == ChangeKind::kWorse ? 0 : 1; };
  std::stable_sort(comparison.changes.begin(), comparison.changes.end(),
                   [&](const Change& a, const Change& b) { return rank(a) < rank(b); });
  return comparison;
}

const char *change_name(ChangeKind kind) {
  switch (kind) {
    case ChangeKind::kBetter:
      return "better";
    case ChangeKind::kWorse:
      return "worse";
    case ChangeKind::kOther:
    default:
      return "changed";
  }
}

}  // namespace trackservo::sim
