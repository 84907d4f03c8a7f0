// SPDX-License-Identifier: Apache-2.0
// The servo on its CAN bus, with the machine under it. Two kinds: the firmware that is compiled into this program
// (device/simulated_device.hpp), and the flash image on the emulated chip (emulator/board/board_device.hpp).
//
// Everything that a master does to a device goes over the bus.
#ifndef TRACKSERVO_SIM_DEVICE_DEVICE_HPP
#define TRACKSERVO_SIM_DEVICE_DEVICE_HPP

#include <array>
#include <cstdint>
#include <optional>
#include <string>

#include "device/bus/socketcan.hpp"
#include "machine/plant/truth.hpp"

namespace trackservo::sim {

// Joint angles at power-on of a device that clients meet [rad].
constexpr std::array<double, kAxes> kServedStart_rad = {0.0, 0.3};

class Device {
 public:
  Device() = default;
  Device(const Device&) = delete;
  Device& operator=(const Device&) = delete;
  virtual ~Device() = default;

  // Runs the control task and the machine for the next ms.
  virtual void tick() = 0;

  // Answers what has arrived, between two ticks; a device with processor time of its own does this in tick().
  virtual void answer() {}

  // Returns whether its ticks advance the time on the bus, too. Others' bus is advanced by its owner.
  virtual bool drives_bus() const { return false; }

  // Passes 1 ms as a master sees it: time on the bus with the answers in it, then the tick.
  virtual void pass_ms() = 0;

  // Takes a report that a CAN controller's driver would give.
  virtual void take_health(CanHealth /*health*/) {}

  // Returns the machine's true state, which no sensor has spoilt.
  virtual TruthState truth() const = 0;

  // Begins an exposure of the camera: a rising edge at the strobe input.
  virtual void strobe() = 0;

  // Returns how far tracking has got in each axis, as 3072:5 and :6.
  virtual std::array<std::uint8_t, kAxes> tracking() const = 0;

  // Passes the time from power-on until a master's frames of each ms come well before the tick that takes them. Returns
  // false when no tick comes.
  virtual bool settle() = 0;

  // Returns the time from a set-point of csv on the bus to the tick that has reached it [ms].
  virtual int set_point_delay_ms() const = 0;

  // Adds a torque behind the controller [N m], held until set again; without effect where the torque command is hidden.
  virtual void disturb(int /*axis*/, double /*torque_nm*/) {}

  // Returns the torque command of the last tick [N m]; none where it is hidden.
  virtual std::optional<double> torque_command_nm(int /*axis*/) const { return std::nullopt; }

  // Returns what the device does that no device may do, as a sentence; none: nothing.
  virtual std::optional<std::string> defect() const { return std::nullopt; }
};

}  // namespace trackservo::sim

#endif
