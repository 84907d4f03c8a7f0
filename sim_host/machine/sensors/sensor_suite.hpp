// SPDX-License-Identifier: Apache-2.0
// All sensors of one axis that the firmware samples once per tick: their configurations, their tables in a plant file
// and their models. The only list of them.
//
// A new sensor is a model with its configuration and keys beside it, and a line in each of the places below. Plant
// file, reference page, simulated machine and firmware then have it.
//
// Use: advance() once per PWM period, sample() once per tick.
#ifndef TRACKSERVO_SIM_SENSORS_SENSOR_SUITE_HPP
#define TRACKSERVO_SIM_SENSORS_SENSOR_SUITE_HPP

#include <cstdint>

#include "machine/base/firmware.hpp"
#include "machine/sensors/encoder.hpp"
#include "machine/sensors/gyro.hpp"

namespace trackservo::sim {

struct SensorConfigs {
  EncoderConfig encoder;
  GyroConfig gyro;
};

// Calls visit(name of the table in a plant file, its keys, the member of SensorConfigs). A table whose keys all have
// defaults may be absent.
template <class Visit>
void for_each_sensor(const Visit& visit) {
  visit("encoder", encoder_keys(), &SensorConfigs::encoder);
  visit("gyro", gyro_keys(), &SensorConfigs::gyro);
}

// What the sensors of an axis are exposed to.
struct SensedState {
  double joint_angle_rad = 0;
  double gyro_rate_rad_s = 0;  // inertial, as its mounting says
};

struct SensorSuite {
  // Makes the sensors. dt_s: time between advance() calls [s]; tick_s: between sample() calls [s].
  SensorSuite(const SensorConfigs& configs, double dt_s, double tick_s, std::uint64_t seed, int axis)
      : encoder(configs.encoder, dt_s, seed, axis), gyro(configs.gyro, dt_s, tick_s, seed, axis) {}

  void advance(const SensedState& state) {
    encoder.advance(state.joint_angle_rad);
    gyro.advance(state.gyro_rate_rad_s);
  }

  // Returns the samples of this tick. Draws noise. Motor current and camera are not its own.
  hal_axis_samples sample() {
    hal_axis_samples samples{};
    const Gyro::Reading rate = gyro.sample();
    samples.gyro_rad_s = static_cast<float>(rate.rate_rad_s);
    samples.gyro_valid = rate.valid;
    samples.joint_angle_turn32 = encoder.sample();
    return samples;
  }

  Encoder encoder;
  Gyro gyro;
};

}  // namespace trackservo::sim

#endif
