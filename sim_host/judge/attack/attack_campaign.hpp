// SPDX-License-Identifier: Apache-2.0
// Many seeds of random legal writes, and what they did.
#ifndef TRACKSERVO_SIM_ATTACK_ATTACK_CAMPAIGN_HPP
#define TRACKSERVO_SIM_ATTACK_ATTACK_CAMPAIGN_HPP

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "judge/attack/attack_run.hpp"
#include "machine/base/job_pool.hpp"

namespace trackservo::sim {

struct AttackOptions {
  std::uint64_t first_seed = 1;
  std::uint64_t seeds = 5000;
  int threads = usable_threads();
};

// All seeds of a theme.
struct ThemeSummary {
  Theme theme = Theme::kEverything;
  int seeds = 0;
  int writes = 0;
  int refusals = 0;
  int contacts = 0;       // seeds with any contact with an end stop
  int hard_contacts = 0;  // seeds with one faster than the limit
  int runaways = 0;
  int not_finite = 0;
  int silent = 0;
  double max_contact_rad_s = 0;
  double max_contact_nm = 0;
  double max_contact_j = 0;
  double max_rate_rad_s = 0;
};

struct AttackCampaign {
  AttackOptions options;
  std::vector<ThemeSummary> themes;   // in the order of kThemes
  std::vector<AttackResult> harmful;  // by seed

  ThemeSummary total() const;
};

// Runs the attacks. Memory: the results that did harm.
AttackCampaign run_attacks(const AttackBench& bench, const AttackOptions& options,
                           const std::function<void(int, int, const std::string&)>& progress);

std::string print(const AttackCampaign& campaign);

// Writes the file that docs/results-format.md describes.
void write_attacks(const AttackCampaign& campaign, const std::string& commit, const std::filesystem::path& file);

}  // namespace trackservo::sim

#endif
