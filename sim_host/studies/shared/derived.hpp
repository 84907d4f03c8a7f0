// Figures that compare two cells: the reduction relative to PI alone, and the overshoot relative to that of the
// friction-free machine, as a difference and as a ratio.
#ifndef TRACKSERVO_SIM_STUDIES_SHARED_DERIVED_HPP
#define TRACKSERVO_SIM_STUDIES_SHARED_DERIVED_HPP

#include "studies/shared/cell.hpp"

namespace trackservo::sim {

// A ratio to less than this overshoot is meaningless [%].
constexpr double kMinFreeOvershoot = 1.0;

// The campaign's cells followed by the derived ones, seed by seed.
std::vector<Cell> with_derived(const std::vector<Cell>& cells);

}  // namespace trackservo::sim

#endif
