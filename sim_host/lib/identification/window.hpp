// SPDX-License-Identifier: Apache-2.0
// The window through which torque and motion are compared, so that no signal is differentiated twice.
//
// The second difference of the angle over +-T is, exactly, the acceleration under a triangle of width 2 T:
//   (a(t+T) - 2 a(t) + a(t-T)) / T^2 = integral of (1 - |s|/T)/T * a''(t+s) ds
// So torque and friction are averaged under the same triangle, and J times the second difference is what is left.
#ifndef TRACKSERVO_IDENTIFICATION_WINDOW_HPP
#define TRACKSERVO_IDENTIFICATION_WINDOW_HPP

#include <array>
#include <cstddef>

#include "identification/recording.hpp"

namespace trackservo::identification {

constexpr std::size_t kHalfWindow = 5;  // ticks; also the distance of two windows
constexpr double kHalfWindow_s = static_cast<double>(kHalfWindow) * kTick_s;
constexpr std::size_t kWindowReach = kHalfWindow + 1;  // ticks that a window needs to each side

// Weights of the ticks i - kHalfWindow ... i + kHalfWindow + 1, whose values are means since the previous tick.
//
// Within a tick both the triangle and the signal have a slope, and the mean of a product is not the product of the
// means: slope times slope times dt^2/12 is missing. With the signal's slope taken from the neighbouring ticks this is
// a 24th of a tick's weight at the triangle's corners. Without it, 0.5 % of a torque at 40 Hz is lost, and the same of
// J.
constexpr std::array<double, 2 * kWindowReach> triangle_weights() {
  std::array<double, 2 * kWindowReach> weights{};
  constexpr double kWidth = static_cast<double>(kHalfWindow);
  constexpr double kCorner = 1.0 / (24.0 * kWidth * kWidth);
  for (std::size_t i = 0; i < kHalfWindow; ++i) {
    const double weight = (static_cast<double>(i) + 0.5) / (kWidth * kWidth);
    // cppcheck takes the size for that of another constant.
    weights[1 + i] = weight;                // cppcheck-suppress containerOutOfBounds
    weights[2 * kHalfWindow - i] = weight;  // cppcheck-suppress containerOutOfBounds
  }
  for (const std::size_t i : {std::size_t{0}, std::size_t{1}, 2 * kHalfWindow, 2 * kHalfWindow + 1}) {
    weights[i] -= kCorner;
  }
  for (const std::size_t i : {kHalfWindow, kHalfWindow + 1}) {
    weights[i] += 2.0 * kCorner;
  }
  return weights;
}
constexpr std::array<double, 2 *kWindowReach> kTriangle = triangle_weights();

// Mean under the triangle around tick i of a series of means since the previous tick.
template <class Series>
double triangle_mean(const Series& series, std::size_t i) {
  double sum = 0;
  for (std::size_t j = 0; j < kTriangle.size(); ++j) {
    sum += kTriangle[j] * series[i + j - kHalfWindow];
  }
  return sum;
}

// Mean under the same triangle of the second derivative of a series of values at the ticks.
template <class Series>
double triangle_second_derivative(const Series& series, std::size_t i) {
  return (series[i + kHalfWindow] - 2.0 * series[i] + series[i - kHalfWindow]) / (kHalfWindow_s * kHalfWindow_s);
}

// The same of the first derivative: the difference of the means on both sides.
template <class Series>
double triangle_derivative(const Series& series, std::size_t i) {
  double after = 0.5 * (series[i + kHalfWindow] - series[i - kHalfWindow]);  // ends count half; the middle cancels
  for (std::size_t j = 1; j < kHalfWindow; ++j) {
    after += series[i + j] - series[i - j];
  }
  return after / (static_cast<double>(kHalfWindow) * kHalfWindow_s);
}

}  // namespace trackservo::identification

#endif
