// SPDX-License-Identifier: Apache-2.0
#include "studies/shared/experiment.hpp"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <stdexcept>
#include <tuple>

#include "machine/config/toml_reader.hpp"
#include "studies/shared/derived.hpp"

namespace trackservo::sim {
namespace {

namespace fs = std::filesystem;

constexpr Range kAnyNumber{-1e9, 1e9};

Keys<Experiment> experiment_keys() {
  return {
      words("title", &Experiment::title, "in tables"),
      number("order", unit::kNone, {0, 1000}, &Experiment::order, "place among the experiments"),
      words("plant", &Experiment::plant, "file in plants/, without .toml"),
      words("figure", &Experiment::figure, "the paper's figure that it reproduces"),
      words("metric", &Experiment::metric, "the figure of merit that decides"),
  };
}

Keys<PaperFigure> paper_keys() {
  return {
      words("source", &PaperFigure::source, "place in the paper"),
      words("case", &PaperFigure::case_name, "absent: every case").or_absent(),
      words("metric", &PaperFigure::metric, "figure of merit"),
      number("uncompensated", unit::kNone, kAnyNumber, &PaperFigure::uncompensated, "PI alone").or_absent(),
      number("compensated", unit::kNone, kAnyNumber, &PaperFigure::compensated, "with compensation").or_absent(),
      number("within_percent", unit::kNone, {0, 100}, &PaperFigure::within_percent, "band of calibration").or_absent(),
  };
}

Keys<GoalEntry> goal_keys() {
  return {
      words("controller", &GoalEntry::controller, "which must meet it"),
      words("case", &GoalEntry::case_name, "absent: every case").or_absent(),
      words("metric", &GoalEntry::metric, "figure of merit"),
      number("low", unit::kNone, kAnyNumber, &GoalEntry::low, "met from here").or_absent(),
      number("high", unit::kNone, kAnyNumber, &GoalEntry::high, "met up to here").or_absent(),
      number("decimals", unit::kNone, {0, 6}, &GoalEntry::decimals, "of the goal's text"),
      words("basis", &GoalEntry::basis, "how it was chosen"),
  };
}

// The words of a list, each one of `allowed`.
std::vector<std::string> read_words(const TomlReader& reader, const TomlTable& table, const char *key,
                                    const std::vector<std::string>& allowed) {
  const std::string remedy = fmt::format("give a list of some of: {}", fmt::join(allowed, ", "));
  const toml::node *node = table.table->get(key);
  const toml::array *list = node != nullptr ? node->as_array() : nullptr;
  if (list == nullptr || list->empty()) {
    reader.fail(table, key, node == nullptr ? "is missing" : "is not a list with elements", remedy);
  }
  std::vector<std::string> words;
  for (const toml::node& element : *list) {
    words.push_back(element.value_or<std::string>(""));
    if (std::find(allowed.begin(), allowed.end(), words.back()) == allowed.end()) {
      reader.fail(table, key, fmt::format("holds \"{}\"", words.back()), remedy);
    }
  }
  return words;
}

void must_be_one_of(const TomlReader& reader, const TomlTable& table, const char *key, const std::string& value,
                    const std::vector<std::string>& allowed) {
  if (std::find(allowed.begin(), allowed.end(), value) == allowed.end()) {
    reader.fail(table, key, fmt::format("\"{}\" is unknown here", value),
                fmt::format("give one of: {}", fmt::join(allowed, ", ")));
  }
}

// What an entry may name: the cases and figures of merit of this experiment.
struct Names {
  std::vector<std::string> cases;
  std::vector<std::string> metrics;  // derived ones included
  std::vector<std::string> controllers;
};

Names names_of(const Experiment& experiment) {
  Names names;
  for (const Study& study : experiment.studies) {
    for (const StudyCase& study_case : cases_of(study)) {
      names.cases.push_back(study_case.name);
    }
  }
  names.metrics = metrics_of(experiment.studies.front().scenario);
  names.metrics.insert(names.metrics.end(), experiment.derived.begin(), experiment.derived.end());
  for (const ControllerSpec& controller : controller_specs()) {
    names.controllers.push_back(controller.name);
  }
  return names;
}

template <class Entry>
Entry read_entry(const TomlReader& reader, const TomlTable& table, const Keys<Entry>& keys, const Names& names) {
  Entry entry;
  reader.refuse_unknown(table, keys);
  reader.read(table, keys, entry);
  if (!entry.case_name.empty()) {
    must_be_one_of(reader, table, "case", entry.case_name, names.cases);
  }
  must_be_one_of(reader, table, "metric", entry.metric, names.metrics);
  return entry;
}

void read_compared(const TomlReader& reader, const Names& names, Experiment& experiment) {
  const Keys<CaseFigures> keys{words("case", &CaseFigures::case_name, "to compare")};
  for (const TomlTable& table : reader.children(reader.root(), "compared")) {
    reader.refuse_unknown(table, keys, {"metrics"});
    CaseFigures figures;
    reader.read(table, keys, figures);
    must_be_one_of(reader, table, "case", figures.case_name, names.cases);
    figures.experiment = experiment.name;
    figures.metrics = read_words(reader, table, "metrics", metrics_of(experiment.studies.front().scenario));
    experiment.compared.push_back(figures);
  }
}

void read_goals(const TomlReader& reader, const Names& names, Experiment& experiment) {
  for (const TomlTable& table : reader.children(reader.root(), "goal")) {
    const GoalEntry goal = read_entry(reader, table, goal_keys(), names);
    must_be_one_of(reader, table, "controller", goal.controller, names.controllers);
    if (goal.low && goal.high && *goal.low > *goal.high) {
      reader.fail(table, "low", fmt::format("{:g} is above high = {:g}", *goal.low, *goal.high), "exchange them");
    }
    const auto has_band = [&](const PaperFigure& figure) {
      return figure.metric == goal.metric && figure.uncompensated && figure.within_percent;
    };
    if (!goal.low && !goal.high &&
        (goal.controller != "pi" || std::none_of(experiment.paper.begin(), experiment.paper.end(), has_band))) {
      reader.fail(table, "high", "is missing, and so is low",
                  "give one of them, or for controller = \"pi\" a [[paper]] figure with uncompensated and "
                  "within_percent");
    }
    experiment.goals.push_back(goal);
  }
}

std::vector<FrictionModel> read_frictions(const TomlReader& reader) {
  constexpr FrictionModel kModels[] = {FrictionModel::kLugre, FrictionModel::kMaxwellSlip, FrictionModel::kNone};
  std::vector<FrictionModel> frictions;
  for (const std::string& name : read_words(reader, reader.root(), "frictions", {"lugre", "maxwell_slip", "none"})) {
    frictions.push_back(*std::find_if(std::begin(kModels), std::end(kModels),
                                      [&](auto model) { return friction_name(model) == name; }));
  }
  return frictions;
}

void read_derived(const TomlReader& reader, const std::vector<FrictionModel>& frictions, Experiment& experiment) {
  if (!reader.root().table->contains("derived")) {
    return;
  }
  experiment.derived =
      read_words(reader, reader.root(), "derived", {kReduction, kAboveFrictionFree, kOverFrictionFree});
  const bool has_free = std::find(frictions.begin(), frictions.end(), FrictionModel::kNone) != frictions.end();
  for (const std::string& name : experiment.derived) {
    if (name != kReduction && !has_free) {
      reader.fail(reader.root(), "derived", fmt::format("holds \"{}\"", name),
                  "add \"none\" to frictions, the friction-free plant that it compares with");
    }
    const std::vector<std::string> metrics = metrics_of(experiment.studies.front().scenario);
    const std::string source = name == kReduction ? "peak_error" : "overshoot";
    if (std::find(metrics.begin(), metrics.end(), source) == metrics.end()) {
      reader.fail(reader.root(), "derived", fmt::format("holds \"{}\"", name),
                  fmt::format("remove it: the scenario measures no {}", source));
    }
  }
}

fs::path scenario_of(const fs::path& data_dir, const fs::path& folder) {
  const fs::path own = data_dir / "scenarios" / (folder.filename().string() + ".toml");
  return fs::exists(own) ? own : folder / "scenario.toml";
}

void read_studies(const TomlReader& reader, const fs::path& data_dir, const fs::path& folder, Experiment& experiment) {
  const fs::path plant = data_dir / "plants" / (experiment.plant + ".toml");
  if (!fs::exists(plant)) {
    reader.fail(reader.root(), "plant", fmt::format("\"{}\": there is no {}", experiment.plant, plant.string()),
                "give the name of a file in plants/");
  }
  Study study;
  study.experiment = experiment.name;
  study.plant = load_plant(plant);
  study.scenario = load_scenario(scenario_of(data_dir, folder));
  study.figure = experiment.figure;
  study.frictions = read_frictions(reader);
  std::vector<std::string> trackers{"pi"};
  if (reader.root().table->contains("trackers")) {
    trackers = read_words(reader, reader.root(), "trackers", {"pi", "predictive"});
  }
  if (trackers.size() > 1 && study.scenario.kind != ScenarioKind::kTracking) {
    reader.fail(reader.root(), "trackers", "holds several loops", "remove it: only a scenario that tracks has them");
  }
  for (const std::string& tracker : trackers) {
    study.tracker = tracker == "pi" ? TRACKER_PI : TRACKER_PREDICTIVE;
    experiment.studies.push_back(study);
  }
}

Experiment load_experiment(const fs::path& data_dir, const fs::path& folder) {
  const TomlReader reader(folder / "experiment.toml");
  Experiment experiment;
  experiment.name = folder.filename().string();
  // The report reads the rest and checks it: tools/report/trackservo_report/experiments.py.
  reader.refuse_unknown(
      reader.root(), experiment_keys(),
      {"frictions", "trackers", "derived", "compared", "paper", "goal", "tile", "tile_order", "plot"});
  reader.read(reader.root(), experiment_keys(), experiment);
  read_studies(reader, data_dir, folder, experiment);
  read_derived(reader, experiment.studies.front().frictions, experiment);
  const Names names = names_of(experiment);
  must_be_one_of(reader, reader.root(), "metric", experiment.metric, names.metrics);
  read_compared(reader, names, experiment);
  for (const TomlTable& table : reader.children(reader.root(), "paper")) {
    experiment.paper.push_back(read_entry(reader, table, paper_keys(), names));
  }
  read_goals(reader, names, experiment);
  return experiment;
}

}  // namespace

std::vector<Experiment> load_experiments(const fs::path& data_dir, const fs::path& shipped_dir) {
  const fs::path studies = (fs::is_directory(data_dir / "studies") ? data_dir : shipped_dir) / "studies";
  std::vector<Experiment> experiments;
  if (fs::is_directory(studies)) {
    for (const fs::directory_entry& entry : fs::directory_iterator(studies)) {
      if (fs::exists(entry.path() / "experiment.toml")) {
        experiments.push_back(load_experiment(data_dir, entry.path()));
      }
    }
  }
  if (experiments.empty()) {
    throw ConfigError(fmt::format("{}: holds no experiment, give a folder with an experiment.toml", studies.string()));
  }
  std::sort(experiments.begin(), experiments.end(), [](const Experiment& a, const Experiment& b) {
    return std::tie(a.order, a.name) < std::tie(b.order, b.name);
  });
  return experiments;
}

const Experiment& experiment_named(const std::string& name, const std::vector<Experiment>& experiments) {
  const auto found =
      std::find_if(experiments.begin(), experiments.end(), [&](const auto& e) { return e.name == name; });
  if (found == experiments.end()) {
    throw std::invalid_argument(
        fmt::format("no experiment \"{0}\"; add the folder sim_host/studies/{0} with an experiment.toml", name));
  }
  return *found;
}

std::vector<Study> studies_of(const std::vector<Experiment>& experiments) {
  std::vector<Study> studies;
  for (const Experiment& experiment : experiments) {
    studies.insert(studies.end(), experiment.studies.begin(), experiment.studies.end());
  }
  return studies;
}

std::vector<PlantConfig> plants_of(const std::vector<Study>& studies) {
  std::vector<PlantConfig> plants;
  for (const Study& study : studies) {
    const auto same = [&](const PlantConfig& plant) { return plant.name == study.plant.name; };
    if (std::none_of(plants.begin(), plants.end(), same)) {
      plants.push_back(study.plant);
    }
  }
  return plants;
}

const PaperFigure *paper_figure(const std::vector<PaperFigure>& paper, const std::string& case_name,
                                const std::string& metric) {
  const auto found = std::find_if(paper.begin(), paper.end(), [&](const PaperFigure& figure) {
    return figure.metric == metric && (figure.case_name.empty() || figure.case_name == case_name);
  });
  return found == paper.end() ? nullptr : &*found;
}

const CaseFigures& compared_figures(const std::string& experiment, const std::string& case_name,
                                    const std::vector<Experiment>& experiments) {
  for (const CaseFigures& figures : experiment_named(experiment, experiments).compared) {
    if (figures.case_name == case_name) {
      return figures;
    }
  }
  throw std::invalid_argument(
      fmt::format("experiment \"{}\" compares no case \"{}\"; add it as [[compared]]", experiment, case_name));
}

std::pair<const Study *, StudyCase> find_case(const CaseFigures& figures, const std::vector<Study>& studies) {
  for (const Study& study : studies) {
    for (const StudyCase& study_case : cases_of(study)) {
      if (study.experiment == figures.experiment && study_case.name == figures.case_name) {
        return {&study, study_case};
      }
    }
  }
  throw std::invalid_argument(fmt::format("no scenario \"{}\" has the case \"{}\"; add the speed to it",
                                          figures.experiment, figures.case_name));
}

}  // namespace trackservo::sim
