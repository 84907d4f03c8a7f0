// SPDX-License-Identifier: Apache-2.0
// A requirement beside what was measured, seed by seed: a row of the list `requirements` of results.json.
//
// Every study that judges its figures adds its rows to the file that `sim_host experiments` wrote. The worst seed
// decides.
#ifndef TRACKSERVO_SIM_STUDIES_SHARED_REQUIREMENT_HPP
#define TRACKSERVO_SIM_STUDIES_SHARED_REQUIREMENT_HPP

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

namespace trackservo::sim {

enum class Bound { kAtMost, kAtLeast };

struct Requirement {
  std::string case_name;
  std::string axis;    // "azimuth" or "pitch"; empty: of both together
  std::string metric;  // in words
  std::string unit;
  double limit;
  std::vector<double> values;  // one per seed, at least one; infinite where the event never came
  Bound bound = Bound::kAtMost;
};

// Returns the value of the worst seed.
double worst_of(const Requirement& requirement);

bool is_met(const Requirement& requirement);

// Returns "<= 2.5"
std::string goal_text(const Requirement& requirement);

// What wrote the rows.
struct RequirementSource {
  std::string command;  // "sim_host node-tracking"
  std::string git;
  std::string plant;
};

// Replaces the rows of this command in `folder`/results.json and returns true. Without that file it writes nothing and
// returns false. Throws std::runtime_error when the file is not JSON of `sim_host experiments` or cannot be written.
bool record_requirements(const RequirementSource& source, const std::vector<Requirement>& requirements,
                         const std::filesystem::path& folder);

}  // namespace trackservo::sim

#endif
