// SPDX-License-Identifier: Apache-2.0
// The firmware's node and the simulated machine that it runs.
#ifndef TRACKSERVO_SIM_DEVICE_SIMULATED_NODE_HPP
#define TRACKSERVO_SIM_DEVICE_SIMULATED_NODE_HPP

#include <array>
#include <cstdint>
#include <memory>

#include "device/node_setup.hpp"
#include "machine/run/machine.hpp"

extern "C" {
#include "node/servo_node.h"
}

namespace trackservo::sim {

// What a node has besides its machine.
struct NodeFittings {
  can_sender sender{};               // receives the node's frames; without `send` they are dropped
  const hal_flash *flash = nullptr;  // areas of the parameter store (device/flash_memory.hpp); NULL: in RAM only
  bool holding_brakes = false;       // of the plant file
  std::uint8_t node_id = 1;          // 1 .. 127, or 255: none; while LSS has stored no other
  std::uint32_t serial_number = 0;
  servo_node_bus bus{};
  const char *hardware_version = "host";
};

class SimulatedNode {
 public:
  // Keeps references to `setup` and to what `fittings` points to, which must exist longer than the node. Throws
  // std::runtime_error for a node id, bit rate, gains or limits out of range.
  SimulatedNode(const NodeSetup& setup, std::uint64_t seed, const std::array<double, kAxes>& joint_angle_rad,
                const NodeFittings& fittings = {});

  // Starts the controller again with empty memory, as after a power cycle; the machine stays where it is.
  void restart();

  // Runs the node's tick, its deferred task and the machine for 1 ms, and then the background's work of this time.
  void tick();

  // Takes a frame from the bus, as in the receive interrupt.
  void receive(const can_frame& frame) { servo_node_receive(node_.get(), &frame); }

  Machine& machine() { return machine_; }
  const Machine& machine() const { return machine_; }
  servo_node& node() { return *node_; }
  const servo_node& node() const { return *node_; }

 private:
  const NodeSetup& setup_;
  std::unique_ptr<servo_node> node_;
  NodeFittings fittings_;
  Machine machine_;
};

}  // namespace trackservo::sim

#endif
