/* SPDX-License-Identifier: Apache-2.0 */
/* Advanced-control timers TIM1 and TIM8, general-purpose timers TIM5 and TIM16 and the basic timer TIM6, whose
 * registers lie at the same offsets: RM0440, the facts only. */
#ifndef TRACKSERVO_STM32G4_REGISTERS_TIMER_H
#define TRACKSERVO_STM32G4_REGISTERS_TIMER_H

#include "registers/field.h"

typedef struct {
  volatile uint32_t cr1;
  volatile uint32_t cr2;
  volatile uint32_t smcr;
  volatile uint32_t dier;
  volatile uint32_t sr;
  volatile uint32_t egr;
  volatile uint32_t ccmr1_output;
  volatile uint32_t ccmr2_output;
  volatile uint32_t ccer;
  volatile uint32_t cnt;
  volatile uint32_t psc;
  volatile uint32_t arr;
  volatile uint32_t rcr;
  volatile uint32_t ccr1;
  volatile uint32_t ccr2;
  volatile uint32_t ccr3;
  volatile uint32_t ccr4;
  volatile uint32_t bdtr;
  uint32_t reserved_48[6];
  volatile uint32_t af1;
  volatile uint32_t af2;
} tim1_registers;
REGISTER_AT(tim1_registers, bdtr, 0x44);
REGISTER_AT(tim1_registers, af1, 0x60);
REGISTER_AT(tim1_registers, af2, 0x64);

#define TIM1 ((tim1_registers *)0x40012C00u)
#define TIM8 ((tim1_registers *)0x40013400u)

#define TIM1_CR1_CEN FIELD(0, 1)
#define TIM1_CR1_CMS FIELD(5, 2)
#define TIM1_CR1_ARPE FIELD(7, 1)
enum { TIM1_CMS_CENTRE_1 = 1 };

#define TIM1_CR2_MMS FIELD(4, 3)
#define TIM1_CR2_MMS2 FIELD(20, 4)
enum { TIM1_MMS_ENABLE = 1, TIM1_MMS2_UPDATE = 2 };

#define TIM1_SMCR_SMS FIELD(0, 3)
#define TIM1_SMCR_TS FIELD(4, 3)
enum { TIM1_SMS_TRIGGER = 6, TIM8_TS_TIM1 = 0 }; /* ITR0 of TIM8 is TIM1's TRGO */

#define TIM1_DIER_UIE FIELD(0, 1)
#define TIM1_DIER_BIE FIELD(7, 1)

#define TIM1_SR_UIF FIELD(0, 1)
#define TIM1_SR_BIF FIELD(7, 1)
#define TIM1_SR_B2IF FIELD(8, 1)

#define TIM1_EGR_UG FIELD(0, 1)

#define TIM1_CCMR1_OUTPUT_OC1PE FIELD(3, 1)
#define TIM1_CCMR1_OUTPUT_OC1M FIELD(4, 3)
#define TIM1_CCMR1_OUTPUT_OC2PE FIELD(11, 1)
#define TIM1_CCMR1_OUTPUT_OC2M FIELD(12, 3)
enum { TIM1_OCM_PWM_1 = 6 };

#define TIM1_CCER_CC1E FIELD(0, 1)
#define TIM1_CCER_CC1NE FIELD(2, 1)
#define TIM1_CCER_CC2E FIELD(4, 1)
#define TIM1_CCER_CC2NE FIELD(6, 1)

#define TIM1_ARR_RESET 0x0000FFFFu

#define TIM1_BDTR_DTG FIELD(0, 8)
#define TIM1_BDTR_LOCK FIELD(8, 2)
#define TIM1_BDTR_OSSI FIELD(10, 1)
#define TIM1_BDTR_OSSR FIELD(11, 1)
#define TIM1_BDTR_BKE FIELD(12, 1)
#define TIM1_BDTR_BKP FIELD(13, 1)
#define TIM1_BDTR_MOE FIELD(15, 1)
#define TIM1_BDTR_BKF FIELD(16, 4)

#define TIM1_BDTR_BK2F FIELD(20, 4)
#define TIM1_BDTR_BK2E FIELD(24, 1)

#define TIM1_AF2_RESET 0x00000001u
#define TIM1_AF2_BK2INE FIELD(0, 1)

#define TIM1_AF1_RESET 0x00000001u
#define TIM1_AF1_BKINE FIELD(0, 1)

typedef struct {
  volatile uint32_t cr1;
  volatile uint32_t cr2;
  volatile uint32_t smcr;
  volatile uint32_t dier;
  volatile uint32_t sr;
  volatile uint32_t egr;
  volatile uint32_t ccmr1_input;
  volatile uint32_t ccmr2_input;
  volatile uint32_t ccer;
  volatile uint32_t cnt;
  volatile uint32_t psc;
  volatile uint32_t arr;
  uint32_t reserved_30;
  volatile uint32_t ccr1;
  volatile uint32_t ccr2;
} tim2_registers;
REGISTER_AT(tim2_registers, ccr2, 0x38);

#define TIM5 ((tim2_registers *)0x40000C00u)

#define TIM2_CR1_CEN FIELD(0, 1)
#define TIM2_DIER_CC2DE FIELD(10, 1)
#define TIM2_EGR_UG FIELD(0, 1)
#define TIM2_CCMR1_INPUT_CC2S FIELD(8, 2)
#define TIM2_CCMR1_INPUT_IC2F FIELD(12, 4)
#define TIM2_CCER_CC2E FIELD(4, 1)
#define TIM2_ARR_RESET 0xFFFFFFFFu
enum { TIM2_CC2S_TI2 = 1 };

typedef struct {
  volatile uint32_t cr1;
  volatile uint32_t cr2;
  uint32_t reserved_08;
  volatile uint32_t dier;
  volatile uint32_t sr;
  volatile uint32_t egr;
  volatile uint32_t ccmr1_input;
  uint32_t reserved_1c;
  volatile uint32_t ccer;
  volatile uint32_t cnt;
  volatile uint32_t psc;
  volatile uint32_t arr;
  volatile uint32_t rcr;
  volatile uint32_t ccr1;
  uint32_t reserved_38[9];
  volatile uint32_t tisel;
} tim16_registers;
REGISTER_AT(tim16_registers, ccr1, 0x34);
REGISTER_AT(tim16_registers, tisel, 0x5C);

#define TIM16 ((tim16_registers *)0x40014400u)

#define TIM16_CR1_CEN FIELD(0, 1)
#define TIM16_SR_CC1IF FIELD(1, 1)
#define TIM16_SR_CC1OF FIELD(9, 1)
#define TIM16_CCMR1_INPUT_CC1S FIELD(0, 2)
#define TIM16_CCMR1_INPUT_IC1PSC FIELD(2, 2)
#define TIM16_CCER_CC1E FIELD(0, 1)
#define TIM16_ARR_RESET 0x0000FFFFu
#define TIM16_TISEL_TI1SEL FIELD(0, 4)
enum { TIM16_CC1S_TI1 = 1, TIM16_IC1PSC_8 = 3, TIM16_TI1_MCO = 2 };

typedef struct {
  volatile uint32_t cr1;
  volatile uint32_t cr2;
  uint32_t reserved_08;
  volatile uint32_t dier;
  volatile uint32_t sr;
  volatile uint32_t egr;
  uint32_t reserved_18[3];
  volatile uint32_t cnt;
  volatile uint32_t psc;
  volatile uint32_t arr;
} tim6_registers;
REGISTER_AT(tim6_registers, arr, 0x2C);

#define TIM6 ((tim6_registers *)0x40001000u)

#define TIM6_CR1_CEN FIELD(0, 1)
#define TIM6_CR1_URS FIELD(2, 1)
#define TIM6_CR1_ARPE FIELD(7, 1)
#define TIM6_DIER_UIE FIELD(0, 1)
#define TIM6_SR_UIF FIELD(0, 1)
#define TIM6_EGR_UG FIELD(0, 1)
#define TIM6_ARR_RESET 0x0000FFFFu

#endif
