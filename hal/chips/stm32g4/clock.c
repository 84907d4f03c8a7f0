/* SPDX-License-Identifier: Apache-2.0 */
#include "clock.h"

#include "registers/core.h"
#include "registers/dbgmcu.h"
#include "registers/flash.h"
#include "registers/pwr.h"
#include "registers/rcc.h"

/* RM0440: f = crystal / M * N / R, 340 MHz in between. */
enum { PLL_M = 6, PLL_N = 85, PLL_R = 2, FLASH_WAIT_STATES = 4 };

/* Polls of a flag before giving up; the crystal may take 2 ms, at 16 MHz and about 10 cycles each. */
enum { MAX_POLLS = 20000 };

static bool wait_for(const volatile uint32_t *word, uint32_t mask, uint32_t wanted) {
  for (int poll = 0; poll < MAX_POLLS; ++poll) {
    if ((*word & mask) == wanted) {
      return true;
    }
  }
  return false;
}

/* More than 150 MHz needs the boost of range 1 (RM0440) and four wait states. */
static bool prepare_for_170_mhz(void) {
  RCC->apb1enr1 |= RCC_APB1ENR1_PWREN;
  (void)RCC->apb1enr1;
  PWR->cr5 &= ~PWR_CR5_R1MODE;
  PWR->cr3 |= PWR_CR3_UCPD1_DBDIS; /* otherwise USB-C pull-downs load PB4 and PB6 */
  FLASH->acr |= FLASH_ACR_ICEN | FLASH_ACR_DCEN | FLASH_ACR_PRFTEN;
  field_set(&FLASH->acr, FLASH_ACR_LATENCY, FLASH_WAIT_STATES);
  return wait_for(&FLASH->acr, FLASH_ACR_LATENCY, FIELD_VALUE(FLASH_ACR_LATENCY, FLASH_WAIT_STATES));
}

static bool start_pll(void) {
  RCC->cr |= RCC_CR_HSEON;
  if (!wait_for(&RCC->cr, RCC_CR_HSERDY, RCC_CR_HSERDY)) {
    return false;
  }
  RCC->pllcfgr = FIELD_VALUE(RCC_PLLCFGR_PLLSRC, RCC_PLLSRC_HSE) | FIELD_VALUE(RCC_PLLCFGR_PLLM, PLL_M - 1) |
                 FIELD_VALUE(RCC_PLLCFGR_PLLN, PLL_N) | FIELD_VALUE(RCC_PLLCFGR_PLLR, PLL_R / 2 - 1) |
                 RCC_PLLCFGR_PLLREN;
  RCC->cr |= RCC_CR_PLLON;
  return wait_for(&RCC->cr, RCC_CR_PLLRDY, RCC_CR_PLLRDY);
}

/* Through half the speed for at least 1 us (RM0440). */
static bool switch_to_pll(void) {
  const int polls_of_1_us = 100;
  field_set(&RCC->cfgr, RCC_CFGR_HPRE, RCC_HPRE_DIV2);
  field_set(&RCC->cfgr, RCC_CFGR_SW, RCC_SYSCLK_PLL);
  if (!wait_for(&RCC->cfgr, RCC_CFGR_SWS, FIELD_VALUE(RCC_CFGR_SWS, RCC_SYSCLK_PLL))) {
    return false;
  }
  /* Bound: a constant of the function. */
  for (int poll = 0; poll < polls_of_1_us; ++poll) {
    (void)RCC->cfgr;
  }
  field_set(&RCC->cfgr, RCC_CFGR_HPRE, RCC_HPRE_DIV1);
  return true;
}

bool clock_start(void) {
  if (!prepare_for_170_mhz() || !start_pll() || !switch_to_pll()) {
    return false;
  }
  RCC->cr |= RCC_CR_CSSON;
  return true;
}

/* A debugger that halts the core also stops the timers, and with them the outputs of the bridges. */
static void stop_with_the_core(void) {
  DBGMCU->apb1l_fz |= DBGMCU_APB1L_FZ_DBG_TIMER6_STOP | DBGMCU_APB1L_FZ_DBG_IWDG_STOP;
  DBGMCU->apb2_fz |= DBGMCU_APB2_FZ_DBG_TIM1_STOP | DBGMCU_APB2_FZ_DBG_TIM8_STOP;
}

void clock_enable_peripherals(void) {
  RCC->ahb1enr |= RCC_AHB1ENR_DMA1EN | RCC_AHB1ENR_DMA2EN | RCC_AHB1ENR_DMAMUX1EN;
  RCC->ahb2enr |= RCC_AHB2ENR_GPIOAEN | RCC_AHB2ENR_GPIOBEN | RCC_AHB2ENR_GPIOCEN | RCC_AHB2ENR_ADC12EN;
  RCC->apb1enr1 |= RCC_APB1ENR1_TIM6EN | RCC_APB1ENR1_SPI3EN | RCC_APB1ENR1_USART3EN | RCC_APB1ENR1_FDCANEN;
  RCC->apb2enr |= RCC_APB2ENR_TIM1EN | RCC_APB2ENR_TIM8EN | RCC_APB2ENR_SPI1EN | RCC_APB2ENR_USART1EN;
  field_set(&RCC->ccipr, RCC_CCIPR_FDCANSEL, RCC_FDCANSEL_PCLK1);
  (void)RCC->ccipr;
  stop_with_the_core();
}

void clock_start_cycle_counter(void) {
  DCB->demcr |= DCB_DEMCR_TRCENA;
  DWT->cyccnt = 0;
  DWT->ctrl |= DWT_CTRL_CYCCNTENA;
}

uint32_t clock_cycles(void) { return DWT->cyccnt; }

void clock_wait_us(uint32_t us) {
  const uint32_t start = clock_cycles();
  /* Bound: the requested time, on the core's own counter. */
  while (clock_cycles() - start < us * CLOCK_CYCLES_PER_US) {
  }
}
