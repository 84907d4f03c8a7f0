// SPDX-License-Identifier: Apache-2.0
#include "check/limits.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <set>
#include <stdexcept>

#include "judge/analysis/statistics.hpp"
#include "machine/config/toml_reader.hpp"

namespace trackservo::sim {
namespace {

constexpr const char *kLearned = "learned";

// Unique names of one level of the keys below a common prefix.
using Names = std::vector<std::string>;

class LimitsReader {
 public:
  LimitsReader(const std::filesystem::path& file, const std::vector<CheckFigure>& figures, bool subset)
      : reader_(file), figures_(figures), subset_(subset) {
    limits_.file = file;
  }

  Limits read() {
    read_learned();
    for (const auto& [name, node] : *reader_.root().table) {
      const std::string scenario(name.str());
      if (scenario == kLearned) {
        continue;
      }
      const Names known = names([](const FigureKey&) { return true; }, &FigureKey::scenario);
      if (subset_ && std::find(known.begin(), known.end(), scenario) == known.end()) {
        continue;
      }
      read_scenario(scenario);
    }
    require_every_scenario();
    return limits_;
  }

 private:
  template <class Below>
  Names names(const Below& below, std::string FigureKey::*level) const {
    Names found;
    for (const CheckFigure& figure : figures_) {
      const std::string& name = figure.key.*level;
      if (below(figure.key) && std::find(found.begin(), found.end(), name) == found.end()) {
        found.push_back(name);
      }
    }
    return found;
  }

  void read_learned() {
    const std::optional<TomlTable> learned = reader_.child_if_present(reader_.root(), kLearned);
    if (!learned) {
      return;
    }
    reader_.refuse_unknown(*learned, std::vector<std::string>{"seeds"});
    const toml::node *seeds = learned->table->get("seeds");
    if (seeds == nullptr || !seeds->is_integer() || *seeds->value<int>() < 1) {
      reader_.fail(*learned, "seeds", "is not a number of seeds", "give a whole number, at least 1");
    }
    limits_.for_seeds = *seeds->value<int>();
  }

  void read_scenario(const std::string& scenario) {
    FigureKey key{scenario, "", "", ""};
    Names known = names([](const FigureKey&) { return true; }, &FigureKey::scenario);
    known.emplace_back(kLearned);
    refuse(reader_.root(), scenario, known, "scenario");
    const TomlTable of_scenario = reader_.child(reader_.root(), scenario);
    const auto in_scenario = [&](const FigureKey& k) { return k.scenario == key.scenario; };
    for (const auto& [case_name, case_node] : *of_scenario.table) {
      key.case_name = case_name.str();
      refuse(of_scenario, key.case_name, names(in_scenario, &FigureKey::case_name), "case");
      const TomlTable of_case = reader_.child(of_scenario, key.case_name);
      const auto in_case = [&](const FigureKey& k) { return in_scenario(k) && k.case_name == key.case_name; };
      for (const auto& [axis, axis_node] : *of_case.table) {
        key.axis = axis.str();
        refuse(of_case, key.axis, names(in_case, &FigureKey::axis), "axis");
        read_axis(reader_.child(of_case, key.axis), key);
      }
    }
  }

  void read_axis(const TomlTable& table, FigureKey key) {
    const auto in_axis = [&](const FigureKey& k) {
      return k.scenario == key.scenario && k.case_name == key.case_name && k.axis == key.axis;
    };
    for (const auto& [name, node] : *table.table) {
      key.name = name.str();
      refuse(table, key.name, names(in_axis, &FigureKey::name), "figure");
      const TomlTable bounds = reader_.child(table, key.name);
      for (const auto& [bound_name, value] : *bounds.table) {
        refuse(bounds, std::string(bound_name.str()), {"max", "min"}, "limit");
      }
      Limit limit{key, bound(bounds, "min"), bound(bounds, "max"), reader_.lines().place(bounds.path)};
      if (!limit.min && !limit.max) {
        reader_.fail(table, key.name, "has no limit", "give { max = ... }, { min = ... } or both");
      }
      if (limit.min && limit.max && *limit.min > *limit.max) {
        reader_.fail(bounds, "min", fmt::format("{:g} is above max = {:g}", *limit.min, *limit.max),
                     "exchange the two or widen the range");
      }
      limits_.values.push_back(limit);
    }
  }

  std::optional<double> bound(const TomlTable& table, const char *name) const {
    const toml::node *node = table.table->get(name);
    if (node == nullptr) {
      return std::nullopt;
    }
    if (!node->is_number() || !std::isfinite(*node->value<double>())) {
      reader_.fail(table, name, "is not a finite number", "give a number in the figure's unit");
    }
    return *node->value<double>();
  }

  void refuse(const TomlTable& table, const std::string& name, const Names& known, const char *what) const {
    if (std::find(known.begin(), known.end(), name) == known.end()) {
      reader_.fail(table, name, fmt::format("is not a {} of this check", what),
                   fmt::format("give one of: {}", fmt::join(known, "; ")));
    }
  }

  void require_every_scenario() const {
    for (const std::string& scenario : names([](const FigureKey&) { return true; }, &FigureKey::scenario)) {
      const bool limited = std::any_of(limits_.values.begin(), limits_.values.end(),
                                       [&](const Limit& limit) { return limit.key.scenario == scenario; });
      if (!limited) {
        throw reader_.lines().error(scenario, "has no limits, so nothing of it would be checked",
                                    "add limits; --learn FILE writes limits for every figure");
      }
    }
  }

  TomlReader reader_;
  const std::vector<CheckFigure>& figures_;
  bool subset_;
  Limits limits_;
};

constexpr double kStandardErrors = 6.0;
constexpr double kMinShare = 0.05;

// Change that a figure may always have: a tick, or half a per cent of a step.
double min_width(const CheckFigure& figure) {
  const double step = figure.unit == "ms" ? 1.0 : figure.unit == "%" ? 0.5 : 0.0;
  return std::max(step, kMinShare * std::abs(mean_of(figure)));
}

// Four digits, rounded away from the mean.
double rounded(double value, bool up) {
  if (value == 0.0) {
    return 0.0;
  }
  const double step = std::pow(10.0, std::floor(std::log10(std::abs(value))) - 3.0);
  return step * (up ? std::ceil(value / step) : std::floor(value / step));
}

Limit learned_limit(const CheckFigure& figure, int checked_seeds) {
  const double variance_share = 1.0 / static_cast<double>(figure.values.size()) + 1.0 / checked_seeds;
  const double scatter = kStandardErrors * standard_deviation(figure.values) * std::sqrt(variance_share);
  const double width = std::max(scatter, min_width(figure));
  const double mean = mean_of(figure);
  Limit limit{figure.key, std::nullopt, std::nullopt, ""};
  if (figure.better != Better::kHigher) {
    limit.max = rounded(mean + width, true);
  }
  if (figure.better != Better::kLower) {
    limit.min = rounded(mean - width, false);
  }
  return limit;
}

std::string quoted(const std::string& text) {
  const bool bare = !text.empty() && std::all_of(text.begin(), text.end(), [](unsigned char letter) {
    return std::isalnum(letter) != 0 || letter == '_' || letter == '-';
  });
  if (bare) {
    return text;
  }
  std::string escaped;
  for (const char letter : text) {
    escaped += letter == '"' || letter == '\\' ? std::string{'\\', letter} : std::string{letter};
  }
  return '"' + escaped + '"';
}

std::string bounds_text(const Limit& limit) {
  std::vector<std::string> bounds;
  if (limit.min) {
    bounds.push_back(fmt::format("min = {:.6g}", *limit.min));
  }
  if (limit.max) {
    bounds.push_back(fmt::format("max = {:.6g}", *limit.max));
  }
  return fmt::format("{{ {} }}", fmt::join(bounds, ", "));
}

std::string limits_text(const std::vector<CheckFigure>& figures, const Limits& limits, const std::string& what) {
  std::string text = fmt::format(
      "# Limits of sim_host check, written by --learn: {}, {} seeds. Mean and scatter of the seeds follow each "
      "limit.\n# A limit is the mean plus or minus {} standard errors of its difference to a mean over {} seeds, at "
      "least {:g} %.\n\n[{}]\nseeds = {}  # number of seeds that a check needs\n",
      what, figures.front().values.size(), kStandardErrors, *limits.for_seeds, 100.0 * kMinShare, kLearned,
      *limits.for_seeds);
  std::string table;
  for (std::size_t i = 0; i < figures.size(); ++i) {
    const FigureKey& key = figures[i].key;
    const std::string head = fmt::format("[{}.{}.{}]", quoted(key.scenario), quoted(key.case_name), quoted(key.axis));
    if (head != table) {
      text += fmt::format("\n{}\n", head);
      table = head;
    }
    text += fmt::format("{} = {}  # {:.4g} +- {:.2g}\n", key.name, bounds_text(limits.values[i]), mean_of(figures[i]),
                        standard_deviation(figures[i].values));
  }
  return text;
}

}  // namespace

const Limit *Limits::find(const FigureKey& key) const {
  const auto found = std::find_if(values.begin(), values.end(), [&](const Limit& limit) { return limit.key == key; });
  return found == values.end() ? nullptr : &*found;
}

Limits read_limits(const std::filesystem::path& file, const std::vector<CheckFigure>& figures, bool subset) {
  return LimitsReader(file, figures, subset).read();
}

Limits learn_limits(const std::vector<CheckFigure>& figures, const std::string& what, int checked_seeds,
                    const std::filesystem::path& file) {
  Limits limits{file, {}, checked_seeds};
  for (const CheckFigure& figure : figures) {
    if (!std::isfinite(mean_of(figure))) {
      throw std::runtime_error(fmt::format("no limits were written: {} has no value: {}", text_of(figure.key),
                                           figure.failure.value_or("it is not finite")));
    }
    limits.values.push_back(learned_limit(figure, checked_seeds));
  }
  std::ofstream stream(file);
  stream << limits_text(figures, limits, what);
  if (!stream.flush()) {
    throw std::runtime_error(fmt::format("{}: cannot be written; is the folder writable?", file.string()));
  }
  return limits;
}

}  // namespace trackservo::sim
