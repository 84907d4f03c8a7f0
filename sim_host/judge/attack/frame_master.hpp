// SPDX-License-Identifier: Apache-2.0
// A CANopen master on the frame interface of a driven node: SDO writes one after the other, and any other frame.
#ifndef TRACKSERVO_SIM_ATTACK_FRAME_MASTER_HPP
#define TRACKSERVO_SIM_ATTACK_FRAME_MASTER_HPP

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "device/driven_node.hpp"

namespace trackservo::sim {

// A write of at most four bytes, as an expedited SDO download carries it.
struct SdoWrite {
  std::uint16_t index = 0;
  std::uint8_t sub = 0;
  std::uint8_t bytes = 0;
  std::uint32_t value = 0;
};

// Returns a write of an object as the bus sees it, with the size that the dictionary gives. Throws
// std::invalid_argument when there is no such object.
SdoWrite sdo_write(const DrivenNode& node, std::uint16_t index, std::uint8_t sub, double value);

// The events of a run in plain words, one line each.
class EventLog {
 public:
  void say(double time_s, const std::string& text);
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

class FrameMaster {
 public:
  // Explains every frame in the log, if there is one.
  explicit FrameMaster(EventLog *log) : log_(log) {}

  // Returns the receiver for the node's fittings.
  can_sender receiver() { return {receive, this}; }

  // Connects the master to a node. Call before anything is sent.
  void connect(DrivenNode& node) { node_ = &node; }

  // Waits until the earlier writes are answered. Returns false when too many wait; the write is dropped then.
  bool write(const SdoWrite& write);

  // Writes the mapping with which RPDO `number` (1 to 4) takes the camera's frames.
  void map_camera(int number, std::uint32_t cob_id);

  // Sends a frame at once, if the node hears it.
  void send(const can_frame& frame, const std::string& meaning);

  // Sends the next request. Call before each tick.
  void step(double time_s);

  // Asks for 1000, once a tick, until the node answers or `ticks` have passed; runs the ticks.
  template <class Tick>
  bool node_answers(int ticks, Tick tick) {
    device_type_read_ = false;
    for (int i = 0; i < ticks; ++i) {
      if (i % kAskAgainTicks == 0) {
        ask_device_type();
      }
      tick();
      if (device_type_read_) {
        return true;
      }
    }
    return false;
  }

  // Sends a frame to the node that changes nothing: a read of 1000.
  void keep_alive() { ask_device_type(); }

  bool is_idle() const { return count_ == 0 && !waiting_; }
  int writes() const { return writes_; }
  int refusals() const { return refusals_; }
  bool explains() const { return log_ != nullptr; }

 private:
  static constexpr std::size_t kQueue = 64;
  static constexpr int kAnswerTicks = 200;  // a command may take a few flash operations
  static constexpr int kAskAgainTicks = 20;

  static bool receive(void *context, const can_frame *frame);
  void take(const can_frame& frame);
  void ask_device_type();
  std::string describe(const SdoWrite& write) const;
  void say(const std::string& text);

  EventLog *log_;
  DrivenNode *node_ = nullptr;
  double time_s_ = 0;
  std::array<SdoWrite, kQueue> queue_{};
  std::size_t first_ = 0;
  std::size_t count_ = 0;
  bool waiting_ = false;  // for the answer to `sent_`
  SdoWrite sent_{};
  int waited_ticks_ = 0;
  bool device_type_read_ = false;
  int writes_ = 0;
  int refusals_ = 0;
};

}  // namespace trackservo::sim

#endif
