// SPDX-License-Identifier: Apache-2.0
// Figures that compare two cells: the reduction relative to PI alone, and the overshoot relative to that of the
// friction-free machine, as a difference and as a ratio.
#ifndef TRACKSERVO_SIM_STUDIES_SHARED_DERIVED_HPP
#define TRACKSERVO_SIM_STUDIES_SHARED_DERIVED_HPP

#include <vector>

#include "studies/shared/cell.hpp"
#include "studies/shared/experiment.hpp"

namespace trackservo::sim {

// Their names, as experiment.toml asks for them.
inline constexpr const char *kReduction = "reduction";                              // of the peak error
inline constexpr const char *kAboveFrictionFree = "overshoot_above_friction_free";  // difference
inline constexpr const char *kOverFrictionFree = "overshoot_over_friction_free";    // ratio

// A ratio to less than this overshoot is meaningless [%].
constexpr double kMinFreeOvershoot = 1.0;

// Returns the campaign's cells followed by the derived ones, seed by seed.
std::vector<Cell> with_derived(const std::vector<Cell>& cells, const std::vector<Experiment>& experiments);

}  // namespace trackservo::sim

#endif
