/* SPDX-License-Identifier: Apache-2.0 */
#include "clock_check.h"

#include "clock.h"
#include "registers/rcc.h"
#include "registers/timer.h"

enum { HSI_HZ = 16000000, MCO_DIVIDER = 16, EDGES = 8 };
enum { COUNTS = CLOCK_HZ / HSI_HZ * MCO_DIVIDER * EDGES + CLOCK_HZ % HSI_HZ * EDGES / (HSI_HZ / MCO_DIVIDER) };
_Static_assert(COUNTS == 1360, "170 MHz against 16 MHz");
enum { MAX_ERROR_COUNTS = 25 }; /* 1.84 %: 3 % minus the 1 % of HSI16 are 26.4 counts */

enum { MAX_WRONG = 3, MAX_MISSED = 50, MAX_POLLS = 2000 };

void clock_check_start(void) {
  RCC->cfgr |= FIELD_VALUE(RCC_CFGR_MCOSEL, RCC_MCOSEL_HSI16) | FIELD_VALUE(RCC_CFGR_MCOPRE, RCC_MCOPRE_DIV16);
  RCC->apb2enr |= RCC_APB2ENR_TIM16EN;
  (void)RCC->apb2enr;
  TIM16->tisel = FIELD_VALUE(TIM16_TISEL_TI1SEL, TIM16_TI1_MCO);
  TIM16->ccmr1_input =
      FIELD_VALUE(TIM16_CCMR1_INPUT_CC1S, TIM16_CC1S_TI1) | FIELD_VALUE(TIM16_CCMR1_INPUT_IC1PSC, TIM16_IC1PSC_8);
  TIM16->ccer = TIM16_CCER_CC1E;
  TIM16->cr1 = TIM16_CR1_CEN;
}

static bool wait_for_capture(void) {
  for (int poll = 0; poll < MAX_POLLS; ++poll) {
    if ((TIM16->sr & TIM16_SR_CC1IF) != 0) {
      return true;
    }
  }
  return false;
}

/* Reading the capture clears its flag. A second capture before that sets the other flag: an interrupt came between. */
static bool measure(uint32_t *counts) {
  TIM16->sr = 0;
  if (!wait_for_capture()) {
    return false;
  }
  const uint32_t first = TIM16->ccr1;
  if (!wait_for_capture()) {
    return false;
  }
  *counts = (TIM16->ccr1 - first) & UINT16_MAX;
  return (TIM16->sr & TIM16_SR_CC1OF) == 0;
}

void clock_check_step(clock_check *check) {
  uint32_t counts = 0;
  if (!measure(&counts)) {
    check->missed += check->missed < MAX_MISSED ? 1 : 0;
    check->failed = check->failed || check->missed >= MAX_MISSED;
    return;
  }
  const bool right = counts >= COUNTS - MAX_ERROR_COUNTS && counts <= COUNTS + MAX_ERROR_COUNTS;
  check->missed = 0;
  check->wrong = right ? 0 : check->wrong + (check->wrong < MAX_WRONG ? 1 : 0);
  check->failed = check->wrong >= MAX_WRONG;
}
