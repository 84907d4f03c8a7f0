// SPDX-License-Identifier: Apache-2.0
// A delay line: stores a signal at every PWM period and returns it a fixed latency later.
//
// Linear between the stored values. Used for the latency of encoder and gyro.
#ifndef TRACKSERVO_SIM_SENSORS_HISTORY_HPP
#define TRACKSERVO_SIM_SENSORS_HISTORY_HPP

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>

namespace trackservo::sim {

class History {
 public:
  static constexpr double kLongestLatency_s = 0.01;  // 200 periods of 50 us

  // Makes a delay line. latency_s: 0..kLongestLatency_s [s]; dt_s: time between push() calls [s], at least 50 us.
  History(double latency_s, double dt_s) {
    const double periods = std::clamp(latency_s, 0.0, kLongestLatency_s) / dt_s;
    whole_ = static_cast<std::size_t>(std::floor(periods));
    fraction_ = periods - std::floor(periods);
  }

  // Fills it as if the signal had always had this value.
  void fill(double value) { values_.fill(value); }

  void push(double value) {
    newest_ = (newest_ + 1) % kLength;
    values_[newest_] = value;
  }

  // Returns the delayed value as of `periods_ago` calls of push() before; at most 50.
  double delayed(std::size_t periods_ago = 0) const {
    const std::size_t back = whole_ + periods_ago;
    const double later = values_[(newest_ + kLength - back) % kLength];
    const double earlier = values_[(newest_ + kLength - back - 1) % kLength];
    return later + fraction_ * (earlier - later);
  }

 private:
  static constexpr std::size_t kLength = 256;

  std::array<double, kLength> values_{};
  std::size_t newest_ = 0;
  std::size_t whole_ = 0;
  double fraction_ = 0;
};

}  // namespace trackservo::sim

#endif
