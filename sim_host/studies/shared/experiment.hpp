// SPDX-License-Identifier: Apache-2.0
// An experiment of the paper: one folder below sim_host/studies with scenario.toml and experiment.toml.
//
// experiment.toml holds what the simulator and the report must know: plant, controllers' loops, figures of merit, the
// paper's figures, the goals and the plots. Every folder that holds one is an experiment; no list names them. The
// simulator reads everything but the plots, which tools/report reads.
#ifndef TRACKSERVO_SIM_STUDIES_SHARED_EXPERIMENT_HPP
#define TRACKSERVO_SIM_STUDIES_SHARED_EXPERIMENT_HPP

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "studies/shared/study.hpp"

namespace trackservo::sim {

// A figure that the paper prints.
struct PaperFigure {
  std::string source;
  std::string case_name;  // empty: every case
  std::string metric;
  std::optional<double> uncompensated;
  std::optional<double> compensated;
  std::optional<double> within_percent;  // PI alone reproduces `uncompensated` when it is this near
};

// A goal for azimuth on LuGre friction. Without low and high: the band of the paper's figure, for PI alone.
struct GoalEntry {
  std::string controller;
  std::string case_name;  // empty: every case
  std::string metric;
  std::optional<double> low;
  std::optional<double> high;
  int decimals = 3;   // of the goal's text
  std::string basis;  // how it was chosen
};

// Figures of one case that other studies compare.
struct CaseFigures {
  std::string experiment;
  std::string case_name;
  std::vector<std::string> metrics;
};

struct Experiment {
  std::string name;   // of the folder
  std::string title;  // in tables
  int order = 0;      // place among the experiments; those of the paper have the number of their figure
  std::string plant;
  std::string figure;
  std::string metric;  // the figure of merit that decides
  std::vector<std::string> derived;
  std::vector<CaseFigures> compared;
  std::vector<PaperFigure> paper;
  std::vector<GoalEntry> goals;
  std::vector<Study> studies;  // one for each tracking loop
};

// Reads all experiments of the folder studies/ in data_dir, in their order. A data folder without studies/ has the
// shipped experiments (shipped_dir) on its own plants. DATA/scenarios/NAME.toml, where present, is the scenario of the
// experiment NAME. Throws ConfigError.
std::vector<Experiment> load_experiments(const std::filesystem::path& data_dir,
                                         const std::filesystem::path& shipped_dir = {});

// Throws std::invalid_argument when there is none of this name.
const Experiment& experiment_named(const std::string& name, const std::vector<Experiment>& experiments);

// Returns the studies of all experiments.
std::vector<Study> studies_of(const std::vector<Experiment>& experiments);

// Returns the plants of the studies, each once.
std::vector<PlantConfig> plants_of(const std::vector<Study>& studies);

// Returns the paper's figure for a case, if it prints one.
const PaperFigure *paper_figure(const std::vector<PaperFigure>& paper, const std::string& case_name,
                                const std::string& metric);

// Returns what the experiment's folder says to compare of the case. Throws std::invalid_argument when it says nothing.
const CaseFigures& compared_figures(const std::string& experiment, const std::string& case_name,
                                    const std::vector<Experiment>& experiments);

// Returns the study with this case; the studies of one experiment differ in their cases. Throws std::invalid_argument
// when there is none.
std::pair<const Study *, StudyCase> find_case(const CaseFigures& figures, const std::vector<Study>& studies);

}  // namespace trackservo::sim

#endif
