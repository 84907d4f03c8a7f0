// SPDX-License-Identifier: Apache-2.0
// TIM16 (RM0440, 30) as far as the board uses it: it captures every eighth edge of MCO, which gives HSI16 / 16.
#ifndef TRACKSERVO_SIM_EMULATOR_CHIP_CAPTURE_TIMER_HPP
#define TRACKSERVO_SIM_EMULATOR_CHIP_CAPTURE_TIMER_HPP

#include <functional>
#include <utility>

#include "core/peripheral.hpp"

namespace trackservo::target {

class CaptureTimer : public Peripheral {
 public:
  // Takes its counter's frequency from `core_hz`, and the time between two edges of the input, 0 without any, from
  // `edge_s`.
  CaptureTimer(Services services, std::function<std::uint32_t()> core_hz, std::function<double()> edge_s)
      : Peripheral("TIM16", services,
                   {{"CR1", 0x00, 0, 0x8FF},
                    {"DIER", 0x0C, 0, 0},
                    {"SR", kSr, 0, 0xFFFFFFFF},
                    {"EGR", 0x14, 0, 1},
                    {"CCMR1", kCcmr1, 0, 0xFF},
                    {"CCER", kCcer, 0, 0xB},
                    {"CNT", 0x24, 0, 0, 0xFFFF},
                    {"PSC", 0x28, 0, 0},
                    {"ARR", 0x2C, 0xFFFF, 0},
                    {"RCR", 0x30, 0, 0},
                    {"CCR1", kCcr1, 0, 0, 0xFFFF},
                    {"TISEL", kTisel, 0, 0xF}}),
        core_hz_(std::move(core_hz)),
        edge_s_(std::move(edge_s)) {}

 protected:
  std::uint32_t on_read(std::uint32_t offset, std::uint32_t /*stored*/, unsigned /*width*/) override {
    capture();
    const std::uint32_t value = reg(offset);
    if (offset == kCcr1) {
      reg(kSr) &= ~kCaptured;
    }
    return value;
  }

  void on_write(std::uint32_t offset, std::uint32_t written, unsigned /*width*/) override {
    capture();
    if (offset == kSr) {
      reg(kSr) &= written;
    } else {
      store(offset, written);
    }
  }

  void on_reset() override { captures_ = 0; }

 private:
  static constexpr std::uint32_t kSr = 0x10;
  static constexpr std::uint32_t kCcmr1 = 0x18;
  static constexpr std::uint32_t kCcer = 0x20;
  static constexpr std::uint32_t kCcr1 = 0x34;
  static constexpr std::uint32_t kTisel = 0x5C;
  static constexpr std::uint32_t kCaptured = 1U << 1;
  static constexpr std::uint32_t kOverCaptured = 1U << 9;

  // Captures everything up to now: the input has run since power-on.
  void capture() {
    const bool runs = (reg(0x00) & 1U) != 0 && (reg(kCcer) & 1U) != 0 && (reg(kCcmr1) & 3U) == 1 && reg(kTisel) == 2;
    const double edge_s = edge_s_();
    if (!runs || edge_s <= 0.0) {
      return;
    }
    const double period_s = edge_s * static_cast<double>(1U << (reg(kCcmr1) >> 2 & 3U));
    const auto captures = static_cast<std::uint64_t>(seconds_of(timeline().now()) / period_s);
    if (captures == captures_) {
      return;
    }
    const bool lost = (reg(kSr) & kCaptured) != 0 || captures > captures_ + 1;
    reg(kSr) |= kCaptured | (lost && captures_ != 0 ? kOverCaptured : 0U);
    captures_ = captures;
    reg(kCcr1) =
        static_cast<std::uint32_t>(static_cast<std::uint64_t>(static_cast<double>(captures) * period_s * core_hz_())) &
        0xFFFFU;
  }

  std::function<std::uint32_t()> core_hz_;
  std::function<double()> edge_s_;
  std::uint64_t captures_ = 0;
};

}  // namespace trackservo::target

#endif
