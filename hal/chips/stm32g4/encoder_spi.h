/* SPDX-License-Identifier: Apache-2.0 */
/* The BiSS-C encoders: an SPI for each clocks 64 bits at 5.3 MHz (12 us) by DMA, in each of the last PWM periods before
 * a tick; the tick takes the mean of the good readings.
 *
 * The clock idles high, and a bit is sampled at the rising edge that requests the next one (mode 3): the answer of the
 * line may come anywhere within a clock, except near its end. */
#ifndef TRACKSERVO_STM32G4_ENCODER_SPI_H
#define TRACKSERVO_STM32G4_ENCODER_SPI_H

#include <stdbool.h>
#include <stdint.h>

#include "sensors/biss.h"

enum { ENCODER_READS_PER_TICK = 4 };

typedef struct {
  uint32_t answer[ENCODER_READS_PER_TICK][BISS_BYTES / sizeof(uint32_t)]; /* bytes, written by DMA */
  int decoded;                                                            /* of these, since the last call of take */
  uint32_t good_turn32[ENCODER_READS_PER_TICK];
  int good;
  uint32_t refused; /* bad readings so far */
  bool warning;     /* of the last good one */
} encoder_readings;

/* Starts the ports of all axes; `readings` has one for each. */
void encoder_start(encoder_readings readings[]);

/* Starts reading all encoders into answer[number], 0 .. ENCODER_READS_PER_TICK - 1. The previous reading must be
 * complete. */
void encoder_begin_read(encoder_readings readings[], int number);

/* Decodes the oldest complete reading of this tick that is not decoded yet. */
void encoder_decode(encoder_readings *readings);

/* Decodes the remaining readings and returns the mean angle of the good ones since the last call; false when there was
 * none. */
bool encoder_take(encoder_readings *readings, uint32_t *angle_turn32);

#endif
