// Stability margins of every controller on every plant: computed from the difference equations, and measured on the
// simulated machine with all its noise. The price of the observer's bandwidth is read here.
#ifndef TRACKSERVO_SIM_EXPERIMENTS_MARGIN_STUDY_HPP
#define TRACKSERVO_SIM_EXPERIMENTS_MARGIN_STUDY_HPP

#include <filesystem>
#include <vector>

#include "experiments/campaign.hpp"

namespace trackservo::sim {

struct MarginJob {
  const PlantConfig *plant;
  std::string controller;
  int axis;
  bool pre_sliding;
};

// Every controller but pi_best (its margins are a constraint of its search), both axes, sliding and pre-sliding.
std::vector<MarginJob> margin_jobs_of(const std::vector<PlantConfig>& plants);

// Computes, measures, and writes margins/<...>.csv below `out_dir`.
MarginRecord run_margin_job(const MarginJob& job, const std::filesystem::path& out_dir);

}  // namespace trackservo::sim

#endif
