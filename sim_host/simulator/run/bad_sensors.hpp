// SPDX-License-Identifier: Apache-2.0
// Sensors with the faults of `BadReadings`: slow, stale, intermittent, garbage.
#ifndef TRACKSERVO_SIM_RUN_BAD_SENSORS_HPP
#define TRACKSERVO_SIM_RUN_BAD_SENSORS_HPP

#include <array>
#include <cstdint>

#include "base/random.hpp"
#include "run/broken_parts.hpp"

namespace trackservo::sim {

constexpr std::size_t kReadings = 64;  // remembered, more than any reading is late

// Encoder and gyro of one axis.
class BadSensors {
 public:
  BadSensors(std::uint64_t seed, int axis) : random_(seed, "broken.sensors", axis) {}

  // One tick: changes the samples as the faults of this axis say.
  void apply(const BrokenAxis& broken, hal_axis_samples *samples);

 private:
  RandomStream random_;
  std::size_t tick_ = 0;
  std::array<std::uint32_t, kReadings> angles_{};
  std::array<float, kReadings> rates_rad_s_{};
};

// A converter of the board: of a current, or of the bus.
class BadConverter {
 public:
  // `lowest` and `highest` are the ends of its range.
  BadConverter(std::uint64_t seed, const char *name, int axis, double lowest, double highest)
      : random_(seed, name, axis), lowest_(lowest), highest_(highest) {}

  // One PWM period: what it gives for a reading.
  double apply(const BadReadings& bad, double reading) {
    count_++;
    readings_[count_ % kReadings] = reading;
    if (!bad.are_good()) {
      return worsened(bad);
    }
    given_ = reading;
    return given_;
  }

 private:
  double worsened(const BadReadings& bad);

  RandomStream random_;
  double lowest_;
  double highest_;
  std::size_t count_ = 0;
  std::array<double, kReadings> readings_{};
  double given_ = 0.0;
};

}  // namespace trackservo::sim

#endif
