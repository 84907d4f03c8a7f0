// SPDX-License-Identifier: Apache-2.0
#include "device/simulated_node.hpp"

#include <new>

#include "machine/run/start_firmware.hpp"

namespace trackservo::sim {
namespace {

// The board's chip programs a double word in 82 us (data sheet of the STM32G474, table of flash memory
// characteristics), and its background has three quarters of each tick.
constexpr int kFlashOperationsPerTick = 9;

bool send_nowhere(void *, const can_frame *) { return true; }

}  // namespace

SimulatedNode::SimulatedNode(const NodeSetup& setup, std::uint64_t seed,
                             const std::array<double, kAxes>& joint_angle_rad, const NodeFittings& fittings)
    : setup_(setup),
      node_(std::make_unique<servo_node>()),
      fittings_(fittings),
      machine_(setup.plant, seed, joint_angle_rad) {
  if (fittings.holding_brakes) {
    machine_.fit_holding_brakes();
  }
  restart();
  machine_.run_firmware(node_->board, [this] {
    servo_node_tick(node_.get());
    servo_node_serve(node_.get());
  });
}

void SimulatedNode::restart() {
  servo_node_config config{};
  config.node_id = fittings_.node_id;
  config.sender = fittings_.sender.send != nullptr ? fittings_.sender : can_sender{send_nowhere, nullptr};
  config.machine = machine_.hal_pointer();
  config.parameters = setup_.parameters.data();
  config.limits = setup_.limits.data();
  config.flash = fittings_.flash;
  config.serial_number = fittings_.serial_number;
  config.bus = fittings_.bus;
  config.hardware_version = fittings_.hardware_version;
  config.scales = setup_.scales ? &*setup_.scales : nullptr;
  std::destroy_at(node_.get());
  new (node_.get()) servo_node{};
  start_node(*node_, config);
}

void SimulatedNode::tick() {
  machine_.advance_tick();
  for (int i = 0; i < kFlashOperationsPerTick && fittings_.flash != nullptr; ++i) {
    servo_node_background(node_.get());
  }
}

}  // namespace trackservo::sim
