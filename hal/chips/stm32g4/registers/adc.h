/* SPDX-License-Identifier: Apache-2.0 */
/* Analog-to-digital converters: RM0440, the facts only. */
#ifndef TRACKSERVO_STM32G4_REGISTERS_ADC_H
#define TRACKSERVO_STM32G4_REGISTERS_ADC_H

#include "registers/field.h"

typedef struct {
  volatile uint32_t isr;
  volatile uint32_t ier;
  volatile uint32_t cr;
  volatile uint32_t cfgr;
  volatile uint32_t cfgr2;
  volatile uint32_t smpr1;
  volatile uint32_t smpr2;
  uint32_t reserved_1c[12];
  volatile uint32_t jsqr;
  uint32_t reserved_50[12];
  volatile uint32_t jdr1;
  volatile uint32_t jdr2;
} adc1_registers;
REGISTER_AT(adc1_registers, jsqr, 0x4C);
REGISTER_AT(adc1_registers, jdr2, 0x84);

#define ADC1 ((adc1_registers *)0x50000000u)
#define ADC2 ((adc1_registers *)0x50000100u)

#define ADC1_ISR_ADRDY FIELD(0, 1)
#define ADC1_ISR_JEOS FIELD(6, 1)
#define ADC1_IER_JEOSIE FIELD(6, 1)

#define ADC1_CR_RESET 0x20000000u
#define ADC1_CR_ADEN FIELD(0, 1)
#define ADC1_CR_JADSTART FIELD(3, 1)
#define ADC1_CR_ADVREGEN FIELD(28, 1)
#define ADC1_CR_DEEPPWD FIELD(29, 1)
#define ADC1_CR_ADCAL FIELD(31, 1)

#define ADC1_CFGR_RESET 0x80000000u /* JQDIS: no queue of injected sequences */
#define ADC1_CFGR_JQDIS FIELD(31, 1)

#define ADC1_SMPR1_SMP1 FIELD(3, 3)
#define ADC1_SMPR1_SMP2 FIELD(6, 3)
#define ADC1_SMPR1_SMP6 FIELD(18, 3)
#define ADC1_SMPR1_SMP7 FIELD(21, 3)
enum { ADC1_SMP_12_5_CYCLES = 2 };

#define ADC1_JSQR_JL FIELD(0, 2)
#define ADC1_JSQR_JEXTSEL FIELD(2, 5)
#define ADC1_JSQR_JEXTEN FIELD(7, 2)
#define ADC1_JSQR_JSQ1 FIELD(9, 5)
#define ADC1_JSQR_JSQ2 FIELD(15, 5)
enum { ADC1_JL_2_CONVERSIONS = 1, ADC1_JEXTSEL_TIM1_TRGO2 = 8, ADC1_JEXTEN_RISING = 1 };

typedef struct {
  volatile uint32_t csr;
  uint32_t reserved_04;
  volatile uint32_t ccr;
} adc12_common_registers;
REGISTER_AT(adc12_common_registers, ccr, 0x08);

#define ADC12_COMMON ((adc12_common_registers *)0x50000300u)

#define ADC12_COMMON_CCR_CKMODE FIELD(16, 2)
enum { ADC12_CKMODE_HCLK_4 = 3 };

#endif
