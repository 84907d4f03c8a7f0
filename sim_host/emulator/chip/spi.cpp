// SPDX-License-Identifier: Apache-2.0
#include "chip/spi.hpp"

namespace trackservo::target {
namespace {

constexpr std::uint32_t kCr1 = 0x00;
constexpr std::uint32_t kCr2 = 0x04;
constexpr std::uint32_t kSr = 0x08;
constexpr std::uint32_t kDr = 0x0C;

constexpr std::size_t kFifoBytes = 4;

}  // namespace

Spi::Spi(Services services, const char *name, Wiring wiring, DmaMux& dma)
    : Peripheral(name, services,
                 {{"CR1", kCr1, 0, 0xFFFF},
                  {"CR2", kCr2, 0x0700, 0x7FFF},
                  {"SR", kSr, 2, 0x10, 0x1FEF},
                  {"DR", kDr, 0, 0xFFFF, 0, true},
                  {"CRCPR", 0x10, 7, 0xFFFF},
                  {"I2SCFGR", 0x1C, 0, 0x1FBF},
                  {"I2SPR", 0x20, 2, 0x3FF}}),
      wiring_(wiring),
      dma_(dma),
      line_(services.exceptions, wiring.interrupt),
      frame_end_(timeline().add([this] { end_frame(); })) {}

void Spi::on_reset() {
  timeline().cancel(frame_end_);
  transmit_.clear();
  receive_.clear();
  busy_ = overrun_ = false;
  line_.forget();
}

Instant Spi::bit_period() const { return period_of(frequency_hz_()) << ((reg(kCr1) >> 3 & 7U) + 1); }

std::uint32_t Spi::status() const {
  const std::size_t bytes = frame_bits() > 8 ? 2 : 1;
  const std::size_t threshold = (reg(kCr2) & 1U << 12) != 0 ? 1 : 2;
  const std::size_t received = receive_.size() * bytes;
  const std::size_t waiting = transmit_.size() * bytes;
  const auto level = [](std::size_t bytes_held) {
    return static_cast<std::uint32_t>(bytes_held == 0 ? 0 : (bytes_held == 1 ? 1 : (bytes_held < 4 ? 2 : 3)));
  };
  return (received >= threshold ? 1U : 0U) | (waiting <= kFifoBytes / 2 ? 2U : 0U) | (overrun_ ? 1U << 6 : 0U) |
         (busy_ || waiting > 0 ? 1U << 7 : 0U) | level(received) << 9 | level(waiting) << 11;
}

void Spi::refresh_interrupt() {
  const std::uint32_t enabled =
      (reg(kCr2) & 1U << 6 ? 1U : 0U) | (reg(kCr2) & 1U << 7 ? 2U : 0U) | (reg(kCr2) & 1U << 5 ? 1U << 6 : 0U);
  line_.set(is_enabled() && (status() & enabled) != 0);
}

void Spi::check() {
  const std::uint32_t cr1 = reg(kCr1);
  require((cr1 & 1U << 2) != 0, "slave mode is not modelled");
  require((cr1 & 0xB800U) == 0 && (cr1 & 1U << 10) == 0, "CRC, half duplex and receive-only are not modelled");
  require((cr1 & 1U << 9) != 0 ? (cr1 & 1U << 8) != 0 : (reg(kCr2) & 4U) != 0,
          "select input of a master is low: mode fault");
  require((reg(kCr2) & 0x10U) == 0 && reg(0x1C) == 0, "TI and I2S modes are not modelled");
  require(frame_bits() >= 4, "frames of less than 4 bits");
}

void Spi::begin_frame() {
  if (busy_ || transmit_.empty() || !is_enabled()) {
    return;
  }
  transmit_.pop_front();
  busy_ = true;
  const Instant period = bit_period();
  const unsigned bits = frame_bits();
  shifting_ = (1U << bits) - 1;  // an open line is pulled up
  if (device_ != nullptr && clock_pin_()) {
    const bool leading = (reg(kCr1) & 1U) == 0;
    if ((reg(kCr1) & 2U) == 0) {
      report_violation("the clock idles low, but the connected device needs it high");
    } else {
      const std::uint32_t line = device_->clock(bits, timeline().instant(), period, leading);
      shifting_ = data_pin_() ? line : shifting_;
    }
    if ((reg(kCr1) & 1U << 7) != 0) {
      std::uint32_t turned = 0;
      for (unsigned bit = 0; bit < bits; ++bit) {
        turned |= (shifting_ >> bit & 1U) << (bits - 1 - bit);
      }
      shifting_ = turned;
    }
  }
  timeline().set(frame_end_, timeline().instant() + bits * period);
}

void Spi::end_frame() {
  busy_ = false;
  const std::size_t bytes = frame_bits() > 8 ? 2 : 1;
  if ((receive_.size() + 1) * bytes > kFifoBytes) {
    overrun_ = true;
  } else {
    receive_.push_back(shifting_);
  }
  begin_frame();
  serve_dma();
  refresh_interrupt();
}

void Spi::serve_dma() {
  if (serving_ || !is_enabled()) {
    return;
  }
  serving_ = true;
  while ((reg(kCr2) & 1U) != 0 && (status() & 1U) != 0 && dma_.request(wiring_.receive)) {
  }
  while ((reg(kCr2) & 2U) != 0 && (status() & 2U) != 0 && dma_.request(wiring_.transmit)) {
  }
  serving_ = false;
}

std::uint32_t Spi::on_read(std::uint32_t offset, std::uint32_t stored, unsigned width) {
  if (offset == kSr) {
    return status();
  }
  if (offset != kDr) {
    return stored;
  }
  if (width != (frame_bits() > 8 ? 2U : 1U)) {
    report_violation("the data register is read with a width that differs from the frame's");
  }
  if (receive_.empty()) {
    report_violation("the data register is read although nothing was received");
    return 0;
  }
  const std::uint32_t frame = receive_.front();
  receive_.pop_front();
  overrun_ = false;
  refresh_interrupt();
  return frame;
}

void Spi::on_write(std::uint32_t offset, std::uint32_t written, unsigned width) {
  if (offset == kDr) {
    if (width != (frame_bits() > 8 ? 2U : 1U)) {
      report_violation(
          "the data register is written with a width that differs from the frame's: several frames at once");
    }
    require(transmit_.size() * width < kFifoBytes, "written while the transmit buffer is full");
    transmit_.push_back(written & ((1U << frame_bits()) - 1));
    begin_frame();
  } else if (offset != kSr) {
    if (is_enabled() && offset == kCr1) {
      require(((written ^ reg(kCr1)) & 0xBFU) == 0, "clock or format changed while it is enabled");
    }
    if (offset == kCr1 && (written & 1U << 6) == 0 && is_enabled()) {
      require(!busy_ && transmit_.empty(), "switched off during a frame");
    }
    if (is_enabled() && offset == kCr2) {
      require(((written ^ reg(kCr2)) & 0x0F14U) == 0, "frame size changed while it is enabled");
    }
    store(offset, written);
    if (is_enabled()) {
      check();
    }
  }
  serve_dma();
  refresh_interrupt();
}

}  // namespace trackservo::target
