// SPDX-License-Identifier: Apache-2.0
// An inertial sensor on the base, as an inertial navigation system of a vehicle or ship has one: its rates as the
// messages of one PDO (objects 3076:1 to :4).
//
// 100 messages a second, each 6 ms old when it arrives; the sensor's maker states 5 ms. White noise of 1e-4 rad/s
// (0.006 deg/s) in each rate, no bias, 2e-5 rad/s per count (3077:2 as delivered).
#ifndef TRACKSERVO_SIM_SENSORS_BASE_SENSOR_HPP
#define TRACKSERVO_SIM_SENSORS_BASE_SENSOR_HPP

#include <Eigen/Core>
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "machine/base/random.hpp"
#include "machine/sensors/sender_mapping.hpp"

namespace trackservo::sim {

constexpr std::uint32_t kBaseSensorCobId = 0x441;
constexpr double kBaseSensorStatedDelay_s = 5e-3;

class BaseSensor {
 public:
  BaseSensor(std::uint32_t cob_id, std::uint64_t seed) : cob_id_(cob_id), noise_(seed, "base sensor") {}

  // Returns the message that arrives now, if one does. Call once per ms, with the base's true rates in its own frame.
  std::optional<can_frame> look(const Eigen::Vector3d& base_rad_s);

 private:
  static constexpr std::size_t kDelay_ms = 6;
  static constexpr std::size_t kEvery_ms = 10;

  std::uint32_t cob_id_;
  RandomStream noise_;
  std::array<Eigen::Vector3d, kDelay_ms + 1> seen_rad_s_{};  // of the last ms
  std::size_t ms_ = 0;
  std::uint8_t counter_ = 0;
};

// Returns what a master writes so that RPDO `number` (1 to 4) takes these messages.
std::vector<ObjectWrite> base_sensor_mapping(int number, std::uint32_t cob_id);

}  // namespace trackservo::sim

#endif
