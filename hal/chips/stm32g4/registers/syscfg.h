/* SPDX-License-Identifier: Apache-2.0 */
/* System configuration controller: parity and write protection of the SRAM: RM0440, the facts only. */
#ifndef TRACKSERVO_STM32G4_REGISTERS_SYSCFG_H
#define TRACKSERVO_STM32G4_REGISTERS_SYSCFG_H

#include "registers/field.h"

typedef struct {
  volatile uint32_t memrmp;
  volatile uint32_t cfgr1;
  uint32_t reserved_08[4];
  volatile uint32_t scsr;
  volatile uint32_t cfgr2;
  volatile uint32_t swpr; /* a bit per KiB of the CCM SRAM; a set bit stays set until the next reset */
} syscfg_registers;
REGISTER_AT(syscfg_registers, cfgr2, 0x1C);
REGISTER_AT(syscfg_registers, swpr, 0x20);

#define SYSCFG ((syscfg_registers *)0x40010000u)

#define SYSCFG_CFGR1_RESET 0x7C000001u

#define SYSCFG_CFGR2_CLL FIELD(0, 1) /* lock-up of the core: to the timers' break inputs */
#define SYSCFG_CFGR2_SPL FIELD(1, 1) /* parity error of the SRAM: the same */
#define SYSCFG_CFGR2_SPF FIELD(8, 1) /* a parity error was found; cleared by writing one */

#endif
