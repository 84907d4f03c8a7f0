/* SPDX-License-Identifier: Apache-2.0 */
/* Reset and clock control: RM0440, the facts only. */
#ifndef TRACKSERVO_STM32G4_REGISTERS_RCC_H
#define TRACKSERVO_STM32G4_REGISTERS_RCC_H

#include "registers/field.h"

typedef struct {
  volatile uint32_t cr;
  volatile uint32_t icscr;
  volatile uint32_t cfgr;
  volatile uint32_t pllcfgr;
  uint32_t reserved_10[2];
  volatile uint32_t cier;
  volatile uint32_t cifr;
  volatile uint32_t cicr;
  uint32_t reserved_24;
  volatile uint32_t ahb1rstr;
  volatile uint32_t ahb2rstr;
  volatile uint32_t ahb3rstr;
  uint32_t reserved_34;
  volatile uint32_t apb1rstr1;
  volatile uint32_t apb1rstr2;
  volatile uint32_t apb2rstr;
  uint32_t reserved_44;
  volatile uint32_t ahb1enr;
  volatile uint32_t ahb2enr;
  volatile uint32_t ahb3enr;
  uint32_t reserved_54;
  volatile uint32_t apb1enr1;
  volatile uint32_t apb1enr2;
  volatile uint32_t apb2enr;
  uint32_t reserved_64[9];
  volatile uint32_t ccipr;
  uint32_t reserved_8c[2];
  volatile uint32_t csr;
} rcc_registers;
REGISTER_AT(rcc_registers, csr, 0x94);

#define RCC ((rcc_registers *)0x40021000u)

#define RCC_CR_RESET 0x00000063u
#define RCC_CR_HSEON FIELD(16, 1)
#define RCC_CR_HSERDY FIELD(17, 1)
#define RCC_CR_CSSON FIELD(19, 1)
#define RCC_CR_PLLON FIELD(24, 1)
#define RCC_CR_PLLRDY FIELD(25, 1)

#define RCC_CFGR_RESET 0x00000005u
#define RCC_CFGR_SW FIELD(0, 2)
#define RCC_CFGR_SWS FIELD(2, 2)
#define RCC_CFGR_HPRE FIELD(4, 4)
#define RCC_CFGR_MCOSEL FIELD(24, 4)
#define RCC_CFGR_MCOPRE FIELD(28, 3)
enum { RCC_MCOSEL_HSI16 = 3, RCC_MCOPRE_DIV16 = 4 };
#define RCC_CFGR_PPRE1 FIELD(8, 3)
#define RCC_CFGR_PPRE2 FIELD(11, 3)
enum { RCC_SYSCLK_PLL = 3, RCC_HPRE_DIV1 = 0, RCC_HPRE_DIV2 = 8, RCC_PPRE_DIV1 = 0 };

#define RCC_PLLCFGR_RESET 0x00001000u
#define RCC_PLLCFGR_PLLSRC FIELD(0, 2)
#define RCC_PLLCFGR_PLLM FIELD(4, 4) /* divider - 1 */
#define RCC_PLLCFGR_PLLN FIELD(8, 7)
#define RCC_PLLCFGR_PLLREN FIELD(24, 1)
#define RCC_PLLCFGR_PLLR FIELD(25, 2) /* divider / 2 - 1 */
enum { RCC_PLLSRC_HSE = 3 };

#define RCC_CIFR_CSSF FIELD(8, 1)
#define RCC_CICR_CSSC FIELD(8, 1)

#define RCC_AHB1ENR_RESET 0x00000100u
#define RCC_AHB1ENR_DMA1EN FIELD(0, 1)
#define RCC_AHB1ENR_DMA2EN FIELD(1, 1)
#define RCC_AHB1ENR_DMAMUX1EN FIELD(2, 1)

#define RCC_AHB2ENR_GPIOAEN FIELD(0, 1)
#define RCC_AHB2ENR_GPIOBEN FIELD(1, 1)
#define RCC_AHB2ENR_GPIOCEN FIELD(2, 1)
#define RCC_AHB2ENR_ADC12EN FIELD(13, 1)

#define RCC_APB1ENR1_RESET 0x00000400u
#define RCC_APB1ENR1_TIM5EN FIELD(3, 1)
#define RCC_APB1ENR1_TIM6EN FIELD(4, 1)
#define RCC_APB1ENR1_SPI3EN FIELD(15, 1)
#define RCC_APB1ENR1_USART3EN FIELD(18, 1)
#define RCC_APB1ENR1_FDCANEN FIELD(25, 1)
#define RCC_APB1ENR1_PWREN FIELD(28, 1)

#define RCC_APB2ENR_SYSCFGEN FIELD(0, 1)
#define RCC_APB2ENR_TIM1EN FIELD(11, 1)
#define RCC_APB2ENR_SPI1EN FIELD(12, 1)
#define RCC_APB2ENR_TIM8EN FIELD(13, 1)
#define RCC_APB2ENR_USART1EN FIELD(14, 1)
#define RCC_APB2ENR_TIM16EN FIELD(17, 1)

#define RCC_CCIPR_FDCANSEL FIELD(24, 2)
enum { RCC_FDCANSEL_PCLK1 = 2 };

#define RCC_CSR_RESET 0x0C000000u
#define RCC_CSR_RMVF FIELD(23, 1)
#define RCC_CSR_OBLRSTF FIELD(25, 1)
#define RCC_CSR_PINRSTF FIELD(26, 1)
#define RCC_CSR_BORRSTF FIELD(27, 1)
#define RCC_CSR_SFTRSTF FIELD(28, 1)
#define RCC_CSR_IWDGRSTF FIELD(29, 1)
#define RCC_CSR_WWDGRSTF FIELD(30, 1)
#define RCC_CSR_LPWRRSTF FIELD(31, 1)

#endif
