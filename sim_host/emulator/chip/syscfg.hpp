// SPDX-License-Identifier: Apache-2.0
// The system configuration controller (RM0440, 10): parity errors and core lock-ups to the timers' break inputs, write
// protection of the CCM SRAM by pages of 1 KiB. Lock bits and protected pages stay so until the next reset.
#ifndef TRACKSERVO_SIM_EMULATOR_CHIP_SYSCFG_HPP
#define TRACKSERVO_SIM_EMULATOR_CHIP_SYSCFG_HPP

#include <functional>
#include <utility>

#include "core/peripheral.hpp"

namespace trackservo::target {

class Syscfg : public Peripheral {
 public:
  explicit Syscfg(Services services)
      : Peripheral("SYSCFG", services,
                   {{"MEMRMP", 0x00, 0, 0x107},
                    {"CFGR1", 0x04, 0x7C000001, 0xFDFF0301},
                    {"EXTICR1", 0x08, 0, 0xFFFF},
                    {"EXTICR2", 0x0C, 0, 0xFFFF},
                    {"EXTICR3", 0x10, 0, 0xFFFF},
                    {"EXTICR4", 0x14, 0, 0xFFFF},
                    {"SCSR", 0x18, 0, 1, 2},
                    {"CFGR2", kCfgr2, 0, 0x10F},
                    {"SWPR", kSwpr, 0, 0xFFFFFFFF}}) {}

  // Notes that the RAM found a word whose parity is wrong.
  void find_parity_error() {
    reg(kCfgr2) |= kParityFlag;
    exceptions().pend(kNmi);
    changed();
  }
  void find_lock_up() {
    locked_up_ = true;
    changed();
  }

  // Returns what the timers see at their break inputs.
  bool breaks_timers() const {
    const std::uint32_t cfgr2 = reg(kCfgr2);
    return (locked_up_ && (cfgr2 & 1U) != 0) || ((cfgr2 & kParityFlag) != 0 && (cfgr2 & 2U) != 0);
  }
  void on_break(std::function<void()> listener) { break_changed_ = std::move(listener); }

  // Returns which pages of the CCM SRAM are protected, a bit per page.
  std::uint32_t protected_pages() const { return reg(kSwpr); }
  void on_protection(std::function<void()> listener) { protection_changed_ = std::move(listener); }

 protected:
  void on_write(std::uint32_t offset, std::uint32_t written, unsigned /*width*/) override {
    if (offset == kCfgr2) {
      reg(kCfgr2) = (reg(kCfgr2) | (written & 0xFU)) & ~(written & kParityFlag);
      changed();
    } else if (offset == kSwpr) {
      reg(kSwpr) |= written;
      protection_changed_();
    } else {
      require(offset != 0x18, "erasing the CCM SRAM is not modelled");
      store(offset, written);
    }
  }

  void on_reset() override {
    locked_up_ = false;
    if (protection_changed_) {
      protection_changed_();
    }
    changed();
  }

 private:
  static constexpr std::uint32_t kCfgr2 = 0x1C;
  static constexpr std::uint32_t kSwpr = 0x20;
  static constexpr std::uint32_t kParityFlag = 1U << 8;

  void changed() {
    if (break_changed_) {
      break_changed_();
    }
  }

  bool locked_up_ = false;
  std::function<void()> break_changed_;
  std::function<void()> protection_changed_;
};

}  // namespace trackservo::target

#endif
