// SPDX-License-Identifier: Apache-2.0
// Devices as CANopen nodes on a bus for clients: `sim_host serve`.
//
// It runs until SIGINT or SIGTERM. Standard input is read only on request, because a background job of a script or of a
// CI service has none. Bus ends: "slcan-tcp:PORT" (0: any free port), "slcan-pty", "socketcan:IFACE". All are ends of
// one virtual bus, so several clients see each other's frames as on a wire. Time runs at a given pace, or as fast as
// the host can.
#ifndef TRACKSERVO_SIM_SERVE_SERVER_HPP
#define TRACKSERVO_SIM_SERVE_SERVER_HPP

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "device/bus/virtual_bus.hpp"
#include "device/device.hpp"
#include "device/serve/served_target.hpp"
#include "machine/config/plant_config.hpp"

namespace trackservo::sim {

struct ServeOptions {
  std::vector<std::string> buses = {"slcan-tcp:0"};
  // Each node has the next node id (or none: 255), serial number and seed, and a flash file of its own: from the second
  // node on, the node's number is appended.
  int nodes = 1;
  std::uint8_t node_id = 1;
  std::uint32_t serial_number = 0;
  std::uint32_t bit_rate = 1000000;  // of the bus, and of nodes that have stored no other
  std::uint64_t seed = 1;
  std::filesystem::path flash;  // keeps the parameter set from run to run; empty: it is not kept
  // Simulated time per real time. Faster than real time, or as fast as the host can (none), it waits for slow clients,
  // so that they lose nothing; in real time they can lose frames, as on a wire.
  std::optional<double> pace = 1.0;
  // After a stall of the host, at most this many ticks are made up for at once; the rest is dropped, and simulated time
  // is late.
  int catch_up_ticks = 20;
  TargetOptions target;
  std::optional<std::uint32_t> base_sensor_cob_id;  // of the first node, the others count up; none: no such sensor
  bool until_stdin_ends = false;  // end with standard input too: for a parent process that may be killed
};

// Reports of serve(), each once and in this order; an empty function is not called.
struct ServeReports {
  std::function<void(const std::vector<std::string>& addresses)> open;  // every bus end's, then the pictures'
  std::function<void()>
      ready;  // the device's boot-up message was on the bus, or 1 s of its time has passed without one
};

// Returns a file of the n-th device, from 0 on: of all but the first with its number.
std::filesystem::path file_of_device(const std::filesystem::path& file, int number);

constexpr const char *kUntilStdinEndsHelp =
    "exit at end of standard input, so that the program does not outlive its parent";

// Prints the addresses, a line each, then the line "ready". Each is flushed, so that a script can wait for it.
ServeReports reports_on_stdout();

// Serves simulated devices until SIGTERM or SIGINT comes. Throws std::invalid_argument for an unknown bus,
// std::runtime_error for one that cannot be opened.
void serve(const PlantConfig& plant, const ServeOptions& options, const ServeReports& reports);

// Does the same for any devices on the bus; with a target, each has one in front of it.
void serve(const std::vector<Device *>& devices, VirtualBus& bus, const ServeOptions& options,
           const ServeReports& reports);

}  // namespace trackservo::sim

#endif
