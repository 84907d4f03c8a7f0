// SPDX-License-Identifier: Apache-2.0
// The effect of our choices: the same runs with one choice changed, or with one disturbance switched off.
//
// Some choices of plant, scenario and design were made after the compensated figures had been seen (decision 0006). So
// that they can be checked, each is varied here and its figure is beside the shipped one, compared with the same goal.
// Switching sources off shows the contributions to the errors.
#ifndef TRACKSERVO_SIM_STUDIES_SENSITIVITY_SENSITIVITY_HPP
#define TRACKSERVO_SIM_STUDIES_SENSITIVITY_SENSITIVITY_HPP

#include <functional>
#include <string>
#include <vector>

#include "studies/shared/campaign_options.hpp"
#include "studies/shared/cell.hpp"
#include "studies/shared/experiment.hpp"

namespace trackservo::sim {

struct Variation {
  std::string name;   // what is varied
  bool switches_off;  // a source of error, to show its share; otherwise a choice that could have been different
  std::vector<CaseFigures> looked_at;
  std::function<std::string(const Study&)> setting;  // its value for people, of azimuth
  std::function<void(Study&)> change;                // from shipped to varied
};

std::vector<Variation> variations(const std::vector<Experiment>& experiments);

// One figure with one choice changed, beside the same figure as shipped (same controller, same seeds).
struct SensitivityRecord {
  std::string variation;
  bool switches_off = false;  // a source of error; otherwise a choice
  std::string shipped_setting;
  std::string varied_setting;
  Cell varied;
  Cell shipped;
};

// A variation at one of its cases, with one controller: the runs of all seeds.
struct SensitivityJob {
  const Variation *variation;
  const CaseFigures *figures;
  std::string controller;
};

// Returns the jobs of the variations, which must exist longer than the jobs.
std::vector<SensitivityJob> sensitivity_jobs(const std::vector<Variation>& variations);

// Runs the job and writes its CSVs below out_dir. Azimuth's figures of the case, as records whose `shipped` is still
// empty. Throws std::invalid_argument when no study has the case.
std::vector<SensitivityRecord> run_sensitivity_job(const SensitivityJob& job, const std::vector<Study>& studies,
                                                   const CampaignOptions& options);

}  // namespace trackservo::sim

#endif
