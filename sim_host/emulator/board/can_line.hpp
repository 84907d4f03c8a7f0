// SPDX-License-Identifier: Apache-2.0
// The FDCAN's end of the simulator's virtual bus.
#ifndef TRACKSERVO_SIM_EMULATOR_BOARD_CAN_LINE_HPP
#define TRACKSERVO_SIM_EMULATOR_BOARD_CAN_LINE_HPP

#include "chip/fdcan.hpp"
#include "device/bus/virtual_bus.hpp"

namespace trackservo::target {

class CanLine {
 public:
  CanLine(sim::VirtualBus& bus, Fdcan& controller);
  CanLine(const CanLine&) = delete;
  CanLine& operator=(const CanLine&) = delete;
  ~CanLine() { bus_.detach(port_); }

  // Moves the frames that are due; call it often enough for the three buffers.
  void pump(Instant now);

 private:
  void receive(const can_frame& frame);

  sim::VirtualBus& bus_;
  Fdcan& controller_;
  sim::VirtualBus::Port port_;
  bool is_sending_ = false;
  int restarts_ = 0;  // of the controller, so far
};

}  // namespace trackservo::target

#endif
