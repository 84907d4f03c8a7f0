// SPDX-License-Identifier: Apache-2.0
// The servo's node on a simulated machine, driven through its objects as a master would, without a bus between them.
#ifndef TRACKSERVO_SIM_DEVICE_DRIVEN_NODE_HPP
#define TRACKSERVO_SIM_DEVICE_DRIVEN_NODE_HPP

#include <array>
#include <cstdint>

#include "device/simulated_node.hpp"

namespace trackservo::sim {

class DrivenNode {
 public:
  // Boots the node. `setup` and what `fittings` points to must exist longer than the node.
  DrivenNode(const NodeSetup& setup, std::uint64_t seed, const std::array<double, kAxes>& joint_angle_rad,
             const NodeFittings& fittings = {});

  // Writes an object of the axis (azimuth's index for both). Throws std::runtime_error when it is refused.
  void write(int axis, std::uint16_t index, std::uint8_t sub, std::int64_t value);

  // Does the same for a REAL32.
  void write_real(int axis, std::uint16_t index, std::uint8_t sub, double value);

  // Opens the lock of dangerous parameters (0x3040), for a minute.
  void unlock();

  // Runs until the axes are enabled in a mode of 6060, a few ticks. Throws std::runtime_error when they do not get
  // there.
  void enable(std::int8_t mode) { enable(std::array<std::int8_t, kAxes>{mode, mode}); }
  void enable(const std::array<std::int8_t, kAxes>& modes);

  // Writes the set-point of cyclic synchronous velocity.
  void set_rate(int axis, double rate_rad_s);

  // Writes the set-point of the next tick in cyclic synchronous velocity or position: the position continues from that
  // at the time of enabling.
  void move(int axis, double rate_rad_s);

  // Takes a frame from the bus, as in the receive interrupt.
  void receive(const can_frame& frame) { simulated_.receive(frame); }

  // Lets the master say nothing more to the node from now on (0x6007); its set-points stay.
  void fall_silent() { speaks_ = false; }
  void speak_again() { speaks_ = true; }

  // Restarts the controller with empty memory, as after a power cycle; the machine stays where it is.
  void restart() { simulated_.restart(); }

  // Runs one tick. The master speaks to the node in each, until it falls silent.
  void tick();

  Machine& machine() { return simulated_.machine(); }
  const Machine& machine() const { return simulated_.machine(); }
  servo_node& node() { return simulated_.node(); }
  const servo_node& node() const { return simulated_.node(); }
  const servo_node_axis& axis(int axis) const { return node().axis[axis]; }
  servo_mode mode(int axis) const { return node().board.app.axis[axis].mode; }

 private:
  bool is_written(const od_object& object, const std::uint8_t *bytes);

  SimulatedNode simulated_;
  bool speaks_ = true;
  std::array<double, kAxes> wanted_rad_{};  // of `move`, when the position is controlled
};

}  // namespace trackservo::sim

#endif
