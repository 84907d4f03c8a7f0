// SPDX-License-Identifier: Apache-2.0
// The flash image on the emulated board, as a device on its bus.
#ifndef TRACKSERVO_SIM_EMULATOR_BOARD_BOARD_DEVICE_HPP
#define TRACKSERVO_SIM_EMULATOR_BOARD_BOARD_DEVICE_HPP

#include <array>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "board/board_machine.hpp"
#include "device/device.hpp"
#include "device/tracking_on_bus.hpp"

namespace trackservo::target {

using Image = std::vector<std::uint8_t>;

// Throws std::runtime_error for a file that cannot be read or is no image of this chip.
Image read_image(const std::filesystem::path& file);

class BoardDevice : public sim::Device {
 public:
  // Switches the power on. `bus` must exist longer than the device.
  BoardDevice(const Image& image, const sim::PlantConfig& plant, sim::VirtualBus& bus,
              const BoardMachine::Options& options)
      : machine_(image, plant, bus, options), tracking_(bus) {}

  void tick() override { machine_.run(sim::kTick_s); }
  bool drives_bus() const override { return true; }  // in every PWM period
  void pass_ms() override { tick(); }
  sim::TruthState truth() const override { return machine_.truth(); }
  void strobe() override { machine_.strobe(); }
  std::array<std::uint8_t, sim::kAxes> tracking() const override { return tracking_.states(); }
  bool settle() override;
  int set_point_delay_ms() const override { return 2; }  // the tick that takes the frame, and one of interpolation
  std::optional<std::string> defect() const override;

  BoardMachine& machine() { return machine_; }
  const BoardMachine& machine() const { return machine_; }

 private:
  BoardMachine machine_;
  sim::TrackingOnBus tracking_;
};

}  // namespace trackservo::target

#endif
