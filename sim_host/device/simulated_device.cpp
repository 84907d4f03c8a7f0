// SPDX-License-Identifier: Apache-2.0
#include "device/simulated_device.hpp"

#include <optional>

extern "C" {
#include "canopen/heard_frames.h"
}

namespace trackservo::sim {
namespace {

// With the times of the plant file's brakes, if they are fitted.
NodeSetup setup_of(const PlantConfig& plant, const SimulatedDevice::Options& options) {
  NodeSetup setup = options.setup ? *options.setup : NodeSetup(plant);
  for (std::size_t axis = 0; axis < kAxes && options.holding_brakes; ++axis) {
    if (const std::optional<HoldingBrakeConfig>& brake = plant.axis[axis].holding_brake) {
      setup.limits[axis].brake_release_s = static_cast<float>(brake->release_s);
      setup.limits[axis].brake_engage_s = static_cast<float>(brake->engage_s);
    }
  }
  return setup;
}

}  // namespace

SimulatedDevice::SimulatedDevice(const PlantConfig& plant, VirtualBus& bus, const Options& options)
    : bus_(bus),
      port_(bus.attach([this](const can_frame& frame) { receive(frame); })),
      flash_(options.flash.empty() ? std::make_unique<FlashMemory>() : std::make_unique<FlashMemory>(options.flash)),
      setup_(setup_of(plant, options)),
      node_(setup_, options.seed, options.joint_angle_rad,
            {{send, this},
             flash_->areas(),
             options.holding_brakes,
             options.node_id,
             options.serial_number,
             {options.kbit_s, false, flash_->bus_pages(), {join, this}}}) {}

SimulatedDevice::~SimulatedDevice() { bus_.detach(port_); }

// Like the board's CAN controller: frames that its filters drop do not reach the node.
void SimulatedDevice::receive(const can_frame& frame) {
  if (heard_frame(&frame)) {
    can_frame received = frame;
    received.received_us = static_cast<std::uint16_t>(node_.machine().clock_us());
    node_.receive(received);
  }
}

void SimulatedDevice::pass_ms() {
  constexpr int kParts = 4;  // answers come within the millisecond, as on the board
  for (int part = 0; part < kParts; ++part) {
    bus_.advance(kTick_s / kParts);
    answer();
  }
  tick();
}

void SimulatedDevice::take_health(CanHealth health) {
  canopen_node *canopen = &node_.node().canopen;
  if (health == CanHealth::kRecovered) {
    canopen_node_bus_off_recovered(canopen);
  } else if (health == CanHealth::kGood || health == CanHealth::kErrorPassive) {
    canopen_node_error_passive(canopen, health == CanHealth::kErrorPassive);
  }
}

std::array<std::uint8_t, kAxes> SimulatedDevice::tracking() const {
  const camera_objects& objects = node_.node().tracking.objects;
  return {objects.azimuth_tracking, objects.pitch_tracking};
}

// It boots in its first tick, and receives nothing before.
bool SimulatedDevice::settle() {
  pass_ms();
  return true;
}

std::optional<double> SimulatedDevice::torque_command_nm(int axis) const {
  return static_cast<double>(node_.machine().firmware(axis).signals.torque.torque_nm);
}

bool SimulatedDevice::send(void *context, const can_frame *frame) {
  const auto *self = static_cast<const SimulatedDevice *>(context);
  return self->bus_.send(self->port_, *frame);
}

bool SimulatedDevice::join(void *context, std::uint16_t kbit_s) {
  const auto *self = static_cast<const SimulatedDevice *>(context);
  self->bus_.set_bit_rate(self->port_, 1000.0 * kbit_s);
  return true;
}

}  // namespace trackservo::sim
