/* SPDX-License-Identifier: Apache-2.0 */
#include "strobe.h"

#include "clock.h"
#include "registers/dma.h"
#include "registers/rcc.h"

enum { CHANNEL = 2 };            /* of DMA2, from 0 */
enum { DMAMUX_OF_DMA2 = 8 };     /* its first channel in the multiplexer */
enum { FILTER_8_OF_DIV32 = 15 }; /* eight equal samples at 170 MHz / 32 */

#define BOTH_MARKS (DMA1_ISR_HTIF3 | DMA1_ISR_TCIF3)

static void start_ring(strobe_line *line) {
  dma_ch_registers *channel = &DMA2->ch[CHANNEL];
  const uint32_t mode = DMA_CH_CR_MINC | DMA_CH_CR_CIRC | FIELD_VALUE(DMA_CH_CR_PSIZE, DMA_SIZE_32) |
                        FIELD_VALUE(DMA_CH_CR_MSIZE, DMA_SIZE_32);
  DMAMUX->ccr[DMAMUX_OF_DMA2 + CHANNEL] = FIELD_VALUE(DMAMUX_CCR_DMAREQ_ID, DMAMUX_TIM5_CH2);
  channel->par = (uint32_t)(uintptr_t)&TIM5->ccr2;
  channel->mar = (uint32_t)(uintptr_t)line->ring;
  channel->ndtr = STROBE_RING;
  channel->cr = mode;
  channel->cr = mode | DMA_CH_CR_EN;
}

void strobe_start(strobe_line *line) {
  line->taken = 0;
  RCC->apb1enr1 |= RCC_APB1ENR1_TIM5EN;
  (void)RCC->apb1enr1;
  start_ring(line);
  TIM5->psc = CLOCK_CYCLES_PER_US - 1;
  TIM5->egr = TIM2_EGR_UG;
  TIM5->ccmr1_input =
      FIELD_VALUE(TIM2_CCMR1_INPUT_CC2S, TIM2_CC2S_TI2) | FIELD_VALUE(TIM2_CCMR1_INPUT_IC2F, FILTER_8_OF_DIV32);
  TIM5->dier = TIM2_DIER_CC2DE;
  TIM5->ccer = TIM2_CCER_CC2E;
  TIM5->cr1 = TIM2_CR1_CEN;
}

/* Who passes both marks, the middle and the end of the ring, since the last call wrote more than half of it. */
void strobe_take(strobe_line *line, hal_strobes *strobes) {
  const uint32_t marks = DMA2->isr & BOTH_MARKS;
  const uint32_t end = (STROBE_RING - DMA2->ch[CHANNEL].ndtr) % STROBE_RING;
  const uint32_t count = (end - line->taken) % STROBE_RING;
  DMA2->ifcr = DMA1_IFCR_CGIF3;
  strobes->flooded = marks == BOTH_MARKS || count > HAL_STROBES;
  strobes->count = strobes->flooded ? 0 : count;
  for (uint32_t i = 0; i < HAL_STROBES && i < strobes->count; ++i) {
    strobes->at_us[i] = line->ring[(line->taken + i) % STROBE_RING];
  }
  line->taken = end;
}
