// SPDX-License-Identifier: Apache-2.0
// A CAN interface of the Linux kernel as one port of the bus.
//
// SocketCAN raw socket (Linux documentation, networking/can.rst) with error frames on: it reports bus-off, recovery and
// the error-passive state to the owner. An interface that went down is bound again when it is back.
#ifndef TRACKSERVO_SIM_BUS_SOCKETCAN_HPP
#define TRACKSERVO_SIM_BUS_SOCKETCAN_HPP

#include <chrono>
#include <cstdint>
#include <deque>
#include <functional>
#include <string>

#include "device/bus/bus_end.hpp"
#include "device/bus/virtual_bus.hpp"

namespace trackservo::sim {

// The controller's state of the wire.
enum class CanHealth { kGood, kErrorPassive, kBusOff, kRecovered, kInterfaceDown };

class SocketCan : public BusEnd {
 public:
  using HealthChanged = std::function<void(CanHealth)>;

  // Throws std::runtime_error with the remedy: no CAN in the kernel, no such interface, interface down.
  SocketCan(VirtualBus& bus, std::string interface, HealthChanged health_changed = {});
  ~SocketCan() override;

  void pump() override;
  void add_to_poll(std::vector<pollfd>& descriptors) const override;
  std::string address() const override { return "socketcan:" + interface_; }

  CanHealth health() const { return health_; }
  std::uint64_t dropped() const { return dropped_; }

 private:
  void become(CanHealth health);
  void receive();
  void take_error_frame(std::uint32_t error_class, const std::uint8_t *data);
  void transmit();
  void interface_failed();
  void try_again();

  VirtualBus& bus_;
  std::string interface_;
  HealthChanged health_changed_;
  int descriptor_ = -1;
  VirtualBus::Port port_ = -1;
  CanHealth health_ = CanHealth::kGood;
  std::deque<can_frame> from_bus_;  // to be written to the kernel
  std::uint64_t dropped_ = 0;
  std::chrono::steady_clock::time_point next_try_;
};

}  // namespace trackservo::sim

#endif
