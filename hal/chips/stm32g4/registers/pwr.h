/* SPDX-License-Identifier: Apache-2.0 */
/* Power control: RM0440, the facts only. */
#ifndef TRACKSERVO_STM32G4_REGISTERS_PWR_H
#define TRACKSERVO_STM32G4_REGISTERS_PWR_H

#include "registers/field.h"

typedef struct {
  volatile uint32_t cr1;
  volatile uint32_t cr2;
  volatile uint32_t cr3;
  volatile uint32_t cr4;
  volatile uint32_t sr1;
  volatile uint32_t sr2;
  uint32_t reserved_18[26];
  volatile uint32_t cr5;
} pwr_registers;
REGISTER_AT(pwr_registers, cr5, 0x80);

#define PWR ((pwr_registers *)0x40007000u)

#define PWR_CR1_RESET 0x00000200u /* VOS: range 1 */
#define PWR_CR1_VOS FIELD(9, 2)

#define PWR_CR3_RESET 0x00008000u
#define PWR_CR3_UCPD1_DBDIS FIELD(14, 1)

#define PWR_SR2_VOSF FIELD(10, 1)

#define PWR_CR5_RESET 0x00000100u
#define PWR_CR5_R1MODE FIELD(8, 1) /* 0: boost, for more than 150 MHz */

#endif
