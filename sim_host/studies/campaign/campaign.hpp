// SPDX-License-Identifier: Apache-2.0
// All experiments of the paper, with every controller, both friction models and several seeds: the main job.
//
// A campaign is a list of studies; each is run for every friction model, controller, case and seed, spread over
// threads. Runs are independent and seeded, so the numbers do not depend on the number of threads.
#ifndef TRACKSERVO_SIM_STUDIES_CAMPAIGN_CAMPAIGN_HPP
#define TRACKSERVO_SIM_STUDIES_CAMPAIGN_CAMPAIGN_HPP

#include <cstdint>
#include <map>
#include <string>
#include <vector>

#include "studies/margins/margin_study.hpp"
#include "studies/sensitivity/sensitivity.hpp"
#include "studies/shared/campaign_options.hpp"
#include "studies/shared/cell.hpp"
#include "studies/shared/experiment.hpp"
#include "studies/shared/identified_axis.hpp"
#include "studies/shared/study.hpp"

namespace trackservo::sim {

// A run, saved as CSV.
struct SavedRun {
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

struct Campaign {
  CampaignOptions options;
  std::vector<Experiment> experiments;
  std::vector<PlantConfig> plants;
  std::vector<IdentifiedAxis> identified;  // every axis of every plant
  std::vector<Cell> cells;
  std::vector<SavedRun> runs;
  std::vector<MarginRecord> margins;
  std::vector<SensitivityRecord> sensitivity;
  std::map<std::string, PiRequirement> best_pi;  // by study_name()
};

// Runs everything and writes the CSVs. Throws ConfigError, std::invalid_argument, std::runtime_error.
Campaign run_campaign(const CampaignOptions& options, const Progress& progress);

}  // namespace trackservo::sim

#endif
