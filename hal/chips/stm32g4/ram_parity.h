/* SPDX-License-Identifier: Apache-2.0 */
/* Parity of the RAM: the first 32 KiB of SRAM1 (stack, state of the board and of the node) and the CCM SRAM (hot code).
 *
 * An error switches both bridges off in hardware, through the break inputs of their timers, and is an NMI, which ends
 * in a reset. The same connection switches them off when the core locks up. The option bit SRAM_PE enables the parity;
 * it is set when the board is flashed (docs/board.md). A word must be written before it is read: the start-up does so.
 */
#ifndef TRACKSERVO_STM32G4_RAM_PARITY_H
#define TRACKSERVO_STM32G4_RAM_PARITY_H

#include <stdbool.h>

#include "registers/flash.h"
#include "registers/rcc.h"
#include "registers/syscfg.h"

/* Connects the parity error to the break inputs; no program can undo it before the next reset. */
static inline void ram_parity_connect(void) {
  RCC->apb2enr |= RCC_APB2ENR_SYSCFGEN;
  (void)RCC->apb2enr;
  SYSCFG->cfgr2 = SYSCFG_CFGR2_SPL | SYSCFG_CFGR2_CLL;
}

/* Returns whether the option bit, which is active low, switches the parity on. */
static inline bool ram_parity_is_on(void) { return (FLASH->optr & FLASH_OPTR_SRAM_PE) == 0; }

/* Returns whether an error was found since the reset. */
static inline bool ram_parity_has_failed(void) { return (SYSCFG->cfgr2 & SYSCFG_CFGR2_SPF) != 0; }

#endif
