// The servo's CANopen node on a port of a bus, with a simulated machine under it.
#ifndef TRACKSERVO_SIM_SERVE_SERVED_NODE_HPP
#define TRACKSERVO_SIM_SERVE_SERVED_NODE_HPP

#include <array>
#include <cstdint>
#include <memory>

#include "run/machine.hpp"
#include "serve/flash_memory.hpp"
#include "serve/server.hpp"

extern "C" {
#include "canopen/heard_frames.h"
#include "node/servo_node.h"
}

namespace trackservo::sim {

// Settings of a node on its bus: the defaults, while LSS has stored nothing else.
struct NodeOnBus {
  std::uint8_t node_id = 1;     // 1 .. 127, or 255: none
  std::uint16_t kbit_s = 1000;  // 125, 250, 500 or 1000
  std::uint32_t serial_number = 0;
};

class ServedNode : public ServedDevice {
 public:
  // The flash must exist longer than the node; its parameter set, if it has one, replaces the plant's gains. Throws
  // std::invalid_argument for a node id, bit rate or gains out of range. `holding_brakes`: those of the plant file are
  // fitted, and the defaults of 2060:24 and 2060:25 are their times.
  ServedNode(const PlantConfig& plant, const NodeOnBus& on_bus, std::uint64_t seed, VirtualBus& bus,
             const FlashMemory& flash, const std::array<double, kAxes>& joint_angle_rad = kServedStart_rad,
             bool holding_brakes = false);
  ~ServedNode() override;

  void tick() override;
  void process() override;
  // An interface that was down counts as a bus-off.
  void take_health(CanHealth health) override;

  // How far tracking has got in each axis, as 3072:5 and :6.
  std::array<std::uint8_t, kAxes> tracking() const;

  const Machine& machine() const { return machine_; }
  Machine& machine() { return machine_; }

 private:
  void receive(const can_frame& frame);
  static bool send(void *context, const can_frame *frame);
  static bool join(void *context, std::uint16_t kbit_s);

  VirtualBus& bus_;
  std::unique_ptr<servo_node> node_;
  VirtualBus::Port port_;
  Machine machine_;
};

}  // namespace trackservo::sim

#endif
