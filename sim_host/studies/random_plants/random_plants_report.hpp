// SPDX-License-Identifier: Apache-2.0
// Results of the random plants, in numbers, for people and as files.
#ifndef TRACKSERVO_SIM_STUDIES_RANDOM_PLANTS_RANDOM_PLANTS_REPORT_HPP
#define TRACKSERVO_SIM_STUDIES_RANDOM_PLANTS_RANDOM_PLANTS_REPORT_HPP

#include <filesystem>
#include <string>
#include <vector>

#include "studies/random_plants/random_plants.hpp"

namespace trackservo::sim {

// Peak error at one speed over all plants [deg/s].
struct ErrorDistribution {
  std::string case_name;
  double paper = 0;  // NaN when the paper has no such speed
  double median = 0;
  double percentile_95 = 0;
  double largest = 0;
  int above_paper = 0;  // plants
};

// Dependence of the worst ratio of azimuth on one number of the plant.
struct Influence {
  std::string key;
  double correlation = 0;
};

struct AxisSummary {
  std::vector<ErrorDistribution> errors;
  int above_paper = 0;         // plants, at any speed
  int unstable = 0;            // plants
  int unstable_at_zenith = 0;  // by computation
  double min_gain_margin_db = 0;
  double min_phase_margin_deg = 0;
  double max_ripple_share = 0;
  std::vector<Influence> influences;  // strongest first
};

struct RandomPlantsSummary {
  std::array<AxisSummary, kAxes> axis;
  int failing = 0;                 // plants: unstable, or azimuth above the paper's error at any speed
  int above_paper = 0;             // plants: one of the axes above the paper's error at any speed
  std::vector<std::size_t> worst;  // ten plants of azimuth, worst first, by worst_ratio
};

// Returns the summary. Memory: about 330 bytes per plant in all. The deviations are drawn again, plant by plant. Throws
// std::runtime_error when no plant has a result.
RandomPlantsSummary summary_of(const RandomPlants& tried);

// Prints the results to the standard output.
void print(const RandomPlants& tried, const RandomPlantsSummary& summary);

// Writes `folder`/random_plants.json, the summary, and `folder`/random_plants.csv, every plant with all its deviations.
// Throws std::runtime_error that names the file.
void write_random_plants(const RandomPlants& tried, const RandomPlantsSummary& summary, const std::string& git,
                         const std::filesystem::path& folder);

}  // namespace trackservo::sim

#endif
