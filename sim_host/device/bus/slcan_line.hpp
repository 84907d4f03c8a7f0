// SPDX-License-Identifier: Apache-2.0
// An SLCAN session on a file descriptor, as one port of the bus.
//
// The descriptor is a TCP connection or the master of a pseudo terminal; see slcan_session.hpp for the protocol. When a
// client sends faster than the bus can carry, its input is not read until its port has room.
#ifndef TRACKSERVO_SIM_BUS_SLCAN_LINE_HPP
#define TRACKSERVO_SIM_BUS_SLCAN_LINE_HPP

#include <poll.h>

#include <chrono>

#include "device/bus/slcan_session.hpp"
#include "device/bus/virtual_bus.hpp"

namespace trackservo::sim {

class SlcanLine {
 public:
  // Owns the descriptor, which must be non-blocking.
  SlcanLine(VirtualBus& bus, int descriptor);
  ~SlcanLine();
  SlcanLine(const SlcanLine&) = delete;
  SlcanLine& operator=(const SlcanLine&) = delete;

  // Returns false when the client has disconnected.
  bool pump();

  // Returns whether the client has left more unread than the kernel's buffers and a few frames can hold.
  bool is_behind() const;

  pollfd wanted() const;

 private:
  bool receive();
  void forward();
  bool flush();

  VirtualBus& bus_;
  int descriptor_;
  VirtualBus::Port port_;
  SlcanSession session_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace trackservo::sim

#endif
