// SPDX-License-Identifier: Apache-2.0
// TIM5 (RM0440, 29) as far as the board uses it: a counter of 32 bits that captures the rising edges at its second
// input and has DMA fetch them.
#ifndef TRACKSERVO_SIM_EMULATOR_CHIP_CLOCK_TIMER_HPP
#define TRACKSERVO_SIM_EMULATOR_CHIP_CLOCK_TIMER_HPP

#include <functional>
#include <utility>

#include "chip/dma.hpp"
#include "core/peripheral.hpp"

namespace trackservo::target {

class ClockTimer : public Peripheral {
 public:
  ClockTimer(Services services, DmaMux& dma_mux)
      : Peripheral("TIM5", services,
                   {{"CR1", kCr1, 0, 0x8FF},
                    {"DIER", kDier, 0, 0x5F5F},
                    {"SR", kSr, 0, 0xFFFFFFFF},
                    {"EGR", kEgr, 0, 0x5F},
                    {"CCMR1", kCcmr1, 0, 0xFFFF},
                    {"CCER", kCcer, 0, 0xBBBB},
                    {"CNT", kCnt, 0, 0xFFFFFFFF, 0xFFFFFFFF},
                    {"PSC", kPsc, 0, 0xFFFF},
                    {"ARR", kArr, 0xFFFFFFFF, 0xFFFFFFFF},
                    {"CCR2", kCcr2, 0, 0, 0xFFFFFFFF}}),
        dma_mux_(dma_mux) {}

  // Sets the source of the kernel clock's frequency, and whether the second input is connected to its pin.
  void clocked_at(std::function<std::uint32_t()> frequency_hz) { frequency_hz_ = std::move(frequency_hz); }
  void wired_by(std::function<bool()> pin) { pin_ = std::move(pin); }

  // Takes a rising edge at the second input, now. The input's filter is not modelled.
  void rise() {
    const bool captures = (reg(kCcer) & 1U << 4) != 0 && (reg(kCcmr1) >> 8 & 3U) == 1 && pin_();
    if (!captures) {
      return;
    }
    require((reg(kCcer) & 1U << 5) == 0, "the falling edge is selected");
    reg(kSr) |= (reg(kSr) & kCaptured) != 0 ? kOverCaptured : kCaptured;
    reg(kCcr2) = count();
    if ((reg(kDier) & 1U << 10) != 0) {
      dma_mux_.request(DmaRequest::kTim5Ch2);
    }
  }

 protected:
  std::uint32_t on_read(std::uint32_t offset, std::uint32_t stored, unsigned /*width*/) override {
    if (offset == kCcr2) {
      reg(kSr) &= ~kCaptured;
    }
    return offset == kCnt ? count() : stored;
  }

  void on_write(std::uint32_t offset, std::uint32_t written, unsigned /*width*/) override {
    if (offset == kSr) {
      reg(kSr) &= written;
    } else if (offset == kEgr && (written & 1U) != 0) {
      prescale_ = reg(kPsc);
      reg(kSr) |= 1U;
      begin_at(0);
    } else if (offset == kCnt) {
      begin_at(written);
    } else if (offset == kCr1) {
      const std::uint32_t now = count();
      store(offset, written);
      begin_at(now);
    } else {
      require(offset != kArr || written == 0xFFFFFFFF, "a limit of the count is not modelled");
      store(offset, written);
    }
  }

  void on_reset() override {
    prescale_ = 0;
    begin_at(0);
  }

 private:
  static constexpr std::uint32_t kCr1 = 0x00;
  static constexpr std::uint32_t kDier = 0x0C;
  static constexpr std::uint32_t kSr = 0x10;
  static constexpr std::uint32_t kEgr = 0x14;
  static constexpr std::uint32_t kCcmr1 = 0x18;
  static constexpr std::uint32_t kCcer = 0x20;
  static constexpr std::uint32_t kCnt = 0x24;
  static constexpr std::uint32_t kPsc = 0x28;
  static constexpr std::uint32_t kArr = 0x2C;
  static constexpr std::uint32_t kCcr2 = 0x38;
  static constexpr std::uint32_t kCaptured = 1U << 2;
  static constexpr std::uint32_t kOverCaptured = 1U << 10;

  void begin_at(std::uint32_t count) {
    count_ = count;
    began_ = timeline().now();
  }

  std::uint32_t count() const {
    if ((reg(kCr1) & 1U) == 0) {
      return count_;
    }
    const double counts = seconds_of(timeline().now() - began_) * frequency_hz_() / (prescale_ + 1.0);
    return count_ + static_cast<std::uint32_t>(static_cast<std::uint64_t>(counts));
  }

  DmaMux& dma_mux_;
  std::function<std::uint32_t()> frequency_hz_;
  std::function<bool()> pin_;
  std::uint32_t prescale_ = 0;  // in force
  std::uint32_t count_ = 0;     // at `began_`
  Instant began_ = 0;
};

}  // namespace trackservo::target

#endif
