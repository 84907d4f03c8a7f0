// SPDX-License-Identifier: Apache-2.0
// A CAN bus inside the process, with as many nodes as it has ports.
//
// As on the wire (ISO 11898-1), each port has a queue, the lowest identifier among their heads wins, and a frame
// reaches all ports but its own after its bit time. The owner advances it in time; a bus without a bit rate delivers at
// once.
//
// A port may have its own bit rate: ports with different bit rates do not receive each other's frames. (On a real wire
// each would also destroy the other's frames. This is not simulated: such a frame takes its time and is lost.)
#ifndef TRACKSERVO_SIM_BUS_VIRTUAL_BUS_HPP
#define TRACKSERVO_SIM_BUS_VIRTUAL_BUS_HPP

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>

extern "C" {
#include "base/can_frame.h"
}

namespace trackservo::sim {

class VirtualBus {
 public:
  using Port = int;
  using Receiver = std::function<void(const can_frame&)>;

  // Sets the pacing; 0 bit/s: none. An idle bus saves up to `saved_s` of its time, for an owner that advances in steps
  // of that length: it limits the frames that come at once.
  explicit VirtualBus(double bit_rate = 1e6, double saved_s = 1e-3) : bit_rate_(bit_rate), saved_s_(saved_s) {}

  // Adds a port. The receiver must neither attach, detach nor send.
  Port attach(Receiver receiver, std::size_t queue_limit = 64);
  // Receives nothing from now on; what it has sent before still goes over the bus.
  void detach(Port port);

  // Without one, a port receives at every bit rate and sends at that of the bus.
  static constexpr double kEveryBitRate = 0;
  void set_bit_rate(Port port, double bit_rate) { nodes_.at(port).bit_rate = bit_rate; }
  double bit_rate() const { return bit_rate_; }

  // Returns false when the port's queue is full; try again after the bus has advanced.
  bool send(Port port, const can_frame& frame);
  bool has_room(Port port) const;

  // Delivers the frames that fit into this time. An idle bus does not save up more than 1 ms.
  void advance(double seconds);

  std::uint64_t frames() const { return frames_; }
  std::uint64_t bits() const { return bits_; }

  // Returns the share of the time in use, 0 .. 1, over all time advanced so far; 0 for a bus without pacing.
  double load() const;

 private:
  struct Node {
    Receiver receiver;  // empty: detached, with frames that wait
    std::deque<can_frame> queue;
    std::size_t limit;
    double bit_rate;
  };

  bool deliver_next();

  double bit_rate_;
  double saved_s_;
  double credit_s_ = 0;
  double busy_s_ = 0;
  double advanced_s_ = 0;
  std::uint64_t frames_ = 0;
  std::uint64_t bits_ = 0;
  Port next_port_ = 0;
  std::map<Port, Node> nodes_;
};

}  // namespace trackservo::sim

#endif
