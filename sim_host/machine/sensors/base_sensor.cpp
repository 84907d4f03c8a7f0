// SPDX-License-Identifier: Apache-2.0
#include "machine/sensors/base_sensor.hpp"

namespace trackservo::sim {
namespace {

constexpr double kNoise_rad_s = 1e-4;
constexpr double kCount_rad_s = 2e-5;
constexpr std::uint16_t kMessageObject = 0x3076;

}  // namespace

std::optional<can_frame> BaseSensor::look(const Eigen::Vector3d& base_rad_s) {
  seen_rad_s_[ms_ % seen_rad_s_.size()] = base_rad_s;
  ++ms_;
  if (ms_ < seen_rad_s_.size() || ms_ % kEvery_ms != 0) {
    return std::nullopt;
  }
  const Eigen::Vector3d& measured = seen_rad_s_[ms_ % seen_rad_s_.size()];  // the oldest
  can_frame frame{};
  frame.id = cob_id_;
  frame.length = 7;
  for (std::size_t i = 0; i < 3; ++i) {
    const double rate_rad_s = measured[static_cast<Eigen::Index>(i)] + kNoise_rad_s * noise_.normal();
    put_word(frame, 2 * i, counts_of(rate_rad_s, kCount_rad_s));
  }
  frame.data[6] = ++counter_;
  return frame;
}

std::vector<ObjectWrite> base_sensor_mapping(int number, std::uint32_t cob_id) {
  return sender_mapping(number, cob_id, kMessageObject, {16, 16, 16, 8});
}

}  // namespace trackservo::sim
