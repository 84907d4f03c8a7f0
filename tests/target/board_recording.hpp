// SPDX-License-Identifier: Apache-2.0
// What the image on the emulated board reads and does, PWM period by PWM period, without a change of the image: the RAM
// of its HAL, the CAN controller's FIFO, and the timers' compare values at the end of each interrupt.
#ifndef TRACKSERVO_TARGET_BOARD_RECORDING_HPP
#define TRACKSERVO_TARGET_BOARD_RECORDING_HPP

#include <algorithm>
#include <array>
#include <cstring>
#include <deque>
#include <vector>

#include "image_layout.hpp"
#include "rig.hpp"

namespace bench {

constexpr std::size_t kAxes = SERVO_AXES;

struct BoardPeriod {
  std::array<float, kAxes> current_a;
  float bus_voltage_v;
  std::array<float, kAxes> voltage_v;          // of the motor stage
  std::array<std::uint32_t, kAxes> compare_1;  // counts of leg 1, in force from the next period on
};

struct BoardTick {
  std::vector<can_frame> frames;  // that have come since the last tick
  std::array<hal_axis_samples, kAxes> samples;
  std::vector<BoardPeriod> periods;  // from number 0 on
};

class BoardRecording {
 public:
  // Records from now on: the rig must not have run yet.
  explicit BoardRecording(BoardRig& rig)
      : rig_(rig), layout_(read_layout()), board_(address_of("board", layout_.hal_bytes)), port_(listen()) {
    chip().core.monitor_exceptions([this](int exception) { follow(exception); });
    chip().bus.monitor([this](const target::Bus::Write& write) { take_frame(write.address); });
  }
  ~BoardRecording() { rig_.bus.detach(port_); }
  BoardRecording(const BoardRecording&) = delete;
  BoardRecording& operator=(const BoardRecording&) = delete;

  // What the firmware starts with: samples of the self-test, and one period.
  const BoardTick& start() const { return start_; }

  // The last one may not have all its periods yet.
  const std::vector<BoardTick>& ticks() const { return ticks_; }

  // Frames that came while the tick or its deferred task was under way: which of them still counts is not recorded.
  int frames_in_between() const { return frames_in_between_; }

 private:
  static constexpr std::uint32_t kFifo0Acknowledge = 0x40006494;
  static constexpr std::array<std::uint32_t, kAxes> kCompare1 = {0x40012C34, 0x40013434};  // TIM1, TIM8
  static constexpr int kPwm = target::kFirstInterrupt + target::kAdc12Interrupt;
  static constexpr int kTick = target::kFirstInterrupt + target::kTim6Interrupt;

  target::Stm32g474& chip() const { return rig_.machine.chip(); }

  template <typename T>
  T value_at(std::uint32_t address) const {
    T value{};
    std::memcpy(&value, chip().core.memory_at(address, sizeof value), sizeof value);
    return value;
  }

  template <typename T>
  std::array<T, kAxes> of_axes(std::uint32_t offset) const {
    return value_at<std::array<T, kAxes>>(board_ + offset);
  }

  // --- the bus ---

  // What the image hears, in its order; nothing that it sends.
  sim::VirtualBus::Port listen() {
    return rig_.bus.attach([this](const can_frame& frame) {
      constexpr std::array<std::uint32_t, 7> kOfClient = {0x000, 0x080, 0x201, 0x301, 0x401, 0x501, 0x601};
      if (std::find(kOfClient.begin(), kOfClient.end(), frame.id) != kOfClient.end()) {
        on_the_bus_.push_back(frame);
      }
    });
  }

  void take_frame(std::uint32_t address) {
    if (address == kFifo0Acknowledge) {
      received_.push_back(on_the_bus_.at(0));
      on_the_bus_.pop_front();
      const bool after_pre_tick = value_at<std::uint32_t>(board_ + layout_.period) == 1;
      frames_in_between_ += after_pre_tick || value_at<bool>(board_ + layout_.service_under_way) ? 1 : 0;
    }
  }

  // --- interrupts ---

  // A deeper nesting is the start of an interrupt, a lower one the end of one, an equal one both: they follow each
  // other without a return.
  void follow(int exception) {
    const auto nesting = static_cast<std::size_t>(chip().exceptions.nesting());
    if (nesting <= running_.size() && !running_.empty()) {
      end(running_.back());
      running_.pop_back();
    }
    if (nesting > running_.size()) {
      running_.push_back(exception);
      if (exception == kPwm && ticks_.empty()) {
        read_samples(start_);
        start_.periods = {read_period()};
      }
    }
  }

  void end(int exception) {
    if (exception == kPwm) {
      end_period();
    } else if (exception == kTick && !ticks_.empty()) {
      end_tick(ticks_.back());
    }
  }

  void end_period() {
    const std::uint32_t period = (value_at<std::uint32_t>(board_ + layout_.period) + 19) % 20;
    if (period == 0) {
      ticks_.emplace_back();
    }
    ticks_.back().periods.push_back(read_period());
  }

  BoardPeriod read_period() const {
    const std::uint32_t servo_board = value_at<std::uint32_t>(board_ + layout_.context);
    BoardPeriod now{of_axes<float>(layout_.current_a), value_at<float>(board_ + layout_.bus_voltage_v), {}, {}};
    for (std::size_t i = 0; i < kAxes; ++i) {
      const auto stage = servo_board + layout_.motor + static_cast<std::uint32_t>(i) * layout_.motor_bytes;
      now.voltage_v[i] = value_at<float>(stage + layout_.motor_voltage_v);
      now.compare_1[i] = chip().bus.peek(kCompare1[i]);
    }
    return now;
  }

  void end_tick(BoardTick& tick) {
    tick.frames.swap(received_);
    received_.clear();
    read_samples(tick);
  }

  void read_samples(BoardTick& tick) const { tick.samples = of_axes<hal_axis_samples>(layout_.samples); }

  BoardRig& rig_;
  Layout layout_;
  std::uint32_t board_;  // address of the HAL's state
  std::deque<can_frame> on_the_bus_;
  std::vector<can_frame> received_;  // since the last tick
  sim::VirtualBus::Port port_;
  std::vector<int> running_;
  BoardTick start_;
  std::vector<BoardTick> ticks_;
  int frames_in_between_ = 0;
};

}  // namespace bench

#endif
