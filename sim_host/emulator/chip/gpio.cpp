// SPDX-License-Identifier: Apache-2.0
#include "chip/gpio.hpp"

namespace trackservo::target {
namespace {

constexpr std::uint32_t kIdr = 0x10;
constexpr std::uint32_t kOdr = 0x14;
constexpr std::uint32_t kBsrr = 0x18;
constexpr std::uint32_t kBrr = 0x28;
constexpr std::uint32_t kEveryBit = 0xFFFFFFFF;

// After reset, ports A and B have the debug pins in alternate function 0.
std::uint32_t moder_reset(char port) { return port == 'A' ? 0xABFFFFFF : (port == 'B' ? 0xFFFFFEBF : kEveryBit); }

}  // namespace

Gpio::Gpio(Services services, char port)
    : Peripheral(std::string("GPIO") + port, services,
                 {
                     {"MODER", 0x00, moder_reset(port), kEveryBit},
                     {"OTYPER", 0x04, 0, 0xFFFF},
                     {"OSPEEDR", 0x08, port == 'A' ? 0x0C000000U : (port == 'B' ? 0xC0U : 0U), kEveryBit},
                     {"PUPDR", 0x0C, port == 'A' ? 0x64000000U : (port == 'B' ? 0x100U : 0U), kEveryBit},
                     {"IDR", kIdr, 0, 0, 0xFFFF},
                     {"ODR", kOdr, 0, 0xFFFF},
                     {"BSRR", kBsrr, 0, kEveryBit},
                     {"AFRL", 0x20, 0, kEveryBit},
                     {"AFRH", 0x24, 0, kEveryBit},
                     {"BRR", kBrr, 0, 0xFFFF},
                 }) {}

std::uint32_t Gpio::on_read(std::uint32_t offset, std::uint32_t stored, unsigned /*width*/) {
  if (offset != kIdr) {
    return stored;
  }
  std::uint32_t levels = 0;
  for (unsigned pin = 0; pin < 16; ++pin) {
    const bool high = mode(pin) == Mode::kOutput ? drives_high(pin) : input(pin);
    levels |= high && mode(pin) != Mode::kAnalog ? 1U << pin : 0U;
  }
  return levels;
}

void Gpio::on_write(std::uint32_t offset, std::uint32_t written, unsigned /*width*/) {
  if (offset == kBsrr) {
    reg(kOdr) = (reg(kOdr) & ~(written >> 16)) | (written & 0xFFFF);
  } else if (offset == kBrr) {
    reg(kOdr) &= ~written;
  } else {
    if (offset == 0x00 && name() == "GPIOA") {
      require((written >> 26 & 0xFU) == 0xAU, "the debugger's pins PA13 and PA14 are reassigned");
    }
    store(offset, written);
  }
  changed();
}

}  // namespace trackservo::target
