// SPDX-License-Identifier: Apache-2.0
// SLCAN over TCP: any number of clients at once, each a node of its own on the bus.
//
// python-can: interface="slcan", channel="socket://127.0.0.1:PORT". Port 0 selects a free one; address() returns it.
#ifndef TRACKSERVO_SIM_BUS_SLCAN_TCP_HPP
#define TRACKSERVO_SIM_BUS_SLCAN_TCP_HPP

#include <cstdint>
#include <memory>

#include "device/bus/bus_end.hpp"
#include "device/bus/slcan_line.hpp"

namespace trackservo::sim {

class SlcanTcp : public BusEnd {
 public:
  // Listens on the loopback address only, because SLCAN has no password. Throws std::system_error.
  SlcanTcp(VirtualBus& bus, std::uint16_t port);
  ~SlcanTcp() override;

  void pump() override;
  bool is_behind() const override;
  void add_to_poll(std::vector<pollfd>& descriptors) const override;
  std::string address() const override;

  std::uint16_t port() const { return port_; }
  std::size_t clients() const { return lines_.size(); }

 private:
  void accept_clients();

  VirtualBus& bus_;
  int listener_ = -1;
  std::uint16_t port_ = 0;
  std::vector<std::unique_ptr<SlcanLine>> lines_;
};

}  // namespace trackservo::sim

#endif
