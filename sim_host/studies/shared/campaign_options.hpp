// SPDX-License-Identifier: Apache-2.0
// What every study is run with: folders, seeds, threads.
#ifndef TRACKSERVO_SIM_STUDIES_SHARED_CAMPAIGN_OPTIONS_HPP
#define TRACKSERVO_SIM_STUDIES_SHARED_CAMPAIGN_OPTIONS_HPP

#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "machine/base/job_pool.hpp"

namespace trackservo::sim {

struct CampaignOptions {
  std::filesystem::path data_dir;     // with plants/ and scenarios/
  std::filesystem::path shipped_dir;  // with studies/, for a data_dir without
  std::filesystem::path out_dir;      // results.json, runs/, margins/
  std::vector<std::uint64_t> seeds = {1, 2, 3, 4, 5};
  double friction_parameter_error = 0.15;  // of the comparison with controllers designed without identification
  int threads = usable_threads();

  // Returns whether there is one seed, which is a first look, not a result: the searches for the best PI are shortened,
  // the sensitivity is left out.
  bool quick() const { return seeds.size() == 1; }
};

// Called after every finished run: how many of how many, and what was finished.
using Progress = std::function<void(int done, int total, const std::string& what)>;

}  // namespace trackservo::sim

#endif
