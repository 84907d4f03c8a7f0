// SPDX-License-Identifier: Apache-2.0
// What got better or worse since an earlier run, by more than the scatter of the seeds.
//
// With the same seeds, runs are compared in pairs: wind and noise are the same, so only the change remains. A figure
// has changed when the mean difference is beyond Student's t at 0.1 % AND at least 2 % of its former value. With other
// seeds the two means are compared by Welch's t, and with one seed by the 2 % alone.
#ifndef TRACKSERVO_SIM_CHECK_COMPARISON_HPP
#define TRACKSERVO_SIM_CHECK_COMPARISON_HPP

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "check/figure.hpp"

namespace trackservo::sim {

// An earlier run, from its results.json.
struct Baseline {
  std::filesystem::path file;
  std::string git;
  std::string plant;
  std::string device;
  std::vector<std::uint64_t> seeds;
  std::vector<CheckFigure> figures;
};

enum class ChangeKind { kBetter, kWorse, kOther };

struct Change {
  FigureKey key;
  std::string unit;
  ChangeKind kind;
  double before;
  double now;
  double threshold;  // threshold of |now - before|
};

struct Comparison {
  Baseline baseline;
  bool paired = false;
  std::vector<Change> changes;         // worse ones first
  std::vector<FigureKey> only_before;  // figures of the baseline that are missing now
  std::size_t compared = 0;

  std::size_t count(ChangeKind kind) const;
};

// Throws ConfigError when the file is not the results.json of a check.
Baseline read_baseline(const std::filesystem::path& file);

Comparison compare(const Baseline& baseline, const std::vector<CheckFigure>& figures,
                   const std::vector<std::uint64_t>& seeds);

// Returns "better", "worse", "changed".
const char *change_name(ChangeKind kind);

}  // namespace trackservo::sim

#endif
