// The simulated machine as a CANopen node that clients reach: `sim_host serve`.
//
// Bus ends: "slcan-tcp:PORT" (0: any free port), "slcan-pty", "socketcan:IFACE". All are ends of one virtual 1 Mbit/s
// bus, so several clients see each other's frames as on a wire. Time runs at a pace, or as fast as the host can.
#ifndef TRACKSERVO_SIM_SERVE_SERVER_HPP
#define TRACKSERVO_SIM_SERVE_SERVER_HPP

#include <cstdint>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "bus/socketcan.hpp"
#include "bus/virtual_bus.hpp"
#include "config/plant_config.hpp"

namespace trackservo::sim {

struct ServeOptions {
  std::vector<std::string> buses = {"slcan-tcp:0"};
  std::uint8_t node_id = 1;
  std::uint64_t seed = 1;
  std::filesystem::path flash;  // what keeps the stored set from run to run; empty: nothing does
  // Simulated time per real time. Faster than 1, or as fast as the host can (none), it waits for clients that do not
  // keep up, so that they lose nothing; in real time they do, as on a wire.
  std::optional<double> pace = 1.0;
};

using Ready = std::function<void(const std::vector<std::string>& addresses)>;

// What is served: a device on the bus whose time goes by in ticks of 1 ms.
class ServedDevice {
 public:
  ServedDevice() = default;
  ServedDevice(const ServedDevice&) = delete;
  ServedDevice& operator=(const ServedDevice&) = delete;
  virtual ~ServedDevice() = default;

  virtual void tick() = 0;

  // Between ticks: answers need not wait.
  virtual void process() {}

  // What a CAN controller's driver would tell.
  virtual void take_health(CanHealth /*health*/) {}

  // Lets time pass on the bus; a device whose own ticks do this does nothing here.
  virtual void pass_bus_time(VirtualBus& bus, double seconds) { bus.advance(seconds); }
};

// Calls `ready` with the address of every bus end, then serves until standard input ends or SIGTERM or SIGINT comes.
// Throws std::invalid_argument for a bus that is not known, std::runtime_error for one that cannot be opened.
void serve(const PlantConfig& plant, const ServeOptions& options, const Ready& ready);

// The same for any device; the options' node id and seed are not looked at.
void serve(ServedDevice& device, VirtualBus& bus, const ServeOptions& options, const Ready& ready);

}  // namespace trackservo::sim

#endif
