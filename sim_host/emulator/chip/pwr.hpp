// SPDX-License-Identifier: Apache-2.0
// Power control (RM0440, 6): voltage range and boost.
#ifndef TRACKSERVO_SIM_EMULATOR_CHIP_PWR_HPP
#define TRACKSERVO_SIM_EMULATOR_CHIP_PWR_HPP

#include "core/peripheral.hpp"

namespace trackservo::target {

class Pwr : public Peripheral {
 public:
  explicit Pwr(Services services)
      : Peripheral("PWR", services,
                   {{"CR1", 0x00, 0x200, 0x470F},
                    {"CR2", 0x04, 0, 0xCF},
                    {"CR3", 0x08, 0x8000, 0xE51F},
                    {"CR4", 0x0C, 0, 0x31F},
                    {"SR1", 0x10, 0, 0, 0x0000831F},
                    {"SR2", 0x14, 0x100, 0, 0x0000CF00},
                    {"SCR", 0x18, 0, 0x11F},
                    {"CR5", 0x80, 0x100, 0x100}}) {}

  bool is_range_1() const { return (reg(0x00) >> 9 & 3U) == 1; }
  bool is_boosted() const { return is_range_1() && (reg(0x80) & 0x100U) == 0; }

 protected:
  void on_write(std::uint32_t offset, std::uint32_t written, unsigned /*width*/) override {
    store(offset, written);
    if (offset == 0x00) {
      const std::uint32_t range = written >> 9 & 3U;
      require(range == 1 || range == 2, "voltage range 0 or 3 does not exist");
      require((written & 7U) == 0, "low-power modes are not modelled");
    }
  }
};

}  // namespace trackservo::target

#endif
