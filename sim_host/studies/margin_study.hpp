// Stability margins of every controller on every plant: computed from the difference equations, and measured on the
// simulated machine with all its noise. It shows the cost of the observer's bandwidth.
#ifndef TRACKSERVO_SIM_STUDIES_MARGIN_STUDY_HPP
#define TRACKSERVO_SIM_STUDIES_MARGIN_STUDY_HPP

#include <filesystem>
#include <optional>
#include <vector>

#include "studies/campaign.hpp"

namespace trackservo::sim {

struct MarginJob {
  const PlantConfig *plant;
  std::string controller;
  int axis;
  bool pre_sliding;
  std::string study;         // for which `pi` was searched; empty: the plant's own PI
  std::optional<PiWish> pi;  // of pi_best
  DesignOptions design;
};

// Every controller on every plant, the best PI of every study, both axes, sliding and pre-sliding. The plants of the
// campaign must exist longer than the jobs.
std::vector<MarginJob> margin_jobs_of(const Campaign& campaign, const std::vector<Study>& studies);

// Computes, measures, and writes margins/<...>.csv below `out_dir`.
MarginRecord run_margin_job(const MarginJob& job, const std::filesystem::path& out_dir);

}  // namespace trackservo::sim

#endif
