// SPDX-License-Identifier: Apache-2.0
// The firmware that is compiled into this program, on a port of a bus, with a simulated machine under it.
#ifndef TRACKSERVO_SIM_DEVICE_SIMULATED_DEVICE_HPP
#define TRACKSERVO_SIM_DEVICE_SIMULATED_DEVICE_HPP

#include <array>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>

#include "device/device.hpp"
#include "device/flash_memory.hpp"
#include "device/simulated_node.hpp"

namespace trackservo::sim {

class SimulatedDevice : public Device {
 public:
  struct Options {
    std::uint64_t seed = 1;
    std::array<double, kAxes> joint_angle_rad = kServedStart_rad;
    std::uint8_t node_id = 1;     // 1 .. 127, or 255: none; while LSS has stored no other
    std::uint16_t kbit_s = 1000;  // 125, 250, 500 or 1000; likewise
    std::uint32_t serial_number = 0;
    // File of the flash, whose parameter set, if it has one, replaces the plant's gains; empty: kept in memory only.
    std::filesystem::path flash = {};
    // Those of the plant file are fitted, and the defaults of 2060:24 and 2060:25 are their times.
    bool holding_brakes = false;
    std::optional<NodeSetup> setup = {};  // none: the design for the plant
  };

  // Keeps a reference to `bus`, which must exist longer than the device. Throws std::runtime_error for a node id, bit
  // rate or gains out of range, and like FlashMemory.
  SimulatedDevice(const PlantConfig& plant, VirtualBus& bus, const Options& options);
  ~SimulatedDevice() override;

  void tick() override { node_.tick(); }
  void answer() override { canopen_node_answer(&node_.node().canopen); }
  void pass_ms() override;
  // Takes a report; an interface that was down counts as a bus-off.
  void take_health(CanHealth health) override;
  TruthState truth() const override { return node_.machine().truth(); }
  void strobe() override { node_.machine().strobe(); }
  std::array<std::uint8_t, kAxes> tracking() const override;
  bool settle() override;
  int set_point_delay_ms() const override { return 1; }  // of interpolation: the frame comes before its ms' tick
  void disturb(int axis, double torque_nm) override { node_.machine().inject_torque(axis, torque_nm); }
  std::optional<double> torque_command_nm(int axis) const override;

  const servo_node& node() const { return node_.node(); }

 private:
  void receive(const can_frame& frame);
  static bool send(void *context, const can_frame *frame);
  static bool join(void *context, std::uint16_t kbit_s);

  VirtualBus& bus_;
  VirtualBus::Port port_;
  std::unique_ptr<FlashMemory> flash_;
  NodeSetup setup_;
  SimulatedNode node_;
};

}  // namespace trackservo::sim

#endif
