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
#include "serve/served_node.hpp"

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

void run_at_pace(VirtualBus& bus, ServedDevice& device, const Ends& ends, double pace) {
  const auto tick_time = std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(kTick_s / pace));
  Clock::time_point last = Clock::now();
  Clock::time_point next_tick = last + tick_time;
  while (wait(ends, next_tick)) {
    pump(ends);
    const Clock::time_point now = Clock::now();
    const bool held = pace > 1.0 && any_is_behind(ends);
    device.pass_bus_time(bus, held ? 0.0 : pace * std::chrono::duration<double>(now - last).count());
    last = now;
    device.process();
    for (int behind = 0; behind < kMostTicksBehind && next_tick <= now && !held; ++behind) {
      device.tick();
      next_tick += tick_time;
    }
    next_tick = next_tick <= now ? now + tick_time : next_tick;
    device.pass_bus_time(bus, 0.0);
    pump(ends);
  }
}

void run_at_full_speed(VirtualBus& bus, ServedDevice& device, const Ends& ends) {
  while (wait(ends, any_is_behind(ends) ? Clock::now() + kHeldTime : Clock::now())) {
    pump(ends);
    if (any_is_behind(ends)) {
      continue;
    }
    device.pass_bus_time(bus, kTick_s);
    device.tick();
    pump(ends);
  }
}

}  // namespace

void serve(const PlantConfig& plant, const ServeOptions& options, const Ready& ready) {
  VirtualBus bus;
  const auto flash =
      options.flash.empty() ? std::make_unique<FlashMemory>() : std::make_unique<FlashMemory>(options.flash);
  ServedNode node(plant, options.node_id, options.seed, bus, *flash);
  serve(node, bus, options, ready);
}

void serve(ServedDevice& device, VirtualBus& bus, const ServeOptions& options, const Ready& ready) {
  Ends ends;
  std::vector<std::string> addresses;
  for (const std::string& name : options.buses) {
    ends.push_back(open_end(bus, name, [&device](CanHealth health) { device.take_health(health); }));
    addresses.push_back(ends.back()->address());
  }
  (void)std::signal(SIGTERM, request_stop);
  (void)std::signal(SIGINT, request_stop);
  (void)std::signal(SIGPIPE, SIG_IGN);
  ready(addresses);
  if (options.pace) {
    run_at_pace(bus, device, ends, *options.pace);
  } else {
    run_at_full_speed(bus, device, ends);
  }
}

}  // namespace trackservo::sim
