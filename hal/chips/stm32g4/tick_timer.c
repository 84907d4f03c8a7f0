/* SPDX-License-Identifier: Apache-2.0 */
#include "tick_timer.h"

#include "registers/timer.h"

/* 170 MHz / 4 / 42500 = 1 kHz, 20 periods of 8500 cycles. */
enum { PRESCALER = 4, COUNTS = 42500, TENTHS_OF_COUNTS_PER_US = 425 };

void tick_timer_start(uint32_t delay_us) {
  TIM6->psc = PRESCALER - 1;
  TIM6->arr = COUNTS - 1;
  TIM6->cr1 = TIM6_CR1_ARPE | TIM6_CR1_URS;
  TIM6->egr = TIM6_EGR_UG;
  TIM6->cnt = COUNTS - delay_us * TENTHS_OF_COUNTS_PER_US / 10u;
  TIM6->sr = 0;
  TIM6->dier = TIM6_DIER_UIE;
  TIM6->cr1 = TIM6_CR1_ARPE | TIM6_CR1_URS | TIM6_CR1_CEN;
}

void tick_timer_acknowledge(void) { TIM6->sr = ~TIM6_SR_UIF; }
