// SPDX-License-Identifier: Apache-2.0
// The CSVs of a campaign's runs: their names, and their number of rows.
#ifndef TRACKSERVO_SIM_STUDIES_SHARED_RUN_FILES_HPP
#define TRACKSERVO_SIM_STUDIES_SHARED_RUN_FILES_HPP

#include <filesystem>
#include <string>
#include <vector>

#include "machine/run/trace.hpp"

namespace trackservo::sim {

// Returns WORD-WORD-....csv, empty words left out, letters that are not allowed in file names replaced.
std::string file_name(const std::vector<std::string>& words);

// Writes FOLDER/file_name(words) and returns the file's name. A drawn run has up to 6000 rows, every other one up to
// 400: a campaign has about a thousand runs, and `sim_host run` repeats any of them at full rate. Throws like
// write_csv.
std::string write_run(const Trace& trace, const std::filesystem::path& folder, const std::vector<std::string>& words,
                      bool drawn);

}  // namespace trackservo::sim

#endif
