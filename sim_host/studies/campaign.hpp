// All experiments of the paper, with every controller, both friction models and several seeds: the main job.
//
// A campaign is a list of studies; each is run for every friction model, controller, case and seed, spread over
// threads. Runs are independent and seeded, so the numbers do not depend on the number of threads.
#ifndef TRACKSERVO_SIM_STUDIES_CAMPAIGN_HPP
#define TRACKSERVO_SIM_STUDIES_CAMPAIGN_HPP

#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <vector>

#include "base/job_pool.hpp"
#include "studies/identified_axis.hpp"
#include "studies/study.hpp"

namespace trackservo::sim {

struct CampaignOptions {
  std::filesystem::path data_dir;  // with plants/ and scenarios/
  std::filesystem::path out_dir;   // results.json, runs/, margins/
  std::vector<std::uint64_t> seeds = {1, 2, 3, 4, 5};
  double friction_parameter_error = 0.15;  // of the comparison with controllers designed without identification
  int threads = usable_threads();

  // One seed is a first look, not a result: the searches for the best PI are shortened, the sensitivity is left out.
  bool quick() const { return seeds.size() == 1; }
};

// Called after every finished run: how many of how many, and what was finished.
using Progress = std::function<void(int done, int total, const std::string& what)>;

// Figures of one combination over all seeds.
struct Cell {
  std::string experiment;
  std::string case_name;
  std::string plant;
  FrictionModel friction;
  std::string controller;
  int axis;
  std::string metric;
  std::string unit;
  std::vector<double> values;  // one per seed
};

// A run, saved as CSV.
struct KeptRun {
  std::string experiment;
  std::string case_name;
  std::string plant;
  FrictionModel friction;
  std::string controller;
  std::uint64_t seed;
  std::string csv;  // relative to out_dir
  std::string figure;
  double settle_s;  // from the start of the trace to the analysis
};

struct MarginRecord {
  std::string plant;
  std::string controller;
  std::string study;  // for which the controller was tuned, as study_name(); empty when it serves all
  int axis;
  bool pre_sliding;
  Margins computed;
  double bandwidth_hz;
  Margins measured;  // NaN where not measured
  std::string csv;
};

// One figure with one choice changed, beside the same figure as shipped (same controller, same seeds).
struct SensitivityRecord {
  std::string variation;
  bool switches_off = false;  // a source of error; otherwise a choice
  std::string shipped_setting;
  std::string varied_setting;
  Cell varied;
  Cell shipped;
};

struct Campaign {
  CampaignOptions options;
  std::vector<PlantConfig> plants;
  std::vector<IdentifiedAxis> identified;  // every axis of every plant
  std::vector<Cell> cells;
  std::vector<KeptRun> runs;
  std::vector<MarginRecord> margins;
  std::vector<SensitivityRecord> sensitivity;
  std::map<std::string, PiWish> best_pi;  // by study_name()
};

// "steady_speed on tracker" and the like; distinguishes the two tracking loops.
std::string study_name(const Study& study);

std::string friction_name(FrictionModel model);

// The studies of the paper, from the files in data_dir. Throws ConfigError.
std::vector<Study> paper_studies(const std::filesystem::path& data_dir);

// The plants of the studies, each once.
std::vector<PlantConfig> plants_of(const std::vector<Study>& studies);

// Runs everything and writes the CSVs. Throws ConfigError, std::invalid_argument, std::runtime_error.
Campaign run_campaign(const CampaignOptions& options, const Progress& progress);

}  // namespace trackservo::sim

#endif
