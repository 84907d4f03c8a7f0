#include "serve/server.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <csignal>
#include <memory>
#include <stdexcept>
#include <utility>

#include "bus/slcan_pty.hpp"
#include "bus/slcan_tcp.hpp"
#include "bus/socketcan.hpp"
#include "bus/virtual_bus.hpp"
#include "run/machine.hpp"
#include "serve/node_parameters.hpp"

extern "C" {
#include "node/servo_node.h"
}

namespace trackservo::sim {
namespace {

using Clock = std::chrono::steady_clock;
using Ends = std::vector<std::unique_ptr<BusEnd>>;

constexpr auto kHeldTime = std::chrono::milliseconds(1);
constexpr int kMostTicksBehind = 20;  // after a longer stall of the host, simulated time is let go

volatile std::sig_atomic_t stop_requested = 0;

void request_stop(int) { stop_requested = 1; }

// The rest of `bus` behind "kind:", or nothing when it is of another kind.
bool is_kind(const std::string& bus, const std::string& kind, std::string& rest) {
  if (bus.rfind(kind, 0) != 0 || (bus.size() > kind.size() && bus[kind.size()] != ':')) {
    return false;
  }
  rest = bus.size() > kind.size() ? bus.substr(kind.size() + 1) : "";
  return true;
}

std::uint16_t port_of(const std::string& text) {
  std::uint16_t port = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), port);
  if (error != std::errc() || end != text.data() + text.size()) {
    throw std::invalid_argument(fmt::format("slcan-tcp:{}: not a port; give 0 (any free one) to 65535", text));
  }
  return port;
}

std::unique_ptr<BusEnd> open_end(VirtualBus& bus, const std::string& name, SocketCan::HealthChanged health_changed) {
  std::string rest;
  if (is_kind(name, "slcan-tcp", rest)) {
    return std::make_unique<SlcanTcp>(bus, rest.empty() ? std::uint16_t{0} : port_of(rest));
  }
  if (is_kind(name, "slcan-pty", rest)) {
    return std::make_unique<SlcanPty>(bus);
  }
  if (is_kind(name, "socketcan", rest) && !rest.empty()) {
    return std::make_unique<SocketCan>(bus, rest, std::move(health_changed));
  }
  throw std::invalid_argument(
      fmt::format("bus \"{}\" is not known; give slcan-tcp:PORT, slcan-pty or socketcan:INTERFACE", name));
}

// The node on its port of the bus, with the machine under it.
class ServedNode {
 public:
  ServedNode(const PlantConfig& plant, const ServeOptions& options, VirtualBus& bus)
      : bus_(bus),
        node_(std::make_unique<servo_node>()),
        port_(bus.attach([this](const can_frame& frame) { servo_node_receive(node_.get(), &frame); })),
        machine_(plant, options.seed, {0.0, 0.3}) {
    const axis_parameters parameters[SERVO_AXES] = {node_parameters(plant, kAzimuth), node_parameters(plant, kPitch)};
    const servo_node_config config = {options.node_id, {send, this}, machine_.hal_pointer(), parameters};
    if (!servo_node_start(node_.get(), &config)) {
      throw std::invalid_argument(
          "the node does not start: give a node id from 1 to 127 and a plant whose gains are in range");
    }
    machine_.run_firmware(node_->board, [this] { servo_node_tick(node_.get()); });
  }
  ServedNode(const ServedNode&) = delete;
  ServedNode& operator=(const ServedNode&) = delete;
  ~ServedNode() { bus_.detach(port_); }

  void tick() { machine_.advance_tick(); }

  // What a CAN controller's driver would tell; an interface that was down counts as a bus that was off.
  void take_health(CanHealth health) {
    if (health == CanHealth::kRecovered) {
      canopen_node_bus_off_recovered(&node_->canopen);
    } else if (health == CanHealth::kGood || health == CanHealth::kErrorPassive) {
      canopen_node_error_passive(&node_->canopen, health == CanHealth::kErrorPassive);
    }
  }

  // Answers need not wait for the next tick.
  void process() { canopen_node_process(&node_->canopen); }

 private:
  static bool send(void *context, const can_frame *frame) {
    const auto *self = static_cast<const ServedNode *>(context);
    return self->bus_.send(self->port_, *frame);
  }

  VirtualBus& bus_;
  std::unique_ptr<servo_node> node_;
  VirtualBus::Port port_;
  Machine machine_;
};

// Waits for a byte or for the next tick. False: standard input has ended or a signal came.
bool wait(const Ends& ends, Clock::time_point until) {
  std::vector<pollfd> descriptors{{STDIN_FILENO, POLLIN, 0}};
  for (const auto& end : ends) {
    end->add_to_poll(descriptors);
  }
  const auto left = std::chrono::duration_cast<std::chrono::nanoseconds>(until - Clock::now()).count();
  const timespec timeout{0, left > 0 ? static_cast<long>(left) : 0};
  ppoll(descriptors.data(), descriptors.size(), &timeout, nullptr);
  char byte = 0;
  const bool input_open = (descriptors[0].revents & (POLLIN | POLLHUP)) == 0 || read(STDIN_FILENO, &byte, 1) > 0;
  return input_open && stop_requested == 0;
}

void pump(const Ends& ends) {
  for (const auto& end : ends) {
    end->pump();
  }
}

bool any_is_behind(const Ends& ends) {
  return std::any_of(ends.begin(), ends.end(), [](const std::unique_ptr<BusEnd>& end) { return end->is_behind(); });
}

void run_at_pace(VirtualBus& bus, ServedNode& node, const Ends& ends, double pace) {
  const auto tick_time = std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(kTick_s / pace));
  Clock::time_point last = Clock::now();
  Clock::time_point next_tick = last + tick_time;
  while (wait(ends, next_tick)) {
    pump(ends);
    const Clock::time_point now = Clock::now();
    const bool held = pace > 1.0 && any_is_behind(ends);
    bus.advance(held ? 0.0 : pace * std::chrono::duration<double>(now - last).count());
    last = now;
    node.process();
    for (int behind = 0; behind < kMostTicksBehind && next_tick <= now && !held; ++behind) {
      node.tick();
      next_tick += tick_time;
    }
    next_tick = next_tick <= now ? now + tick_time : next_tick;
    bus.advance(0.0);
    pump(ends);
  }
}

void run_at_full_speed(VirtualBus& bus, ServedNode& node, const Ends& ends) {
  while (wait(ends, any_is_behind(ends) ? Clock::now() + kHeldTime : Clock::now())) {
    pump(ends);
    if (any_is_behind(ends)) {
      continue;
    }
    bus.advance(kTick_s);
    node.tick();
    pump(ends);
  }
}

}  // namespace

void serve(const PlantConfig& plant, const ServeOptions& options,
           const std::function<void(const std::vector<std::string>& addresses)>& ready) {
  VirtualBus bus;
  ServedNode node(plant, options, bus);
  Ends ends;
  std::vector<std::string> addresses;
  for (const std::string& name : options.buses) {
    ends.push_back(open_end(bus, name, [&node](CanHealth health) { node.take_health(health); }));
    addresses.push_back(ends.back()->address());
  }
  (void)std::signal(SIGTERM, request_stop);
  (void)std::signal(SIGINT, request_stop);
  (void)std::signal(SIGPIPE, SIG_IGN);
  ready(addresses);
  if (options.pace) {
    run_at_pace(bus, node, ends, *options.pace);
  } else {
    run_at_full_speed(bus, node, ends);
  }
}

}  // namespace trackservo::sim
