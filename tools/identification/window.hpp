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

// Weights of the ticks i - kHalfWindow + 1 ... i + kHalfWindow, whose values are means since the tick before.
constexpr std::array<double, 2 * kHalfWindow> triangle_weights() {
  std::array<double, 2 * kHalfWindow> weights{};
  constexpr double kWidth = static_cast<double>(kHalfWindow);
  for (std::size_t i = 0; i < kHalfWindow; ++i) {
    const double weight = (static_cast<double>(i) + 0.5) / (kWidth * kWidth);
    weights[i] = weight;
    weights[2 * kHalfWindow - 1 - i] = weight;
  }
  return weights;
}
constexpr std::array<double, 2 *kHalfWindow> kTriangle = triangle_weights();

// Mean under the triangle around tick i of a series of means since the tick before.
template <class Series>
double triangle_mean(const Series& series, std::size_t i) {
  double sum = 0;
  for (std::size_t j = 0; j < kTriangle.size(); ++j) {
    sum += kTriangle[j] * series[i + 1 + j - kHalfWindow];
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
