// SPDX-License-Identifier: Apache-2.0
#include "device/serve/server.hpp"

#include <fmt/format.h>
#include <unistd.h>

#include <algorithm>
#include <charconv>
#include <chrono>
#include <csignal>
#include <cstdio>
#include <iterator>
#include <limits>
#include <memory>
#include <stdexcept>
#include <utility>

#include "device/bus/slcan_pty.hpp"
#include "device/bus/slcan_tcp.hpp"
#include "device/bus/socketcan.hpp"
#include "device/bus/virtual_bus.hpp"
#include "device/simulated_device.hpp"
#include "machine/sensors/base_sensor.hpp"

namespace trackservo::sim {
namespace {

using Clock = std::chrono::steady_clock;
using Ends = std::vector<std::unique_ptr<BusEnd>>;

constexpr auto kHeldTime = std::chrono::milliseconds(1);
constexpr int kLatestReady_ticks = 1000;
// At a multiple of real time several ticks are made at one wake, because waking costs more than a tick.
constexpr auto kLongestNap = std::chrono::milliseconds(1);
constexpr int kNap_ticks = 10;

volatile std::sig_atomic_t stop_requested = 0;

void request_stop(int) { stop_requested = 1; }

// The rest of `bus` after "kind:", or nothing when it is of another kind.
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
    throw std::invalid_argument(fmt::format("slcan-tcp:{}: not a port; give 0 (any free port) to 65535", text));
  }
  return port;
}

std::unique_ptr<BusEnd> open_end(VirtualBus& bus, const std::string& name, SocketCan::HealthChanged health_changed) {
  std::string rest;
  if (is_kind(name, "slcan-tcp", rest)) {
    return std::make_unique<SlcanTcp>(bus, name == "slcan-tcp" ? std::uint16_t{0} : port_of(rest));
  }
  if (is_kind(name, "slcan-pty", rest)) {
    return std::make_unique<SlcanPty>(bus);
  }
  if (is_kind(name, "socketcan", rest) && !rest.empty()) {
    return std::make_unique<SocketCan>(bus, rest, std::move(health_changed));
  }
  throw std::invalid_argument(
      fmt::format("unknown bus \"{}\"; give slcan-tcp:PORT, slcan-pty or socketcan:INTERFACE", name));
}

// Reports when the device can be used: its boot-up message (CiA 301 7.2.8.3.3) was on the bus. A device without node id
// sends none, so it counts as ready after a second.
class ReadyMonitor {
 public:
  ReadyMonitor(VirtualBus& bus, const std::function<void()>& ready)
      : ready_(ready), bus_(bus), port_(bus.attach([this](const can_frame& frame) { receive(frame); })) {}
  ReadyMonitor(const ReadyMonitor&) = delete;
  ReadyMonitor& operator=(const ReadyMonitor&) = delete;
  ~ReadyMonitor() { bus_.detach(port_); }

  void count_tick() {
    if (is_reported_ || (++ticks_ < kLatestReady_ticks && !is_up_)) {
      return;
    }
    is_reported_ = true;
    if (ready_) {
      ready_();
    }
  }

 private:
  void receive(const can_frame& frame) {
    constexpr std::uint32_t kHeartbeats = 0x700;
    constexpr std::uint32_t kNodes = 0x7F;
    is_up_ = is_up_ || ((frame.id & ~kNodes) == kHeartbeats && frame.length == 1 && frame.data[0] == 0);
  }

  const std::function<void()>& ready_;
  VirtualBus& bus_;
  bool is_up_ = false;
  bool is_reported_ = false;
  int ticks_ = 0;
  VirtualBus::Port port_;
};

// Waits for a frame from a client or for the next tick. Returns false when a signal came, or standard input has ended
// and that stops the server.
bool wait(const Ends& ends, Clock::time_point until, bool until_stdin_ends) {
  constexpr int kIgnored = -1;
  std::vector<pollfd> descriptors{{until_stdin_ends ? STDIN_FILENO : kIgnored, POLLIN, 0}};
  for (const auto& end : ends) {
    end->add_to_poll(descriptors);
  }
  const auto left = std::chrono::duration_cast<std::chrono::nanoseconds>(until - Clock::now()).count();
  const timespec timeout{0, left > 0 ? static_cast<long>(left) : 0};
  ppoll(descriptors.data(), descriptors.size(), &timeout, nullptr);
  char byte = 0;
  const bool input_open = descriptors[0].revents == 0 || read(STDIN_FILENO, &byte, 1) > 0;
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

// The devices on the bus, with the targets in front of them.
class Scenery {
 public:
  Scenery(const std::vector<Device *>& devices, VirtualBus& bus, const ServeOptions& options)
      : devices_(devices), bus_(bus) {
    for (std::size_t i = 0; i < devices.size() && options.target.scenario; ++i) {
      targets_.push_back(std::make_unique<ServedTarget>(target_of(options.target, static_cast<int>(i)),
                                                        options.seed + i, bus,
                                                        [device = devices[i]] { device->strobe(); }));
    }
    for (std::size_t i = 0; i < devices.size() && options.base_sensor_cob_id; ++i) {
      base_sensors_.emplace_back(*options.base_sensor_cob_id + static_cast<std::uint32_t>(i), options.seed + i);
    }
  }
  Scenery(const Scenery&) = delete;
  Scenery& operator=(const Scenery&) = delete;
  ~Scenery() { bus_.detach(base_port_); }

  // The addresses of the pictures, one per device that has them.
  void add_videos(std::vector<std::string>& addresses) const {
    for (const auto& target : targets_) {
      if (!target->video_address().empty()) {
        addresses.push_back(target->video_address());
      }
    }
  }

  void tick() {
    for (std::size_t i = 0; i < devices_.size(); ++i) {
      devices_[i]->tick();
      if (!targets_.empty()) {
        targets_[i]->tick(devices_[i]->truth(), devices_[i]->tracking());
      }
      if (!base_sensors_.empty()) {
        send_base_rates(i);
      }
    }
  }

  void answer() {
    for (Device *device : devices_) {
      device->answer();
    }
  }

  void take_health(CanHealth health) {
    for (Device *device : devices_) {
      device->take_health(health);
    }
  }

  void pass_bus_time(double seconds) {
    const auto drives = [](const Device *device) { return device->drives_bus(); };
    if (std::none_of(devices_.begin(), devices_.end(), drives)) {
      bus_.advance(seconds);
    }
  }

 private:
  void send_base_rates(std::size_t i) {
    if (const std::optional<can_frame> rates = base_sensors_[i].look(devices_[i]->truth().base_turns_rad_s)) {
      bus_.send(base_port_, *rates);  // a full queue: the message is lost, as on a wire
    }
  }

  static TargetOptions target_of(TargetOptions options, int number) {
    options.camera_cob_id += static_cast<std::uint32_t>(number);
    options.truth_csv = file_of_device(options.truth_csv, number);
    options.video = options.video.empty() || number == 0 ? options.video : "pgm-tcp:0";
    return options;
  }

  const std::vector<Device *>& devices_;
  VirtualBus& bus_;
  std::vector<std::unique_ptr<ServedTarget>> targets_;  // one per device, or none at all
  std::vector<BaseSensor> base_sensors_;                // likewise
  VirtualBus::Port base_port_ = bus_.attach([](const can_frame&) {});
};

void run_at_pace(Scenery& scenery, const Ends& ends, const ServeOptions& options, ReadyMonitor& monitor) {
  const double pace = *options.pace;
  const auto tick_time = std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(kTick_s / pace));
  const auto later =
      std::max(std::min<Clock::duration>(kLongestNap, kNap_ticks * tick_time) - tick_time, Clock::duration{});
  Clock::time_point last = Clock::now();
  Clock::time_point next_tick = last + tick_time;
  while (wait(ends, next_tick + later, options.until_stdin_ends)) {
    pump(ends);
    const Clock::time_point now = Clock::now();
    const bool held = pace > 1.0 && any_is_behind(ends);
    // Also after a stall the bus' time passes tick by tick: the frames of a tick leave before those of the next are
    // queued.
    double left_s = held ? 0.0 : pace * std::chrono::duration<double>(now - last).count();
    const auto pass = [&scenery, &left_s](double seconds) {
      const double share_s = std::min(seconds, left_s);
      scenery.pass_bus_time(share_s);
      left_s -= share_s;
    };
    last = now;
    pass(next_tick <= now ? kTick_s : left_s);
    scenery.answer();
    for (int behind = 0; behind < options.catch_up_ticks && next_tick <= now && !held; ++behind) {
      if (behind > 0) {
        pass(kTick_s);
      }
      scenery.tick();
      monitor.count_tick();
      next_tick += tick_time;
    }
    next_tick = next_tick <= now ? now + tick_time : next_tick;
    pass(left_s);
    pump(ends);
  }
}

void run_at_full_speed(Scenery& scenery, const Ends& ends, const ServeOptions& options, ReadyMonitor& monitor) {
  while (wait(ends, any_is_behind(ends) ? Clock::now() + kHeldTime : Clock::now(), options.until_stdin_ends)) {
    pump(ends);
    if (any_is_behind(ends)) {
      continue;
    }
    scenery.pass_bus_time(kTick_s);
    scenery.tick();
    monitor.count_tick();
    pump(ends);
  }
}

std::vector<std::unique_ptr<Device>> simulated_devices(const PlantConfig& plant, const ServeOptions& options,
                                                       VirtualBus& bus) {
  const bool has_id = options.node_id != BUS_UNCONFIGURED;
  if (has_id && options.node_id + options.nodes - 1 > BUS_LAST_NODE_ID) {
    throw std::invalid_argument(fmt::format("{} nodes from node id {} on: the last node id would be above {}",
                                            options.nodes, options.node_id, BUS_LAST_NODE_ID));
  }
  const std::uint32_t last_serial = std::numeric_limits<std::uint32_t>::max();
  if (options.serial_number > last_serial - static_cast<std::uint32_t>(options.nodes - 1)) {
    throw std::invalid_argument(fmt::format("{} nodes from serial number {} on: the last one would be above {}",
                                            options.nodes, options.serial_number, last_serial));
  }
  std::vector<std::unique_ptr<Device>> devices;
  for (int i = 0; i < options.nodes; ++i) {
    SimulatedDevice::Options of_node;
    of_node.node_id = static_cast<std::uint8_t>(options.node_id + (has_id ? i : 0));
    of_node.kbit_s = static_cast<std::uint16_t>(options.bit_rate / 1000);
    of_node.serial_number = options.serial_number + static_cast<std::uint32_t>(i);
    of_node.seed = options.seed + static_cast<std::uint64_t>(i);
    of_node.flash = file_of_device(options.flash, i);
    of_node.holding_brakes = true;
    devices.push_back(std::make_unique<SimulatedDevice>(plant, bus, of_node));
  }
  return devices;
}

}  // namespace

std::filesystem::path file_of_device(const std::filesystem::path& file, int number) {
  return number == 0 || file.empty() ? file : std::filesystem::path(fmt::format("{}.{}", file.string(), number + 1));
}

ServeReports reports_on_stdout() {
  ServeReports reports;
  reports.open = [](const std::vector<std::string>& addresses) {
    for (const std::string& address : addresses) {
      fmt::print("{}\n", address);
    }
    (void)std::fflush(stdout);
  };
  reports.ready = [] {
    fmt::print("ready\n");
    (void)std::fflush(stdout);
  };
  return reports;
}

void serve(const PlantConfig& plant, const ServeOptions& options, const ServeReports& reports) {
  VirtualBus bus(options.bit_rate);
  const std::vector<std::unique_ptr<Device>> made = simulated_devices(plant, options, bus);
  std::vector<Device *> devices;
  std::transform(made.begin(), made.end(), std::back_inserter(devices),
                 [](const auto& device) { return device.get(); });
  serve(devices, bus, options, reports);
}

void serve(const std::vector<Device *>& devices, VirtualBus& bus, const ServeOptions& options,
           const ServeReports& reports) {
  Scenery scenery(devices, bus, options);
  Ends ends;
  std::vector<std::string> addresses;
  for (const std::string& name : options.buses) {
    ends.push_back(open_end(bus, name, [&scenery](CanHealth health) { scenery.take_health(health); }));
    addresses.push_back(ends.back()->address());
  }
  scenery.add_videos(addresses);
  (void)std::signal(SIGTERM, request_stop);
  (void)std::signal(SIGINT, request_stop);
  (void)std::signal(SIGPIPE, SIG_IGN);
  if (reports.open) {
    reports.open(addresses);
  }
  ReadyMonitor monitor(bus, reports.ready);
  if (options.pace) {
    run_at_pace(scenery, ends, options, monitor);
  } else {
    run_at_full_speed(scenery, ends, options, monitor);
  }
}

}  // namespace trackservo::sim
