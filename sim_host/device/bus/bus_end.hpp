// SPDX-License-Identifier: Apache-2.0
// An entry of the process for frames: a socket, a pseudo terminal, a kernel CAN interface.
//
// An end owns one or more ports of a VirtualBus and moves frames between them and the outside. The owner of the bus
// waits on all ends with one poll() and then pumps each; nothing here blocks or starts a thread.
#ifndef TRACKSERVO_SIM_BUS_BUS_END_HPP
#define TRACKSERVO_SIM_BUS_BUS_END_HPP

#include <poll.h>

#include <string>
#include <vector>

namespace trackservo::sim {

class BusEnd {
 public:
  BusEnd() = default;
  BusEnd(const BusEnd&) = delete;
  BusEnd& operator=(const BusEnd&) = delete;
  virtual ~BusEnd() = default;

  // Moves everything that can be moved without waiting.
  virtual void pump() = 0;

  // Adds the events to wait for before the next pump.
  virtual void add_to_poll(std::vector<pollfd>& descriptors) const = 0;

  // Returns whether a client has left so many frames unread that more would soon be lost.
  virtual bool is_behind() const { return false; }

  // Returns its address for clients, for example "slcan-tcp:127.0.0.1:2901".
  virtual std::string address() const = 0;
};

}  // namespace trackservo::sim

#endif
