#include "serve/served_node.hpp"

#include <optional>
#include <stdexcept>

#include "dictionary/refusal_text.hpp"
#include "serve/node_parameters.hpp"

namespace trackservo::sim {
namespace {

// The board's chip programs a double word in 82 us (data sheet of the STM32G474, table of flash memory
// characteristics), and its background has three quarters of each tick.
constexpr int kFlashOperationsPerTick = 9;

protection_limits limits_of(const PlantConfig& plant, int axis, bool holding_brakes) {
  protection_limits limits = node_limits(plant, axis);
  const std::optional<HoldingBrakeConfig>& brake = plant.axis[static_cast<std::size_t>(axis)].holding_brake;
  if (holding_brakes && brake) {
    limits.brake_release_s = static_cast<float>(brake->release_s);
    limits.brake_engage_s = static_cast<float>(brake->engage_s);
  }
  return limits;
}

}  // namespace

ServedNode::ServedNode(const PlantConfig& plant, const NodeOnBus& on_bus, std::uint64_t seed, VirtualBus& bus,
                       const FlashMemory& flash, const std::array<double, kAxes>& joint_angle_rad, bool holding_brakes)
    : bus_(bus),
      node_(std::make_unique<servo_node>()),
      port_(bus.attach([this](const can_frame& frame) { receive(frame); })),
      machine_(plant, seed, joint_angle_rad) {
  const axis_parameters parameters[SERVO_AXES] = {node_parameters(plant, kAzimuth), node_parameters(plant, kPitch)};
  const protection_limits limits[SERVO_AXES] = {limits_of(plant, kAzimuth, holding_brakes),
                                                limits_of(plant, kPitch, holding_brakes)};
  const hal_scales scales = node_scales(plant);
  if (holding_brakes) {
    machine_.fit_holding_brakes();
  }
  const servo_node_config config = {
      on_bus.node_id, {send, this},  machine_.hal_pointer(), parameters,
      limits,         flash.areas(), on_bus.serial_number,   {on_bus.kbit_s, false, flash.bus_pages(), {join, this}},
      "host",         &scales};
  if (!servo_node_start(node_.get(), &config)) {
    throw std::invalid_argument("the node did not start: " +
                                dictionary::refusal_of({parameters[0], parameters[1]}, {limits[0], limits[1]}) + ".");
  }
  machine_.run_firmware(node_->board, [this] {
    servo_node_tick(node_.get());
    servo_node_serve(node_.get());
  });
}

// Like the board's CAN controller: frames that its filters drop do not reach the node.
void ServedNode::receive(const can_frame& frame) {
  if (heard_frame(&frame)) {
    can_frame received = frame;
    received.received_us = static_cast<std::uint16_t>(machine_.clock_us());
    servo_node_receive(node_.get(), &received);
  }
}

ServedNode::~ServedNode() { bus_.detach(port_); }

void ServedNode::tick() {
  machine_.advance_tick();
  for (int i = 0; i < kFlashOperationsPerTick; ++i) {
    servo_node_background(node_.get());
  }
}

void ServedNode::process() { canopen_node_answer(&node_->canopen); }

void ServedNode::take_health(CanHealth health) {
  if (health == CanHealth::kRecovered) {
    canopen_node_bus_off_recovered(&node_->canopen);
  } else if (health == CanHealth::kGood || health == CanHealth::kErrorPassive) {
    canopen_node_error_passive(&node_->canopen, health == CanHealth::kErrorPassive);
  }
}

std::array<std::uint8_t, kAxes> ServedNode::tracking() const {
  const camera_objects& objects = node_->tracking.objects;
  return {objects.azimuth_tracking, objects.pitch_tracking};
}

bool ServedNode::send(void *context, const can_frame *frame) {
  const auto *self = static_cast<const ServedNode *>(context);
  return self->bus_.send(self->port_, *frame);
}

bool ServedNode::join(void *context, std::uint16_t kbit_s) {
  const auto *self = static_cast<const ServedNode *>(context);
  self->bus_.set_bit_rate(self->port_, 1000.0 * kbit_s);
  return true;
}

}  // namespace trackservo::sim
