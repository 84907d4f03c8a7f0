// SPDX-License-Identifier: Apache-2.0
// What a check drives: the servo's node on a simulated machine, accessed through its objects as a master would.
//
// Implemented by HostDevice (the firmware compiled into this program) and by the emulated board with an image on it.
// Use: write gains, enable(), then command() and pass_ms() for every millisecond of the scenario.
#ifndef TRACKSERVO_SIM_CHECK_DEVICE_HPP
#define TRACKSERVO_SIM_CHECK_DEVICE_HPP

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "config/plant_config.hpp"
#include "plant/truth.hpp"

namespace trackservo::sim {

class CheckedDevice {
 public:
  CheckedDevice() = default;
  CheckedDevice(const CheckedDevice&) = delete;
  CheckedDevice& operator=(const CheckedDevice&) = delete;
  virtual ~CheckedDevice() = default;

  // As an expedited SDO of 1, 2 or 4 bytes: 0, or the abort code.
  virtual std::uint32_t write(std::uint16_t index, std::uint8_t sub, std::uint32_t bits, int bytes) = 0;

  // As an expedited SDO; none when it is refused.
  virtual std::optional<std::uint32_t> read(std::uint16_t index, std::uint8_t sub) = 0;

  // Switches both axes to operation enabled in cyclic synchronous velocity; false when one does not get there.
  virtual bool enable() = 0;

  // Commands the set-points of both axes for the next millisecond [rad/s].
  virtual void command(const std::array<double, kAxes>& rate_rad_s) = 0;

  // Torque behind the controller [Nm], held until set again. Ignored where can_disturb() is false.
  virtual void disturb(int axis, double torque_nm) = 0;
  virtual bool can_disturb() const = 0;

  virtual void pass_ms() = 0;

  virtual TruthState truth() const = 0;

  // Milliseconds from command() to the tick that uses its set-point.
  virtual int set_point_delay_ms() const = 0;

  // Torque command of the last tick [Nm]; NaN where it cannot be observed.
  virtual double torque_command_nm(int axis) const = 0;

  // Returns why the device no longer follows its set-points ("pitch: fault 7300h"); none while it does.
  virtual std::optional<std::string> failure() = 0;
};

// Makes a device on this plant, with the start gains of a device. Called from several threads.
using DeviceMaker = std::function<std::unique_ptr<CheckedDevice>(const PlantConfig& plant, std::uint64_t seed,
                                                                 const std::array<double, kAxes>& joint_angle_rad)>;

}  // namespace trackservo::sim

#endif
