/* SPDX-License-Identifier: Apache-2.0 */
/* Embedded flash memory interface: RM0440 (category 3 devices). */
#ifndef TRACKSERVO_STM32G4_REGISTERS_FLASH_H
#define TRACKSERVO_STM32G4_REGISTERS_FLASH_H

#include "registers/field.h"

typedef struct {
  volatile uint32_t acr;
  volatile uint32_t pdkeyr;
  volatile uint32_t keyr;
  volatile uint32_t optkeyr;
  volatile uint32_t sr;
  volatile uint32_t cr;
  volatile uint32_t eccr;
  uint32_t reserved_1c;
  volatile uint32_t optr;
  uint32_t reserved_24[2];
  volatile uint32_t wrp1ar;
  volatile uint32_t wrp1br;
} flash_registers;
REGISTER_AT(flash_registers, optr, 0x20);
REGISTER_AT(flash_registers, wrp1ar, 0x2C);

#define FLASH ((flash_registers *)0x40022000u)

#define FLASH_ACR_RESET 0x00040600u
#define FLASH_ACR_LATENCY FIELD(0, 4)
#define FLASH_ACR_PRFTEN FIELD(8, 1)
#define FLASH_ACR_ICEN FIELD(9, 1)
#define FLASH_ACR_DCEN FIELD(10, 1)
#define FLASH_ACR_DCRST FIELD(12, 1)

#define FLASH_KEY_1 0x45670123u
#define FLASH_KEY_2 0xCDEF89ABu

#define FLASH_SR_EOP FIELD(0, 1)
#define FLASH_SR_OPERR FIELD(1, 1)
#define FLASH_SR_PROGERR FIELD(3, 1)
#define FLASH_SR_WRPERR FIELD(4, 1)
#define FLASH_SR_PGAERR FIELD(5, 1)
#define FLASH_SR_SIZERR FIELD(6, 1)
#define FLASH_SR_PGSERR FIELD(7, 1)
#define FLASH_SR_MISERR FIELD(8, 1)
#define FLASH_SR_FASTERR FIELD(9, 1)
#define FLASH_SR_BSY FIELD(16, 1)

#define FLASH_CR_RESET 0xC0000000u
#define FLASH_CR_PG FIELD(0, 1)
#define FLASH_CR_PER FIELD(1, 1)
#define FLASH_CR_PNB FIELD(3, 7)
#define FLASH_CR_BKER FIELD(11, 1)
#define FLASH_CR_STRT FIELD(16, 1)
#define FLASH_CR_LOCK FIELD(31, 1)

#define FLASH_ECCR_BK_ECC FIELD(21, 1)
#define FLASH_ECCR_ECCC FIELD(30, 1)
#define FLASH_ECCR_ECCD FIELD(31, 1)

#define FLASH_OPTR_RESET 0xFFEFF8AAu /* as ST ships the chip */
#define FLASH_OPTR_RDP FIELD(0, 8)
#define FLASH_OPTR_BFB2 FIELD(20, 1)
#define FLASH_OPTR_DBANK FIELD(22, 1)
#define FLASH_OPTR_SRAM_PE FIELD(24, 1) /* 0: parity of SRAM1 and CCM SRAM on */
enum { FLASH_RDP_LEVEL_0 = 0xAA };

/* Pages of bank 1 that cannot be written: from STRT to END, none when STRT is above END. */
#define FLASH_WRP1AR_WRP1A_STRT FIELD(0, 7)
#define FLASH_WRP1AR_WRP1A_END FIELD(16, 7)

#endif
