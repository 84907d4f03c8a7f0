// SPDX-License-Identifier: Apache-2.0
// Finds the number of a plant file that has to change so that a controller can be designed, when none can be.
//
// A file with inconsistent numbers has no single wrong key. So each number that the design depends on is changed alone,
// further and further, until a controller can be designed. The number that has to change least is named first.
#ifndef TRACKSERVO_SIM_DESIGN_PLANT_REMEDY_HPP
#define TRACKSERVO_SIM_DESIGN_PLANT_REMEDY_HPP

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "machine/config/plant_config.hpp"

namespace trackservo::sim {

// A number of the plant file, in the file's unit, and the interval in which a controller can be designed while all
// other numbers stay.
struct Remedy {
  std::string key;  // dotted
  double value;
  double lowest;
  double highest;
  double change;  // factor by which the value has to change, > 1
  bool
      has_far_end;  // a controller cannot be designed beyond the other end either; false: the end is that of the search
  bool is_requirement;  // of [design.*]; false: of the machine
};

// Whether a controller can be designed for a plant.
using IsPossible = std::function<bool(const PlantConfig&)>;

// Returns the remedies that need the least change, the least first; at most three of the machine and one requirement.
// Takes some 100 ms.
std::vector<Remedy> plant_remedies(const PlantConfig& plant, int axis, const IsPossible& is_possible);

// Returns "azimuth.inertia_kg_m2 (now 0.001) 0.47 to 1260", or "at least 0.47" where the other end was not found.
std::string other_text(const Remedy& remedy);

// Returns the design error at the line of the number that has to change least, with the values that would work. Without
// a remedy the error is at the axis' table. `more` is appended.
ConfigError design_error(const PlantConfig& plant, int axis, const std::string& reason, const IsPossible& is_possible,
                         const std::string& more = "");

}  // namespace trackservo::sim

#endif
