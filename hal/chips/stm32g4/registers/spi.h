/* SPDX-License-Identifier: Apache-2.0 */
/* Serial peripheral interface: RM0440, the facts only. */
#ifndef TRACKSERVO_STM32G4_REGISTERS_SPI_H
#define TRACKSERVO_STM32G4_REGISTERS_SPI_H

#include "registers/field.h"

typedef struct {
  volatile uint32_t cr1;
  volatile uint32_t cr2;
  volatile uint32_t sr;
  volatile uint32_t dr;
} spi1_registers;
REGISTER_AT(spi1_registers, dr, 0x0C);

#define SPI1 ((spi1_registers *)0x40013000u)
#define SPI3 ((spi1_registers *)0x40003C00u)

#define SPI1_CR1_CPHA FIELD(0, 1)
#define SPI1_CR1_CPOL FIELD(1, 1)
#define SPI1_CR1_MSTR FIELD(2, 1)
#define SPI1_CR1_BR FIELD(3, 3)
#define SPI1_CR1_SPE FIELD(6, 1)
#define SPI1_CR1_SSI FIELD(8, 1)
#define SPI1_CR1_SSM FIELD(9, 1)
enum { SPI1_BR_PCLK_32 = 4 };

#define SPI1_CR2_RESET 0x00000700u /* DS: 8 bit */
#define SPI1_CR2_RXDMAEN FIELD(0, 1)
#define SPI1_CR2_TXDMAEN FIELD(1, 1)
#define SPI1_CR2_DS FIELD(8, 4) /* bits - 1 */
#define SPI1_CR2_FRXTH FIELD(12, 1)

#define SPI1_SR_RESET 0x00000002u /* TXE */
#define SPI1_SR_BSY FIELD(7, 1)

#endif
