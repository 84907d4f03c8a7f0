/* SPDX-License-Identifier: Apache-2.0 */
/* DMA controllers and the multiplexer of their requests: RM0440, the facts only. */
#ifndef TRACKSERVO_STM32G4_REGISTERS_DMA_H
#define TRACKSERVO_STM32G4_REGISTERS_DMA_H

#include "registers/field.h"

typedef struct {
  volatile uint32_t cr;   /* CCRx */
  volatile uint32_t ndtr; /* CNDTRx */
  volatile uint32_t par;  /* CPARx */
  volatile uint32_t mar;  /* CMARx */
  uint32_t reserved_10;
} dma_ch_registers;
_Static_assert(sizeof(dma_ch_registers) == 0x14, "RM0440: channels are 0x14 apart");

typedef struct {
  volatile uint32_t isr;
  volatile uint32_t ifcr;
  dma_ch_registers ch[8]; /* ch[0] is channel 1 */
} dma1_registers;
REGISTER_AT(dma1_registers, ch, 0x08);

#define DMA1_ISR_TCIF3 FIELD(9, 1)
#define DMA1_ISR_HTIF3 FIELD(10, 1)
#define DMA1_IFCR_CGIF3 FIELD(8, 1)

#define DMA1 ((dma1_registers *)0x40020000u)
#define DMA2 ((dma1_registers *)0x40020400u)

#define DMA_CH_CR_EN FIELD(0, 1)
#define DMA_CH_CR_DIR FIELD(4, 1) /* 1: from memory */
#define DMA_CH_CR_CIRC FIELD(5, 1)
#define DMA_CH_CR_MINC FIELD(7, 1)
#define DMA_CH_CR_PSIZE FIELD(8, 2)
#define DMA_CH_CR_MSIZE FIELD(10, 2)
#define DMA_CH_CR_PL FIELD(12, 2)
enum { DMA_PRIORITY_HIGH = 2, DMA_SIZE_32 = 2 };

/* Channels 0 .. 7 of the multiplexer serve DMA1 1 .. 8, channels 8 .. 15 DMA2 1 .. 8. */
typedef struct {
  volatile uint32_t ccr[16];
} dmamux_registers;

#define DMAMUX ((dmamux_registers *)0x40020800u)

#define DMAMUX_CCR_DMAREQ_ID FIELD(0, 7)
enum {
  DMAMUX_SPI1_RX = 10,
  DMAMUX_SPI1_TX = 11,
  DMAMUX_SPI3_RX = 14,
  DMAMUX_SPI3_TX = 15,
  DMAMUX_USART1_RX = 24,
  DMAMUX_USART3_RX = 28,
  DMAMUX_TIM5_CH2 = 73
};

#endif
