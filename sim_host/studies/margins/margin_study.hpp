// SPDX-License-Identifier: Apache-2.0
// Stability margins of every controller on every plant: computed from the difference equations, and measured on the
// simulated machine with all its noise. It shows the cost of the observer's bandwidth.
#ifndef TRACKSERVO_SIM_STUDIES_MARGINS_MARGIN_STUDY_HPP
#define TRACKSERVO_SIM_STUDIES_MARGINS_MARGIN_STUDY_HPP

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "studies/shared/study.hpp"

namespace trackservo::sim {

struct MarginJob {
  const PlantConfig *plant;
  std::string controller;
  int axis;
  bool pre_sliding;
  std::string study;                // for which `pi` was searched; empty: the plant's own PI
  std::optional<PiRequirement> pi;  // of pi_best
  DesignOptions design;
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

// Returns jobs for every controller on every plant, the best PI of every study, both axes, sliding and pre-sliding.
// `best_pi` holds one PI for every study_name(). The plants must exist longer than the jobs.
std::vector<MarginJob> margin_jobs_of(const std::vector<PlantConfig>& plants, const std::vector<Study>& studies,
                                      const std::map<std::string, PiRequirement>& best_pi);

// Computes, measures, and writes margins/<...>.csv below `out_dir`.
MarginRecord run_margin_job(const MarginJob& job, const std::filesystem::path& out_dir);

}  // namespace trackservo::sim

#endif
