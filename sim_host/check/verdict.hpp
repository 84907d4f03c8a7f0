// SPDX-License-Identifier: Apache-2.0
// Which figures meet their limits.
#ifndef TRACKSERVO_SIM_CHECK_VERDICT_HPP
#define TRACKSERVO_SIM_CHECK_VERDICT_HPP

#include <string>
#include <vector>

#include "check/figure.hpp"
#include "check/limits.hpp"

namespace trackservo::sim {

struct JudgedFigure {
  CheckFigure figure;
  double value = 0.0;    // mean over the seeds
  double scatter = 0.0;  // standard deviation over the seeds
  std::optional<Limit> limit;
  bool kept = true;     // true without a limit
  std::string problem;  // one sentence; empty when the limit is met
};

// Returns each figure with its verdict; a figure without a value meets no limit.
std::vector<JudgedFigure> judge(const std::vector<CheckFigure>& figures, const Limits& limits);

bool all_kept(const std::vector<JudgedFigure>& judged);

// Returns "max 0.0025 deg/s"; empty without a limit.
std::string limit_text(const JudgedFigure& judged);

}  // namespace trackservo::sim

#endif
