// SPDX-License-Identifier: Apache-2.0
#include "machine/run/bad_sensors.hpp"

#include <cmath>

#include "machine/base/axis.hpp"

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

void BadSensors::apply(const BrokenAxis& broken, std::uint32_t last_angle_turn32, hal_axis_samples *samples) {
  delay_readings(broken, samples);
  break_encoder(broken, last_angle_turn32, samples);
  break_gyro(broken, samples);
}

void BadSensors::delay_readings(const BrokenAxis& broken, hal_axis_samples *samples) {
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

void BadSensors::break_encoder(const BrokenAxis& broken, std::uint32_t last_angle_turn32, hal_axis_samples *samples) {
  samples->encoder_failed = samples->encoder_failed || broken.encoder_lost;
  if (samples->encoder_failed) {
    samples->joint_angle_turn32 = last_angle_turn32;
    return;
  }
  crept_rad_ += broken.encoder_creep_rad_s * kTick_s;
  const std::uint32_t angle_turn32 = broken_reading(broken, samples->joint_angle_turn32);
  read_angle_turn32_ = samples->joint_angle_turn32;
  if (!broken.encoder_stuck) {
    const double shift_turns = (broken.encoder_shift_rad + crept_rad_) / (2.0 * kPi);
    reported_angle_turn32_ = (broken.encoder_reversed ? 0U - angle_turn32 : angle_turn32) +
                             static_cast<std::uint32_t>(std::llround(0x1.0p32 * shift_turns));
  }
  samples->joint_angle_turn32 = reported_angle_turn32_;
}

std::uint32_t BadSensors::broken_reading(const BrokenAxis& broken, std::uint32_t angle_turn32) {
  if (broken.sensors_show_share) {
    const double seen = static_cast<double>(static_cast<std::int32_t>(angle_turn32 - shown_from_turn32_));
    const double noise = 80.0 * (noise_.uniform() - 0.5);  // 0.06 urad
    return shown_from_turn32_ + static_cast<std::uint32_t>(
                                    static_cast<std::int32_t>(std::lround(*broken.sensors_show_share * seen + noise)));
  }
  shown_from_turn32_ = angle_turn32;
  if (chance(broken.encoder_stale_share, noise_)) {
    return read_angle_turn32_;
  }
  return angle_turn32 ^ (chance(broken.encoder_bit_share, noise_) ? 1U << 16 : 0U);
}

void BadSensors::break_gyro(const BrokenAxis& broken, hal_axis_samples *samples) {
  if (!broken.gyro_stuck) {
    const double noise_rad_s = broken.sensors_show_share ? 4e-4 * (noise_.uniform() - 0.5) : 0.0;
    const double rate_rad_s = broken.sensors_show_share.value_or(1.0) * static_cast<double>(samples->gyro_rad_s) +
                              noise_rad_s + broken.gyro_shift_rad_s;
    reported_gyro_rad_s_ = broken.gyro_reads_rad_s.value_or(broken.gyro_reversed ? -rate_rad_s : rate_rad_s);
  }
  samples->gyro_rad_s = static_cast<float>(reported_gyro_rad_s_);
  samples->gyro_valid = samples->gyro_valid && !broken.gyro_lost;
}

double BadConverter::worsened(const BadReadings& bad) {
  if (!chance(bad.lost_share, random_)) {
    given_ = readings_[shown(bad, count_)];
  }
  return chance(bad.garbage_share, random_) ? lowest_ + (highest_ - lowest_) * random_.uniform() : given_;
}

}  // namespace trackservo::sim
