// SPDX-License-Identifier: Apache-2.0
// A device as a check drives it: over its bus alone, as a master would.
//
// Use: write gains, enable(), then command() and pass_ms() for every millisecond of the scenario.
#ifndef TRACKSERVO_SIM_CHECK_CHECKED_DEVICE_HPP
#define TRACKSERVO_SIM_CHECK_CHECKED_DEVICE_HPP

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "device/can_client.hpp"
#include "device/device.hpp"
#include "machine/config/plant_config.hpp"

namespace trackservo::sim {

// Makes a device on this plant, with the start gains of a device. Called from several threads.
using DeviceMaker = std::function<std::unique_ptr<Device>(const PlantConfig& plant, VirtualBus& bus, std::uint64_t seed,
                                                          const std::array<double, kAxes>& joint_angle_rad)>;

// Makes the firmware that is compiled into this program.
std::unique_ptr<Device> make_simulated_device(const PlantConfig& plant, VirtualBus& bus, std::uint64_t seed,
                                              const std::array<double, kAxes>& joint_angle_rad);

class CheckedDevice {
 public:
  // Makes the device, and starts its node.
  CheckedDevice(const DeviceMaker& make, const PlantConfig& plant, std::uint64_t seed,
                const std::array<double, kAxes>& joint_angle_rad);

  // Writes by an expedited SDO of 1, 2 or 4 bytes. Returns 0 or the abort code.
  std::uint32_t write(std::uint16_t index, std::uint8_t sub, std::uint32_t bits, int bytes);

  // Reads by an expedited SDO; none when it is refused.
  std::optional<std::uint32_t> read(std::uint16_t index, std::uint8_t sub) { return client_.read(index, sub); }

  // Switches both axes to operation enabled in cyclic synchronous velocity; false when one does not get there.
  bool enable();

  // Sends the set-points of both axes for the next millisecond [rad/s].
  void command(const std::array<double, kAxes>& rate_rad_s);

  void pass_ms() { client_.pass(1); }

  // Returns why the device no longer follows its set-points ("pitch: fault 7300h"); none while it does.
  std::optional<std::string> failure() const;

  Device& device() { return *device_; }
  const Device& device() const { return *device_; }

 private:
  VirtualBus bus_{1e6, kPwmPeriod_s};
  std::unique_ptr<Device> device_;
  CanClient client_;
  bool ticks_;
};

}  // namespace trackservo::sim

#endif
