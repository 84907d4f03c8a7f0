// SPDX-License-Identifier: Apache-2.0
// Reset and clock control (RM0440, 7): oscillators, PLL, bus prescalers, peripheral clocks, the cause of a reset.
#ifndef TRACKSERVO_SIM_EMULATOR_CHIP_RCC_HPP
#define TRACKSERVO_SIM_EMULATOR_CHIP_RCC_HPP

#include <functional>

#include "core/peripheral.hpp"

namespace trackservo::target {

// Bits of RCC_CSR.
enum class ResetCause : std::uint32_t {
  kPowerOn = 1U << 27 | 1U << 26,
  kPin = 1U << 26,
  kSoftware = 1U << 28 | 1U << 26,
  kWatchdog = 1U << 29 | 1U << 26,
};

class Rcc : public Peripheral {
 public:
  static constexpr std::uint32_t kCrystalHz = 24'000'000;

  // Signals outside the clock tree on which it depends.
  struct Supply {
    std::function<std::uint32_t()> flash_wait_states;
    std::function<bool()> is_range_1;
    std::function<bool()> is_boosted;
    std::function<void(std::uint32_t core_hz)> clock_changed;
  };

  explicit Rcc(Services services);
  void supplied_by(Supply supply) { supply_ = std::move(supply); }

  void report_cause(ResetCause cause);
  std::uint32_t causes() const { return causes_; }

  std::uint32_t core_hz() const { return core_hz_; }
  std::uint32_t pclk1_hz() const { return core_hz_ >> shift_of(reg(0x08) >> 8 & 7U); }
  std::uint32_t pclk2_hz() const { return core_hz_ >> shift_of(reg(0x08) >> 11 & 7U); }
  // Returns the time between two edges of MCO, when it gives HSI16; otherwise 0. `hsi_error` is that of the ratio of
  // the two oscillators: which of them is wrong cannot be seen.
  double mco_edge_s() const {
    const std::uint32_t cfgr = reg(0x08);
    const bool hsi = (cfgr >> 24 & 0xFU) == 3;
    return hsi ? static_cast<double>(1U << (cfgr >> 28 & 7U)) / (16e6 * (1.0 + hsi_error_)) : 0.0;
  }
  void set_hsi_error(double share) { hsi_error_ = share; }

  bool is_lsi_on() const { return (reg(0x94) & 1U) != 0; }

  // Returns a bit of an enable register, for Peripheral::clocked_by.
  std::function<bool()> clock(std::uint32_t enable_register, unsigned bit) const {
    return [this, enable_register, bit] { return (reg(enable_register) >> bit & 1U) != 0; };
  }
  // Returns a two-bit clock selection of CCIPR.
  unsigned selection(unsigned bit) const { return reg(0x88) >> bit & 3U; }

 protected:
  std::uint32_t on_read(std::uint32_t offset, std::uint32_t stored, unsigned width) override;
  void on_write(std::uint32_t offset, std::uint32_t written, unsigned width) override;
  void on_reset() override;

 private:
  static unsigned shift_of(std::uint32_t prescaler) { return prescaler < 4 ? 0 : prescaler - 3; }
  std::uint32_t pll_hz() const;
  void write_cr(std::uint32_t written);
  void write_cfgr(std::uint32_t written);
  void check_speed();

  Supply supply_;
  std::uint32_t core_hz_ = 16'000'000;
  Instant hse_ready_ = 0;
  Instant pll_ready_ = 0;
  Instant lsi_ready_ = 0;
  std::uint32_t causes_ = 0;
  double hsi_error_ = 0;
};

}  // namespace trackservo::target

#endif
