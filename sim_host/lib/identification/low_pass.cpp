// SPDX-License-Identifier: Apache-2.0
#include "identification/low_pass.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "identification/recording.hpp"

namespace trackservo::identification {

namespace {

constexpr double kZeroCrossings = 3;  // of the sinc on each side: 3 Hann-windowed ones fall to the stop band in 0.6 fc

}  // namespace

LowPass::LowPass(double cutoff_hz) {
  const double turn_rad = 2.0 * kPi * cutoff_hz * kTick_s;  // of the cutoff, per tick
  const auto reach = static_cast<std::size_t>(std::ceil(kZeroCrossings * kPi / turn_rad));
  weights_.resize(reach + 1);
  double sum = 0;
  for (std::size_t i = 0; i <= reach; ++i) {
    const double angle = turn_rad * static_cast<double>(i);
    const double sinc = i == 0 ? 1.0 : std::sin(angle) / angle;
    weights_[i] = sinc * 0.5 * (1.0 + std::cos(kPi * static_cast<double>(i) / static_cast<double>(reach + 1)));
    sum += (i == 0 ? 1.0 : 2.0) * weights_[i];
  }
  for (double& weight : weights_) {
    weight /= sum;
  }
}

void LowPass::smooth(const std::vector<double>& values, std::size_t first, std::size_t last,
                     std::vector<double>& smooth) const {
  const auto begin = static_cast<std::ptrdiff_t>(first);
  const auto end = static_cast<std::ptrdiff_t>(last) - 1;
  const auto at = [&](std::ptrdiff_t i) {
    if (i >= begin && i <= end) {
      return values[static_cast<std::size_t>(i)];
    }
    const std::ptrdiff_t edge = i < begin ? begin : end;
    const std::ptrdiff_t mirror = std::min(std::max(2 * edge - i, begin), end);
    return 2.0 * values[static_cast<std::size_t>(edge)] - values[static_cast<std::size_t>(mirror)];
  };
  const auto reach = static_cast<std::ptrdiff_t>(weights_.size()) - 1;
  for (std::ptrdiff_t i = begin; i <= end; ++i) {
    const bool inside = i - reach >= begin && i + reach <= end;
    const double *middle = values.data() + i;
    double sum = weights_[0] * *middle;
    for (std::ptrdiff_t j = 1; j <= reach; ++j) {
      const double pair = inside ? middle[-j] + middle[j] : at(i - j) + at(i + j);
      sum += weights_[static_cast<std::size_t>(j)] * pair;
    }
    smooth[static_cast<std::size_t>(i)] = sum;
  }
}

}  // namespace trackservo::identification
