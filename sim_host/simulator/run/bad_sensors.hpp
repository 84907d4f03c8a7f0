// Encoder and gyro of one axis with the faults of `BadReadings`: slow, stale, intermittent, garbage.
#ifndef TRACKSERVO_SIM_RUN_BAD_SENSORS_HPP
#define TRACKSERVO_SIM_RUN_BAD_SENSORS_HPP

#include <array>
#include <cstdint>

#include "base/random.hpp"
#include "run/broken_parts.hpp"

namespace trackservo::sim {

class BadSensors {
 public:
  BadSensors(std::uint64_t seed, int axis) : random_(seed, "broken.sensors", axis) {}

  // One tick: changes the samples as the faults of this axis say.
  void apply(const BrokenAxis& broken, hal_axis_samples *samples);

 private:
  static constexpr std::size_t kHistory = 64;  // ticks, more than any reading is late

  bool chance(double share) { return share > 0.0 && random_.uniform() < share; }
  // The tick whose reading shows now.
  std::size_t shown(const BadReadings& bad) const;

  RandomStream random_;
  std::size_t tick_ = 0;
  std::array<std::uint32_t, kHistory> angles_{};
  std::array<float, kHistory> rates_rad_s_{};
};

}  // namespace trackservo::sim

#endif
