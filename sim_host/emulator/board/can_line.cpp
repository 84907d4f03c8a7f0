// SPDX-License-Identifier: Apache-2.0
#include "board/can_line.hpp"

#include <algorithm>

#include "device/bus/can_bit_time.hpp"

namespace trackservo::target {
namespace {

constexpr std::uint32_t kExtended = 1U << 30;
constexpr std::uint32_t kRemote = 1U << 29;

}  // namespace

CanLine::CanLine(sim::VirtualBus& bus, Fdcan& controller)
    : bus_(bus), controller_(controller), port_(bus.attach([this](const can_frame& frame) { receive(frame); }, 1)) {}

void CanLine::receive(const can_frame& frame) {
  if (!controller_.bits_per_s()) {
    return;
  }
  CanMessage message;
  const bool extended = (frame.flags & CAN_FRAME_EXTENDED) != 0;
  message.header =
      (extended ? frame.id | kExtended : frame.id << 18) | ((frame.flags & CAN_FRAME_REMOTE) != 0 ? kRemote : 0U);
  message.length = frame.length;
  message.bits = static_cast<std::uint32_t>(sim::can_frame_bits(frame));
  for (std::size_t i = 0; i < std::min<std::size_t>(frame.length, CAN_FRAME_BYTES); ++i) {
    message.data[i / 4] |= static_cast<std::uint32_t>(frame.data[i]) << (8 * (i % 4));
  }
  controller_.receive(message);
}

void CanLine::pump(Instant now) {
  controller_.bus_idle(now);
  if (controller_.restarts() != restarts_) {
    restarts_ = controller_.restarts();
    is_sending_ = false;  // the controller has dropped it
  }
  const std::optional<double> bits_per_s = controller_.bits_per_s();
  if (bits_per_s) {
    bus_.set_bit_rate(port_, *bits_per_s);
  }
  if (is_sending_ && bus_.has_room(port_)) {
    is_sending_ = false;
    controller_.sent();
  }
  const std::optional<CanMessage> message = controller_.next_to_send();
  if (is_sending_ || !message || !bits_per_s) {
    return;
  }
  can_frame frame{};
  const bool extended = (message->header & kExtended) != 0;
  frame.id = extended ? message->header & 0x1FFFFFFFU : message->header >> 18 & 0x7FFU;
  frame.flags = static_cast<std::uint8_t>((extended ? CAN_FRAME_EXTENDED : 0) |
                                          ((message->header & kRemote) != 0 ? CAN_FRAME_REMOTE : 0));
  frame.length = static_cast<std::uint8_t>(message->length);
  for (std::size_t i = 0; i < message->length; ++i) {
    frame.data[i] = static_cast<std::uint8_t>(message->data[i / 4] >> (8 * (i % 4)));
  }
  is_sending_ = bus_.send(port_, frame);
}

}  // namespace trackservo::target
