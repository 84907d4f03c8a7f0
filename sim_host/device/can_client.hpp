// SPDX-License-Identifier: Apache-2.0
// A CANopen client on the virtual bus, limited to the needs of the servo's tests: NMT, expedited SDO, the two axes'
// states, both speed set-points in one RPDO, and the node's own messages (heartbeat, EMCY).
#ifndef TRACKSERVO_SIM_DEVICE_CAN_CLIENT_HPP
#define TRACKSERVO_SIM_DEVICE_CAN_CLIENT_HPP

#include <array>
#include <cstdint>
#include <functional>
#include <optional>
#include <vector>

#include "device/bus/virtual_bus.hpp"

namespace trackservo::sim {

class CanClient {
 public:
  struct Emergency {
    std::uint16_t code;
    std::array<std::uint8_t, 8> bytes;
  };

  // Attaches a client to the bus; `pass_ms` advances the bus and the node by one millisecond.
  CanClient(VirtualBus& bus, std::function<void()> pass_ms);

  void pass(int milliseconds);

  // Sets the node that it talks to; initially 1.
  void set_node(std::uint8_t node_id) { node_ = node_id; }

  // Sets the client's bit rate; without one it understands every bit rate.
  void set_bit_rate(double bits_per_s) { bus_.set_bit_rate(port_, bits_per_s); }

  static constexpr int kPatience_ms = 500;  // the check of a gain set takes up to 300

  // Returns the value of an object; none without an answer within kPatience_ms, or after an abort.
  std::optional<std::uint32_t> read(std::uint16_t index, std::uint8_t sub = 0);
  // Returns the milliseconds until the answer came; -1: not within `patience_ms`.
  int read_within(std::uint16_t index, int patience_ms);
  bool write(std::uint16_t index, std::uint8_t sub, std::uint32_t value, int bytes, int patience_ms = kPatience_ms);

  // Sends any frame, also one that is not for this node.
  void send(const can_frame& frame) { bus_.send(port_, frame); }

  // Returns the abort code of the last aborted write; none when the node did not answer, or accepted it.
  std::optional<std::uint32_t> abort_code() const { return abort_code_; }

  void start_node() { send(0x000, {1, node_}); }

  // Takes both axes through the states of CiA 402 up to operation enabled, in this mode; returns false when one does
  // not get there.
  bool enable(int mode);
  bool is_enabled(int axis);
  std::uint32_t statusword(int axis);
  std::uint32_t error_code(int axis);
  // Resets the axis' fault and takes it to operation enabled again; false when it does not get there.
  bool enable_again(int axis);

  // Sends target velocities of both axes [1e-6 rad/s] by RPDO 3.
  void set_speeds(std::int32_t azimuth_urad_s, std::int32_t pitch_urad_s);

  int heartbeats() const { return heartbeats_; }
  int boots() const { return boots_; }
  int pdos() const { return pdos_; }
  const std::vector<Emergency>& emergencies() const { return emergencies_; }
  void forget() {
    emergencies_.clear();
    heartbeats_ = boots_ = pdos_ = 0;
  }

 private:
  void receive(const can_frame& frame);
  void ask(std::uint16_t index, std::uint8_t sub);
  void send(std::uint32_t identifier, const std::vector<std::uint8_t>& bytes);
  std::optional<can_frame> answer(int patience_ms);

  VirtualBus& bus_;
  std::function<void()> pass_ms_;
  VirtualBus::Port port_;
  std::uint8_t node_ = 1;
  std::optional<can_frame> answer_;
  std::optional<std::uint32_t> abort_code_;
  int heartbeats_ = 0;
  int boots_ = 0;
  int pdos_ = 0;
  std::vector<Emergency> emergencies_;
};

}  // namespace trackservo::sim

#endif
