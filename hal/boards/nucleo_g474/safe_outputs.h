/* SPDX-License-Identifier: Apache-2.0 */
/* Outputs off: both bridges' timers without main output enable, both driver enables low, both brakes without current.
 *
 * It needs no RAM except a little stack, no clock except the one after reset, and no initialisation, so a reset and
 * every fault do it first. */
#ifndef TRACKSERVO_NUCLEO_G474_SAFE_OUTPUTS_H
#define TRACKSERVO_NUCLEO_G474_SAFE_OUTPUTS_H

#include "registers/gpio.h"
#include "registers/rcc.h"
#include "registers/timer.h"

enum { AZIMUTH_ENABLE_PIN = 8, PITCH_ENABLE_PIN = 9, PIN_MODE_OUTPUT = 1 }; /* of port C */
enum { AZIMUTH_BRAKE_PIN = 15, PITCH_BRAKE_PIN = 9 };                       /* of port B */

static inline void safe_outputs(void) {
  RCC->ahb2enr |= RCC_AHB2ENR_GPIOBEN | RCC_AHB2ENR_GPIOCEN;
  RCC->apb2enr |= RCC_APB2ENR_TIM1EN | RCC_APB2ENR_TIM8EN;
  (void)RCC->apb2enr; /* a clock needs two cycles before the first access; reading back takes that long */
  TIM1->bdtr &= ~TIM1_BDTR_MOE;
  TIM8->bdtr &= ~TIM1_BDTR_MOE;
  GPIOC->bsrr = GPIO_CLEAR(AZIMUTH_ENABLE_PIN) | GPIO_CLEAR(PITCH_ENABLE_PIN);
  GPIOB->bsrr = GPIO_CLEAR(AZIMUTH_BRAKE_PIN) | GPIO_CLEAR(PITCH_BRAKE_PIN);
  field_set(&GPIOB->moder, GPIO_PIN_2BIT(AZIMUTH_BRAKE_PIN), PIN_MODE_OUTPUT);
  field_set(&GPIOB->moder, GPIO_PIN_2BIT(PITCH_BRAKE_PIN), PIN_MODE_OUTPUT);
  field_set(&GPIOC->moder, GPIO_PIN_2BIT(AZIMUTH_ENABLE_PIN), PIN_MODE_OUTPUT);
  field_set(&GPIOC->moder, GPIO_PIN_2BIT(PITCH_ENABLE_PIN), PIN_MODE_OUTPUT);
}

#endif
