// SPDX-License-Identifier: Apache-2.0
#include "judge/analysis/error_spread.hpp"

#include <cmath>

namespace trackservo::sim {

void ErrorSpread::add(const std::array<double, kAxes>& error_rad) {
  ++count_;
  for (std::size_t i = 0; i < kAxes; ++i) {
    const double change = error_rad[i] - mean_rad_[i];
    mean_rad_[i] += change / count_;
    squares_rad2_[i] += change * (error_rad[i] - mean_rad_[i]);
  }
}

std::array<double, kAxes> ErrorSpread::sigma_rad() const {
  std::array<double, kAxes> sigma{};
  for (std::size_t i = 0; i < kAxes && count_ > 0; ++i) {
    sigma[i] = std::sqrt(squares_rad2_[i] / count_);
  }
  return sigma;
}

}  // namespace trackservo::sim
