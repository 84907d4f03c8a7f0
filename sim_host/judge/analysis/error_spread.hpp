// SPDX-License-Identifier: Apache-2.0
// Standard deviation of the errors of both axes, taken in one by one.
#ifndef TRACKSERVO_SIM_ANALYSIS_ERROR_SPREAD_HPP
#define TRACKSERVO_SIM_ANALYSIS_ERROR_SPREAD_HPP

#include <array>
#include <cstddef>

#include "machine/base/axis.hpp"

namespace trackservo::sim {

class ErrorSpread {
 public:
  void add(const std::array<double, kAxes>& error_rad);

  // Returns 0 before the first error.
  std::array<double, kAxes> sigma_rad() const;
  double sigma_urad(std::size_t axis) const { return 1e6 * sigma_rad()[axis]; }

 private:
  int count_ = 0;
  std::array<double, kAxes> mean_rad_{};
  std::array<double, kAxes> squares_rad2_{};
};

}  // namespace trackservo::sim

#endif
