// Results of the scan of Fig. 9, for people and as a file.
#ifndef TRACKSERVO_SIM_STUDIES_FIG9_SCAN_FIG9_SCAN_REPORT_HPP
#define TRACKSERVO_SIM_STUDIES_FIG9_SCAN_FIG9_SCAN_REPORT_HPP

#include <filesystem>
#include <string>
#include <vector>

#include "studies/fig9_scan/fig9_scan.hpp"

namespace trackservo::sim {

// To the standard output.
void print(const Fig9Setup& setup, const Fig9Summary& summary);

// `folder`/fig9_scan.json: the summary, and every set that reproduces Fig. 7. Throws std::runtime_error that names the
// file.
void write_fig9_scan(const Fig9Setup& setup, const std::vector<Fig9Outcome>& outcomes, const Fig9Summary& summary,
                     const std::string& git, const std::filesystem::path& folder);

}  // namespace trackservo::sim

#endif
