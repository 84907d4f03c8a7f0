// SPDX-License-Identifier: Apache-2.0
#include "chip/usart.hpp"

#include <cmath>

namespace trackservo::target {
namespace {

constexpr std::uint32_t kCr1 = 0x00;
constexpr std::uint32_t kCr2 = 0x04;
constexpr std::uint32_t kCr3 = 0x08;
constexpr std::uint32_t kBrr = 0x0C;
constexpr std::uint32_t kRqr = 0x18;
constexpr std::uint32_t kIsr = 0x1C;
constexpr std::uint32_t kIcr = 0x20;
constexpr std::uint32_t kRdr = 0x24;
constexpr std::uint32_t kTdr = 0x28;

constexpr std::uint32_t kFrameError = 1U << 1;
constexpr std::uint32_t kOverrun = 1U << 3;
constexpr std::uint32_t kIdle = 1U << 4;
constexpr std::uint32_t kNotEmpty = 1U << 5;
constexpr std::uint32_t kSendReady = 1U << 6 | 1U << 7;  // transmission complete, register empty

constexpr double kRateTolerance = 0.02;  // of both ends together, for ten bits

}  // namespace

Usart::Usart(Services services, const char *name, Wiring wiring, DmaMux& dma)
    : Peripheral(name, services,
                 {{"CR1", kCr1, 0, 0xFFFFFFFF},
                  {"CR2", kCr2, 0, 0xFFFFFF79},
                  {"CR3", kCr3, 0, 0xFFFFFFFF},
                  {"BRR", kBrr, 0, 0xFFFF},
                  {"GTPR", 0x10, 0, 0xFFFF},
                  {"RTOR", 0x14, 0, 0xFFFFFFFF},
                  {"RQR", kRqr, 0, 0x1F},
                  {"ISR", kIsr, 0xC0, 0, 0x0FFFFFFF},
                  {"ICR", kIcr, 0, 0x123BFF},
                  {"RDR", kRdr, 0, 0, 0x1FF, true},
                  {"TDR", kTdr, 0, 0x1FF, 0, true},
                  {"PRESC", 0x2C, 0, 0xF}}),
      wiring_(wiring),
      dma_(dma),
      line_(services.exceptions, wiring.interrupt),
      idle_(timeline().add([this] {
        reg(kIsr) |= kIdle;
        refresh_interrupt();
      })) {}

void Usart::on_reset() {
  timeline().cancel(idle_);
  line_.forget();
}

double Usart::bits_per_s() const {
  constexpr unsigned kPrescaler[] = {1, 2, 4, 6, 8, 10, 12, 16, 32, 64, 128, 256};
  const std::uint32_t divider = reg(kBrr);
  const std::uint32_t index = reg(0x2C);
  const double clock = static_cast<double>(frequency_hz_()) / kPrescaler[index < 12 ? index : 11];
  return (reg(kCr1) & 1U << 15) != 0 ? 2.0 * clock / ((divider & 0xFFF0U) | (divider & 7U) << 1)
                                     : clock / std::max(divider, 1U);
}

void Usart::check() {
  require(reg(kBrr) >= 16, "switched on with a baud-rate divider below 16");
  require((reg(kCr1) & 0x10001400U) == 0, "word lengths other than eight bits and parity are not modelled");
  require((reg(kCr1) & 1U << 29) == 0, "the FIFO is not modelled");
  require((reg(kCr2) & ~0x3000U) == 0 && (reg(kCr3) & 0x0001072FU & ~1U) == 0,
          "synchronous, inverted, half-duplex and flow-controlled modes are not modelled");
}

void Usart::receive(std::uint8_t character, double bits_per_s) {
  if (!is_on() || (reg(kCr1) & 4U) == 0 || !receive_pin_()) {
    return;
  }
  const bool in_time = std::abs(bits_per_s / this->bits_per_s() - 1.0) < kRateTolerance;
  if ((reg(kIsr) & kNotEmpty) != 0 && (reg(kCr3) & 1U << 12) == 0) {
    reg(kIsr) |= kOverrun;
  } else {
    reg(kRdr) = in_time ? character : static_cast<std::uint8_t>(~character << 1);
    reg(kIsr) |= kNotEmpty | (in_time ? 0U : kFrameError);
  }
  if ((reg(kCr3) & 1U << 6) != 0) {
    dma_.request(wiring_.receive);
  }
  timeline().set(idle_, timeline().instant() + character_time());
  refresh_interrupt();
}

void Usart::refresh_interrupt() {
  const std::uint32_t control = reg(kCr1);
  const std::uint32_t status = reg(kIsr);
  const bool received = (control & 1U << 5) != 0 && (status & (kNotEmpty | kOverrun)) != 0;
  const bool idle = (control & kIdle) != 0 && (status & kIdle) != 0;
  const bool error = (reg(kCr3) & 1U) != 0 && (status & (kFrameError | kOverrun)) != 0;
  const bool sent = (control & status & kSendReady) != 0;
  line_.set(is_on() && (received || idle || error || sent));
}

std::uint32_t Usart::on_read(std::uint32_t offset, std::uint32_t stored, unsigned /*width*/) {
  if (offset == kRdr) {
    reg(kIsr) &= ~kNotEmpty;
    refresh_interrupt();
  }
  if (offset == kIsr) {
    const bool on = is_on();
    return stored | (on && (reg(kCr1) & 8U) != 0 ? 1U << 21 : 0U) | (on && (reg(kCr1) & 4U) != 0 ? 1U << 22 : 0U);
  }
  return stored;
}

void Usart::on_write(std::uint32_t offset, std::uint32_t written, unsigned /*width*/) {
  if (offset == kIcr) {
    reg(kIsr) &= ~(written & 0x1FU);
  } else if (offset == kRqr) {
    reg(kIsr) &= (written & 8U) != 0 ? ~kNotEmpty : 0xFFFFFFFFU;
  } else if (offset == kTdr) {
    require(is_on() && (reg(kCr1) & 8U) != 0, "a character is sent while the transmitter is off");
    sent_.push_back(static_cast<std::uint8_t>(written));
  } else {
    if (is_on() && (offset == kBrr || offset == kCr2 || offset == 0x2C)) {
      report_violation("configured while it is on");
    }
    store(offset, written);
    if (is_on()) {
      check();
    }
  }
  refresh_interrupt();
}

}  // namespace trackservo::target
