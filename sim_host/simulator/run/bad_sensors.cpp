// SPDX-License-Identifier: Apache-2.0
#include "run/bad_sensors.hpp"

namespace trackservo::sim {
namespace {

constexpr double kGarbage_rad_s = 8.0;  // within the gyro's range

bool chance(double share, RandomStream& random) { return share > 0.0 && random.uniform() < share; }

// The place of the reading that shows instead of the newest one.
std::size_t shown(const BadReadings& bad, std::size_t newest) {
  const std::size_t late = static_cast<std::size_t>(bad.late_readings) + newest % static_cast<std::size_t>(bad.repeats);
  return (newest - (late < newest ? late : newest)) % kReadings;
}

}  // namespace

void BadSensors::apply(const BrokenAxis& broken, hal_axis_samples *samples) {
  tick_++;
  angles_[tick_ % kReadings] = samples->joint_angle_turn32;
  rates_rad_s_[tick_ % kReadings] = samples->gyro_rad_s;
  samples->joint_angle_turn32 = angles_[shown(broken.encoder, tick_)];
  samples->gyro_rad_s = rates_rad_s_[shown(broken.gyro, tick_)];
  if (chance(broken.encoder.garbage_share, random_)) {
    samples->joint_angle_turn32 = static_cast<std::uint32_t>(0x1.0p32 * random_.uniform());
  }
  if (chance(broken.gyro.garbage_share, random_)) {
    samples->gyro_rad_s = static_cast<float>(kGarbage_rad_s * (2.0 * random_.uniform() - 1.0));
  }
  samples->encoder_failed = samples->encoder_failed || chance(broken.encoder.lost_share, random_);
  samples->gyro_valid = samples->gyro_valid && !chance(broken.gyro.lost_share, random_);
}

double BadConverter::worsened(const BadReadings& bad) {
  if (!chance(bad.lost_share, random_)) {
    given_ = readings_[shown(bad, count_)];
  }
  return chance(bad.garbage_share, random_) ? lowest_ + (highest_ - lowest_) * random_.uniform() : given_;
}

}  // namespace trackservo::sim
