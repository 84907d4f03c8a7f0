// SPDX-License-Identifier: Apache-2.0
// Peripherals of which the board uses only registers that store written values: the debug unit's freeze bits, and the
// words programmed in the factory (unique identifier, flash size).
#ifndef TRACKSERVO_SIM_EMULATOR_CHIP_FIXED_REGISTERS_HPP
#define TRACKSERVO_SIM_EMULATOR_CHIP_FIXED_REGISTERS_HPP

#include "core/peripheral.hpp"

namespace trackservo::target {

// Sleep with the debugger attached is not emulated; freezing a counter matters only to a debugger.
class DebugUnit : public Peripheral {
 public:
  explicit DebugUnit(Services services)
      : Peripheral("DBGMCU", services,
                   {{"IDCODE", 0x00, 0x10036469, 0},
                    {"CR", 0x04, 0, 0xE7},
                    {"APB1FZR1", 0x08, 0, 0xC0601C3F},
                    {"APB1FZR2", 0x0C, 0, 2},
                    {"APB2FZ", 0x10, 0, 0x3C172800}}) {}
};

// 0x1FFF7000.
class FactoryWords : public Peripheral {
 public:
  static constexpr std::uint32_t kUniqueId[3] = {0x00310027, 0x3138470D, 0x20363836};

  explicit FactoryWords(Services services)
      : Peripheral("factory words", services,
                   {{"UID", 0x590, kUniqueId[0], 0, 0, true},
                    {"UID", 0x594, kUniqueId[1], 0, 0, true},
                    {"UID", 0x598, kUniqueId[2], 0, 0, true},
                    {"flash size", 0x5E0, 0xFFFF0200, 0, 0, true}}) {}
};

}  // namespace trackservo::target

#endif
