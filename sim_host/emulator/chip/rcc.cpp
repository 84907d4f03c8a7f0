// SPDX-License-Identifier: Apache-2.0
#include "chip/rcc.hpp"

#include <algorithm>

namespace trackservo::target {
namespace {

constexpr std::uint32_t kCr = 0x00;
constexpr std::uint32_t kCfgr = 0x08;
constexpr std::uint32_t kPllcfgr = 0x0C;
constexpr std::uint32_t kCsr = 0x94;

constexpr std::uint32_t kHsiOn = 1U << 8;
constexpr std::uint32_t kHsiReady = 1U << 10;
constexpr std::uint32_t kHseOn = 1U << 16;
constexpr std::uint32_t kHseReady = 1U << 17;
constexpr std::uint32_t kPllOn = 1U << 24;
constexpr std::uint32_t kPllReady = 1U << 25;

constexpr std::uint32_t kHsiHz = 16'000'000;
constexpr Instant kHseStartup = 2000 * kUnitsPerMicrosecond;  // data sheet, typical
constexpr Instant kPllStartup = 40 * kUnitsPerMicrosecond;
constexpr Instant kLsiStartup = 130 * kUnitsPerMicrosecond;

}  // namespace

Rcc::Rcc(Services services)
    : Peripheral("RCC", services,
                 {
                     {"CR", kCr, 0x00000500, 0x010D0300, 0x02020400},
                     {"ICSCR", 0x04, 0x40000000, 0x7F000000, 0x00FF0000},
                     {"CFGR", kCfgr, 0x00000005, 0x7F003FF3, 0x0000000C},
                     {"PLLCFGR", kPllcfgr, 0x00001000, 0xFF737FF3},
                     {"CIER", 0x18, 0, 0x0000067B},
                     {"CIFR", 0x1C, 0, 0, 0x0000077B},
                     {"CICR", 0x20, 0, 0x0000077B},
                     {"AHB1RSTR", 0x28, 0, 0x0000111F},
                     {"AHB2RSTR", 0x2C, 0, 0x050F607F},
                     {"APB1RSTR1", 0x38, 0, 0xD2FEC13F},
                     {"APB1RSTR2", 0x3C, 0, 0x00000103},
                     {"APB2RSTR", 0x40, 0, 0x0437F801},
                     {"AHB1ENR", 0x48, 0x00000100, 0x0000111F},
                     {"AHB2ENR", 0x4C, 0, 0x050F607F},
                     {"AHB3ENR", 0x50, 0, 0x00000101},
                     {"APB1ENR1", 0x58, 0x00000400, 0xD2FECD3F},
                     {"APB1ENR2", 0x5C, 0, 0x00000103},
                     {"APB2ENR", 0x60, 0, 0x0437F801},
                     {"CCIPR", 0x88, 0, 0xFFFFFFFF},
                     {"BDCR", 0x90, 0, 0x0301833D, 0x42},
                     {"CSR", kCsr, 0x0C000000, 0x00800001, 0xFE000002},
                     {"CRRCR", 0x98, 0, 1, 0xFF82},
                     {"CCIPR2", 0x9C, 0, 0x00300003},
                 }) {}

void Rcc::on_reset() {
  core_hz_ = kHsiHz;
  hse_ready_ = pll_ready_ = lsi_ready_ = 0;
  if (supply_.clock_changed) {
    supply_.clock_changed(core_hz_);
  }
}

void Rcc::report_cause(ResetCause cause) {
  causes_ =
      cause == ResetCause::kPowerOn ? static_cast<std::uint32_t>(cause) : causes_ | static_cast<std::uint32_t>(cause);
}

std::uint32_t Rcc::pll_hz() const {
  const std::uint32_t config = reg(kPllcfgr);
  const std::uint32_t source = config & 3U;
  const std::uint32_t input = source == 3 ? kCrystalHz : (source == 2 ? kHsiHz : 0);
  const std::uint32_t reference = input / ((config >> 4 & 0xFU) + 1);
  const std::uint32_t vco = reference * (config >> 8 & 0x7FU);
  require(reference >= 2'660'000 && reference <= 16'000'000, "PLL input outside 2.66 to 16 MHz");
  require(vco >= 96'000'000 && vco <= 344'000'000, "PLL oscillator outside 96 to 344 MHz");
  require((config & 1U << 24) != 0, "PLL output R is not enabled");
  return vco / (2 * ((config >> 25 & 3U) + 1));
}

void Rcc::write_cr(std::uint32_t written) {
  const std::uint32_t old = reg(kCr);
  require(!((old & kPllOn) == 0 && (written & kPllOn) != 0) || (reg(kPllcfgr) & 3U) != 3 ||
              ((old & kHseOn) != 0 && timeline().now() >= hse_ready_),
          "PLL switched on before its crystal is ready");
  if ((written & ~old & kHseOn) != 0) {
    hse_ready_ = timeline().now() + kHseStartup;
  }
  if ((written & ~old & kPllOn) != 0) {
    pll_ready_ = timeline().now() + kPllStartup;
    (void)pll_hz();
  }
  const std::uint32_t clock = reg(kCfgr) & 3U;
  require(!(clock == 3 && (written & kPllOn) == 0) && !(clock == 1 && (written & kHsiOn) == 0) &&
              !((clock == 2 || (clock == 3 && (reg(kPllcfgr) & 3U) == 3)) && (written & kHseOn) == 0),
          "the clock source of the core is switched off");
  store(kCr, written);
}

void Rcc::write_cfgr(std::uint32_t written) {
  store(kCfgr, written);
  const std::uint32_t wanted = written & 3U;
  std::uint32_t hz = kHsiHz;
  if (wanted == 3) {
    require((reg(kCr) & kPllOn) != 0 && timeline().now() >= pll_ready_, "switched to a PLL that is not ready");
    hz = pll_hz();
  } else if (wanted == 2) {
    require((reg(kCr) & kHseOn) != 0 && timeline().now() >= hse_ready_, "switched to a crystal that is not ready");
    hz = kCrystalHz;
  } else if (wanted == 0) {
    report_violation("system clock selection 0 is not allowed");
  }
  const std::uint32_t prescaler = written >> 4 & 0xFU;
  constexpr unsigned kAhbShift[] = {1, 2, 3, 4, 6, 7, 8, 9};
  hz >>= prescaler < 8 ? 0 : kAhbShift[prescaler - 8];
  if (hz == 0) {
    report_violation("switched to a PLL without an input: the core stops");
    return;
  }
  if (hz != core_hz_) {
    require(hz <= 85'000'000 || core_hz_ > 80'000'000,
            "core clock raised from below to above 80 MHz without a step at half the frequency");
    core_hz_ = hz;
    check_speed();
    require(kUnitsPerSecond % hz == 0, "a core clock that the emulator cannot count exactly");
    supply_.clock_changed(hz);
  }
  reg(kCfgr) = (reg(kCfgr) & ~0xCU) | wanted << 2;
}

// Flash wait states and voltage range (RM0440, tables 9 and 29): range 1 boosted up to 170 MHz, normal up to 150 MHz.
void Rcc::check_speed() {
  const std::uint32_t mhz = core_hz_ / 1'000'000;
  require(supply_.is_range_1() || mhz <= 26, "core faster than 26 MHz in voltage range 2");
  require(supply_.is_boosted() || mhz <= 150, "core faster than 150 MHz without boost");
  const std::uint32_t per_state = supply_.is_boosted() ? 34 : 30;
  require(supply_.flash_wait_states() >= (mhz + per_state - 1) / per_state - 1, "too few flash wait states");
}

std::uint32_t Rcc::on_read(std::uint32_t offset, std::uint32_t stored, unsigned /*width*/) {
  const Instant now = timeline().now();
  if (offset == kCr) {
    const bool hse = (stored & kHseOn) != 0 && now >= hse_ready_;
    const bool pll = (stored & kPllOn) != 0 && now >= pll_ready_;
    const bool hsi = (stored & kHsiOn) != 0;
    return (stored & ~(kHsiReady | kHseReady | kPllReady)) | (hse ? kHseReady : 0) | (pll ? kPllReady : 0) |
           (hsi ? kHsiReady : 0);
  }
  if (offset == kCsr) {
    const bool ready = (stored & 1U) != 0 && now >= lsi_ready_;
    return (stored & 1U) | (ready ? 2U : 0U) | causes_;
  }
  return stored;
}

void Rcc::on_write(std::uint32_t offset, std::uint32_t written, unsigned /*width*/) {
  if (offset == kCr) {
    write_cr(written);
  } else if (offset == kCfgr) {
    write_cfgr(written);
  } else if (offset == kPllcfgr) {
    require((reg(kCr) & kPllOn) == 0, "PLLCFGR written while the PLL runs");
    store(offset, written);
  } else if (offset == kCsr) {
    if ((written & 1U) != 0 && (reg(kCsr) & 1U) == 0) {
      lsi_ready_ = timeline().now() + kLsiStartup;
    }
    if ((written & 1U << 23) != 0) {
      causes_ = 0;
    }
    reg(kCsr) = written & 1U;
  } else if (offset >= 0x28 && offset <= 0x40) {
    require(written == 0, "resetting peripherals by RCC is not modelled");
  } else {
    store(offset, written);
  }
}

}  // namespace trackservo::target
