/* SPDX-License-Identifier: Apache-2.0 */
/* Debug support: RM0440, the facts only. */
#ifndef TRACKSERVO_STM32G4_REGISTERS_DBGMCU_H
#define TRACKSERVO_STM32G4_REGISTERS_DBGMCU_H

#include "registers/field.h"

typedef struct {
  volatile uint32_t idcode;
  volatile uint32_t cr;
  volatile uint32_t apb1l_fz; /* APB1FZR1 */
  volatile uint32_t apb1h_fz; /* APB1FZR2 */
  volatile uint32_t apb2_fz;  /* APB2FZR */
} dbgmcu_registers;
REGISTER_AT(dbgmcu_registers, apb2_fz, 0x10);

#define DBGMCU ((dbgmcu_registers *)0xE0042000u)

#define DBGMCU_APB1L_FZ_DBG_TIMER6_STOP FIELD(4, 1)
#define DBGMCU_APB1L_FZ_DBG_IWDG_STOP FIELD(12, 1)
#define DBGMCU_APB2_FZ_DBG_TIM1_STOP FIELD(11, 1)
#define DBGMCU_APB2_FZ_DBG_TIM8_STOP FIELD(13, 1)

#endif
