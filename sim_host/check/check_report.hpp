// SPDX-License-Identifier: Apache-2.0
// All results of a check, as its outputs need them.
#ifndef TRACKSERVO_SIM_CHECK_CHECK_REPORT_HPP
#define TRACKSERVO_SIM_CHECK_CHECK_REPORT_HPP

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "check/comparison.hpp"
#include "check/verdict.hpp"

namespace trackservo::sim {

struct CheckReport {
  std::string git;
  std::string plant;   // its name
  std::string gains;   // the file, or "of a new device"
  std::string device;  // "this build's firmware", or the image
  std::string limits;  // the file; empty when they were learned
  std::vector<std::uint64_t> seeds;
  std::vector<JudgedFigure> figures;
  std::optional<Comparison> comparison;
  bool worse_is_red = true;

  // Returns whether changes for the worse since the baseline fail the check.
  bool red_by_baseline() const { return comparison && worse_is_red && comparison->count(ChangeKind::kWorse) > 0; }
  bool kept() const { return all_kept(figures) && !red_by_baseline(); }
};

// Prints to the standard output: a line per figure, changes since the baseline, and the missed limits at the end.
void print(const CheckReport& report);

// Throws std::runtime_error that names the file.
void write_junit(const CheckReport& report, const std::filesystem::path& file);
void write_page(const CheckReport& report, const std::filesystem::path& file);

// Returns "worse: steady_speed, 0.1 deg/s, azimuth: rms_error_deg_s 0.0022 -> 0.0031 deg/s (+41 %)"
std::string text_of(const Change& change);

}  // namespace trackservo::sim

#endif
