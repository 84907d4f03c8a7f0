// SPDX-License-Identifier: Apache-2.0
// results.json: the campaign as data. The format is described field by field in
// tools/report/trackservo_report/results.schema.json.
#ifndef TRACKSERVO_SIM_STUDIES_CAMPAIGN_RESULTS_HPP
#define TRACKSERVO_SIM_STUDIES_CAMPAIGN_RESULTS_HPP

#include <filesystem>

#include "studies/campaign/campaign.hpp"

namespace trackservo::sim {

// Writes the file; throws std::runtime_error naming it when it cannot be written. `git` is the source's commit.
void write_results(const Campaign& campaign, const std::string& git, const std::filesystem::path& file);

}  // namespace trackservo::sim

#endif
