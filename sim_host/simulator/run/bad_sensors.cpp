#include "run/bad_sensors.hpp"

namespace trackservo::sim {
namespace {

constexpr double kGarbage_rad_s = 8.0;  // within the gyro's range

}  // namespace

std::size_t BadSensors::shown(const BadReadings& bad) const {
  const std::size_t late = static_cast<std::size_t>(bad.late_ticks) + tick_ % static_cast<std::size_t>(bad.repeats);
  return (tick_ - (late < tick_ ? late : tick_)) % kHistory;
}

void BadSensors::apply(const BrokenAxis& broken, hal_axis_samples *samples) {
  tick_++;
  angles_[tick_ % kHistory] = samples->joint_angle_turn32;
  rates_rad_s_[tick_ % kHistory] = samples->gyro_rad_s;
  samples->joint_angle_turn32 = angles_[shown(broken.encoder)];
  samples->gyro_rad_s = rates_rad_s_[shown(broken.gyro)];
  if (chance(broken.encoder.garbage_share)) {
    samples->joint_angle_turn32 = static_cast<std::uint32_t>(0x1.0p32 * random_.uniform());
  }
  if (chance(broken.gyro.garbage_share)) {
    samples->gyro_rad_s = static_cast<float>(kGarbage_rad_s * (2.0 * random_.uniform() - 1.0));
  }
  samples->encoder_failed = samples->encoder_failed || chance(broken.encoder.lost_share);
  samples->gyro_valid = samples->gyro_valid && !chance(broken.gyro.lost_share);
}

}  // namespace trackservo::sim
