// SPDX-License-Identifier: Apache-2.0
#include "device/bus/virtual_bus.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "device/bus/can_bit_time.hpp"

namespace trackservo::sim {
namespace {

constexpr double kTolerance = 0.005;  // tolerance of a bit rate, about that of CAN controllers

// The lower, the earlier: base identifier, data before remote and standard before extended, the other 18 bits.
std::uint64_t arbitration_key(const can_frame& frame) {
  const bool extended = (frame.flags & CAN_FRAME_EXTENDED) != 0;
  const std::uint64_t remote = (frame.flags & CAN_FRAME_REMOTE) != 0 ? 1 : 0;
  const std::uint64_t base = extended ? frame.id >> 18 : frame.id;
  const std::uint64_t rest = extended ? frame.id & 0x3FFFFU : 0U;
  const std::uint64_t kind = extended ? 2 : remote;
  return base << 32 | kind << 24 | rest << 1 | (extended ? remote : 0);
}

}  // namespace

VirtualBus::Port VirtualBus::attach(Receiver receiver, std::size_t queue_limit) {
  const Port port = next_port_++;
  nodes_.emplace(port, Node{std::move(receiver), {}, queue_limit, kEveryBitRate});
  return port;
}

void VirtualBus::detach(Port port) {
  Node& node = nodes_.at(port);
  if (node.queue.empty()) {
    nodes_.erase(port);
    return;
  }
  node.receiver = nullptr;
}

bool VirtualBus::has_room(Port port) const {
  const Node& node = nodes_.at(port);
  return node.queue.size() < node.limit;
}

bool VirtualBus::send(Port port, const can_frame& frame) {
  if (!has_room(port)) {
    return false;
  }
  nodes_.at(port).queue.push_back(frame);
  if (bit_rate_ <= 0) {
    while (deliver_next()) {
    }
  }
  return true;
}

bool VirtualBus::deliver_next() {
  const auto head_key = [](const auto& node) {
    return node.second.queue.empty() ? UINT64_MAX : arbitration_key(node.second.queue.front());
  };
  const auto winner = std::min_element(nodes_.begin(), nodes_.end(), [&](const auto& left, const auto& right) {
    return head_key(left) < head_key(right);
  });
  if (winner == nodes_.end() || winner->second.queue.empty()) {
    return false;
  }
  const can_frame frame = winner->second.queue.front();
  winner->second.queue.pop_front();
  const int bits = can_frame_bits(frame);
  const double sent_at = winner->second.bit_rate;
  const double frame_s = bit_rate_ <= 0 ? 0.0 : bits / (sent_at > 0 ? sent_at : bit_rate_);
  credit_s_ -= frame_s;
  busy_s_ += frame_s;
  bits_ += static_cast<std::uint64_t>(bits);
  ++frames_;
  for (auto& [port, node] : nodes_) {
    const bool understands = node.bit_rate <= 0 || sent_at <= 0 || std::abs(node.bit_rate / sent_at - 1.0) < kTolerance;
    if (port != winner->first && node.receiver && understands) {
      node.receiver(frame);
    }
  }
  if (!winner->second.receiver && winner->second.queue.empty()) {
    nodes_.erase(winner);
  }
  return true;
}

void VirtualBus::advance(double seconds) {
  advanced_s_ += seconds;
  if (bit_rate_ <= 0) {
    return;
  }
  credit_s_ += seconds;
  while (credit_s_ > 0 && deliver_next()) {
  }
  credit_s_ = std::min(credit_s_, saved_s_);
}

double VirtualBus::load() const { return bit_rate_ <= 0 || advanced_s_ <= 0 ? 0.0 : busy_s_ / advanced_s_; }

}  // namespace trackservo::sim
