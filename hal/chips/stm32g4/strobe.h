/* SPDX-License-Identifier: Apache-2.0 */
/* TIM5: the machine's clock in us, and the camera's strobe.
 *
 * TIM5 counts the us, 32 bits, from the clock of the PWM and the tick. Its channel 2 captures the rising edges on PC12;
 * pulses below 1.5 us are dropped by the input filter. DMA2 writes each capture into a ring, so no edge needs the
 * processor. */
#ifndef TRACKSERVO_STM32G4_STROBE_H
#define TRACKSERVO_STM32G4_STROBE_H

#include <stdint.h>

#include "hal.h"
#include "registers/timer.h"

enum { STROBE_RING = 2 * HAL_STROBES };

typedef struct {
  volatile uint32_t ring[STROBE_RING]; /* written by DMA */
  uint32_t taken;                      /* the next place of the ring to read */
} strobe_line;

/* Starts the clock at 0. */
void strobe_start(strobe_line *line);

static inline uint32_t strobe_clock_us(void) { return TIM5->cnt; }

/* Takes the edges since the last call. */
void strobe_take(strobe_line *line, hal_strobes *strobes);

#endif
