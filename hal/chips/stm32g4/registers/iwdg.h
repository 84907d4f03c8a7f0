/* SPDX-License-Identifier: Apache-2.0 */
/* Independent watchdog: RM0440, the facts only. */
#ifndef TRACKSERVO_STM32G4_REGISTERS_IWDG_H
#define TRACKSERVO_STM32G4_REGISTERS_IWDG_H

#include "registers/field.h"

typedef struct {
  volatile uint32_t kr;
  volatile uint32_t pr;
  volatile uint32_t rlr;
  volatile uint32_t sr;
  volatile uint32_t winr;
} iwdg_registers;
REGISTER_AT(iwdg_registers, winr, 0x10);

#define IWDG ((iwdg_registers *)0x40003000u)

enum { IWDG_KEY_START = 0xCCCC, IWDG_KEY_ACCESS = 0x5555, IWDG_KEY_RELOAD = 0xAAAA };

#define IWDG_PR_PR FIELD(0, 3)
enum { IWDG_PR_DIV_4 = 0 };

#define IWDG_RLR_RESET 0x00000FFFu
#define IWDG_RLR_RL FIELD(0, 12)
#define IWDG_SR_PVU FIELD(0, 1)
#define IWDG_SR_RVU FIELD(1, 1)
#define IWDG_SR_WVU FIELD(2, 1)
#define IWDG_WINR_RESET 0x00000FFFu
#define IWDG_WINR_WIN FIELD(0, 12)

#endif
