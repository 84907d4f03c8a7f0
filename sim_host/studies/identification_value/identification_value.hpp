// SPDX-License-Identifier: Apache-2.0
// The value of identification: the compensated figures of the first table of docs/results.md with friction parameters
// that were identified, that are the plant's own, and that are each wrong by a share.
//
// Runs are paired: at a seed all three have the same noise and wind. Each seed draws other signs of the errors, so many
// seeds show the effect of wrong parameters on average and at worst.
#ifndef TRACKSERVO_SIM_STUDIES_IDENTIFICATION_VALUE_IDENTIFICATION_VALUE_HPP
#define TRACKSERVO_SIM_STUDIES_IDENTIFICATION_VALUE_IDENTIFICATION_VALUE_HPP

#include <filesystem>
#include <string>
#include <vector>

#include "studies/shared/campaign_options.hpp"

namespace trackservo::sim {

// A mean over the seeds and its own standard error; of a sum, or of a paired difference.
struct Estimate {
  double mean = 0;
  double standard_error = 0;
};

// One figure with PI, observer and friction feedforward, of azimuth; one value per seed in each list.
struct AssumedPlantFigure {
  std::string experiment;
  std::string case_name;
  std::string metric;
  std::string unit;
  std::vector<double> identified;
  std::vector<double> exact;
  std::vector<double> wrong;
};

// All figures as shares of their mean with wrong parameters, so that with those the sum is the number of figures.
struct AssumedPlantSum {
  Estimate identified;
  Estimate exact;
  Estimate wrong;
  Estimate identified_less_wrong;  // paired by seed
  Estimate identified_less_exact;
  double worst_identified = 0;  // each figure's worst seed instead of its mean
  double worst_exact = 0;
  double worst_wrong = 0;
};

struct AssumedPlantStudy {
  std::vector<AssumedPlantFigure> figures;
  AssumedPlantSum sum;
};

// Returns identified minus wrong, as a share of the mean with wrong parameters; paired by seed.
Estimate gain_of(const AssumedPlantFigure& figure);

// Sums over figures that have equally many values, at least two.
AssumedPlantSum sum_of(const std::vector<AssumedPlantFigure>& figures);

// Identifies both axes of the plants, then runs all. Throws like run_campaign.
AssumedPlantStudy run_assumed_plant_study(const CampaignOptions& options, const Progress& progress);

// Prints the study to the standard output.
void print(const AssumedPlantStudy& study);

// Writes `file`, which docs/results-format.md describes. Throws std::runtime_error that names it.
void write_assumed_plant_study(const AssumedPlantStudy& study, const CampaignOptions& options, const std::string& git,
                               const std::filesystem::path& file);

}  // namespace trackservo::sim

#endif
