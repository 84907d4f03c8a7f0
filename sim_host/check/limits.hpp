// SPDX-License-Identifier: Apache-2.0
// The limits of a check: a TOML file with a maximum or a minimum per scenario, case, axis and figure.
//
//     [steady_speed."0.1 deg/s".azimuth]
//     rms_error_deg_s = { max = 0.0025 }
//
// The optional table [learned] says how many seeds a check must have for them. Every name must be one of the check's
// figures.
#ifndef TRACKSERVO_SIM_CHECK_LIMITS_HPP
#define TRACKSERVO_SIM_CHECK_LIMITS_HPP

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "check/figure.hpp"

namespace trackservo::sim {

struct Limit {
  FigureKey key;
  std::optional<double> min;
  std::optional<double> max;
  std::string place;  // "limits.toml:14"
};

struct Limits {
  std::filesystem::path file;
  std::vector<Limit> values;
  std::optional<int> for_seeds;  // number of seeds of the means for which they hold

  // Returns the limit of a figure; nullptr when it is not limited.
  const Limit *find(const FigureKey& key) const;
};

// Reads the limits of a check; `figures` are those of the check. With `subset`, scenarios that were not chosen may have
// limits. Throws ConfigError for unknown names, for values that are no limits, and for a scenario of the check that has
// none.
Limits read_limits(const std::filesystem::path& file, const std::vector<CheckFigure>& figures, bool subset);

// Returns limits that an unchanged plant and firmware meet with other seeds: mean and six standard errors of the
// difference of two means, and at least 5 %. Writes the file. Throws std::runtime_error when it cannot be written, or
// when a figure has no value.
Limits learn_limits(const std::vector<CheckFigure>& figures, const std::string& what, int seeds,
                    const std::filesystem::path& file);

}  // namespace trackservo::sim

#endif
