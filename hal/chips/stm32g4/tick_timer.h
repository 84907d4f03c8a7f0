/* SPDX-License-Identifier: Apache-2.0 */
/* The 1 ms tick: TIM6, from the same clock as the PWM and so at a fixed position between its periods. */
#ifndef TRACKSERVO_STM32G4_TICK_TIMER_H
#define TRACKSERVO_STM32G4_TICK_TIMER_H

#include <stdint.h>

/* Starts the tick and its interrupt's flag. The first one comes `delay_us` (1 .. 999) from now. */
void tick_timer_start(uint32_t delay_us);

void tick_timer_acknowledge(void);

#endif
