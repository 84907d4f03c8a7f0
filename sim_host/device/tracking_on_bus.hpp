// SPDX-License-Identifier: Apache-2.0
// Whether the axes of a node track, from outside: its TPDO1 and TPDO2 with the mapping as delivered (docs/can.md). A
// frame of another length has another mapping, and tells nothing: that axis does not track.
#ifndef TRACKSERVO_SIM_DEVICE_TRACKING_ON_BUS_HPP
#define TRACKSERVO_SIM_DEVICE_TRACKING_ON_BUS_HPP

#include <array>
#include <cstdint>

#include "device/bus/virtual_bus.hpp"
#include "machine/plant/truth.hpp"

namespace trackservo::sim {

class TrackingOnBus {
 public:
  // Listens to a bus with one node.
  explicit TrackingOnBus(VirtualBus& bus);
  TrackingOnBus(const TrackingOnBus&) = delete;
  TrackingOnBus& operator=(const TrackingOnBus&) = delete;
  ~TrackingOnBus() { bus_.detach(port_); }

  // Returns the states as 3072:5 and :6, of which it tells not tracking, searching and on target.
  const std::array<std::uint8_t, kAxes>& states() const { return states_; }

 private:
  void hear(const can_frame& frame);

  VirtualBus& bus_;
  std::array<std::uint8_t, kAxes> states_{};
  VirtualBus::Port port_;
};

}  // namespace trackservo::sim

#endif
