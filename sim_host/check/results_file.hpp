// SPDX-License-Identifier: Apache-2.0
// results.json of a check: every figure with its value for each seed. The format is described in docs/ci.md.
#ifndef TRACKSERVO_SIM_CHECK_RESULTS_FILE_HPP
#define TRACKSERVO_SIM_CHECK_RESULTS_FILE_HPP

#include <filesystem>

namespace trackservo::sim {

struct CheckReport;

constexpr const char *kResultsFormat = "trackservo check 1";

// Throws std::runtime_error that names the file.
void write_results(const CheckReport& report, const std::filesystem::path& file);

}  // namespace trackservo::sim

#endif
