// SPDX-License-Identifier: Apache-2.0
#include "device/tracking_on_bus.hpp"

extern "C" {
#include "drive/drive_axis.h"
}

namespace trackservo::sim {
namespace {

constexpr std::uint32_t kFunction = 0x780;  // of an identifier; the rest is the node id
constexpr std::array<std::uint32_t, kAxes> kTpdo = {0x180, 0x280};
constexpr std::uint8_t kStateLength = 7;      // statusword, mode of operation, error code, torque
constexpr std::uint8_t kTrackingMode = 0xFF;  // -1
constexpr unsigned kStateBits = 0x6F;
constexpr unsigned kOperationEnabled = 0x27;
constexpr unsigned kTargetReached = 1U << 10;

std::uint8_t state_of(const can_frame& frame) {
  const unsigned statusword = frame.data[0] | static_cast<unsigned>(frame.data[1]) << 8;
  if (frame.length != kStateLength || frame.data[2] != kTrackingMode ||
      (statusword & kStateBits) != kOperationEnabled) {
    return DRIVE_NOT_TRACKING;
  }
  return (statusword & kTargetReached) != 0 ? DRIVE_ON_TARGET : DRIVE_SEARCHING;
}

}  // namespace

TrackingOnBus::TrackingOnBus(VirtualBus& bus)
    : bus_(bus), port_(bus.attach([this](const can_frame& frame) { hear(frame); })) {}

void TrackingOnBus::hear(const can_frame& frame) {
  for (std::size_t axis = 0; axis < states_.size(); ++axis) {
    if ((frame.id & kFunction) == kTpdo.at(axis)) {
      states_.at(axis) = state_of(frame);
    }
  }
}

}  // namespace trackservo::sim
