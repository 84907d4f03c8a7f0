// SPDX-License-Identifier: Apache-2.0
// Sensors with the faults of `BrokenAxis` and `BadReadings`.
#ifndef TRACKSERVO_SIM_RUN_BAD_SENSORS_HPP
#define TRACKSERVO_SIM_RUN_BAD_SENSORS_HPP

#include <array>
#include <cstdint>

#include "machine/base/random.hpp"
#include "machine/run/broken_parts.hpp"

namespace trackservo::sim {

constexpr std::size_t kReadings = 64;  // remembered, more than any reading is late

// Encoder and gyro of one axis.
class BadSensors {
 public:
  BadSensors(std::uint64_t seed, int axis) : random_(seed, "broken.sensors", axis), noise_(seed, "broken.noise") {}

  // Changes the samples of one tick as the faults of this axis say. `last_angle_turn32` is what the firmware got
  // before.
  void apply(const BrokenAxis& broken, std::uint32_t last_angle_turn32, hal_axis_samples *samples);

 private:
  void delay_readings(const BrokenAxis& broken, hal_axis_samples *samples);
  void break_encoder(const BrokenAxis& broken, std::uint32_t last_angle_turn32, hal_axis_samples *samples);
  void break_gyro(const BrokenAxis& broken, hal_axis_samples *samples);
  std::uint32_t broken_reading(const BrokenAxis& broken, std::uint32_t angle_turn32);

  RandomStream random_;
  RandomStream noise_;
  std::size_t tick_ = 0;
  std::array<std::uint32_t, kReadings> angles_{};
  std::array<float, kReadings> rates_rad_s_{};
  // Last readings of the firmware, for sensors that are stuck.
  std::uint32_t reported_angle_turn32_ = 0;
  double reported_gyro_rad_s_ = 0;
  std::uint32_t read_angle_turn32_ = 0;  // in the last tick, before the faults
  std::uint32_t shown_from_turn32_ = 0;  // where the sensors began to show a share of the motion
  double crept_rad_ = 0;
};

// A converter of the board: of a current, or of the bus.
class BadConverter {
 public:
  // Takes `lowest` and `highest`, the ends of its range.
  BadConverter(std::uint64_t seed, const char *name, int axis, double lowest, double highest)
      : random_(seed, name, axis), lowest_(lowest), highest_(highest) {}

  // Returns what it gives for a reading, in one PWM period.
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
