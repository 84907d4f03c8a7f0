// The CSVs of a campaign's runs: their names, and how many rows they keep.
#ifndef TRACKSERVO_SIM_STUDIES_RUN_FILES_HPP
#define TRACKSERVO_SIM_STUDIES_RUN_FILES_HPP

#include <filesystem>
#include <string>
#include <vector>

#include "run/trace.hpp"

namespace trackservo::sim {

// WORD-WORD-....csv, empty words left out, letters that file names dislike replaced.
std::string file_name(const std::vector<std::string>& words);

// Writes FOLDER/file_name(words) and returns the file's name. A run that is drawn keeps up to 6000 rows, every other
// one up to 400: a campaign has about a thousand runs, and any of them comes back at full rate from `sim_host run`.
// Throws as write_csv.
std::string write_run(const Trace& trace, const std::filesystem::path& folder, const std::vector<std::string>& words,
                      bool drawn);

}  // namespace trackservo::sim

#endif
