/* Both BiSS-C encoders: SPI1 and SPI3 clock 64 bits at 5.3 MHz (12 us) by DMA, in each of the last PWM periods before a
 * tick; the tick takes the mean of the readings that are good.
 *
 * Clock rests high, and a bit is taken at the rising edge that fetches the next one (mode 3): the line's answer may
 * come anywhere within a clock, except about its end. */
#ifndef TRACKSERVO_STM32G474_ENCODER_SPI_H
#define TRACKSERVO_STM32G474_ENCODER_SPI_H

#include <stdbool.h>
#include <stdint.h>

#include "sensors/biss.h"

enum { ENCODER_READS_PER_TICK = 4 };

typedef struct {
  uint32_t answer[ENCODER_READS_PER_TICK][BISS_BYTES / sizeof(uint32_t)]; /* bytes, written by DMA */
  int decoded;                                                            /* of these, since the last call of take */
  uint32_t good_turn32[ENCODER_READS_PER_TICK];
  int good;
  uint32_t refused; /* readings so far that were not good */
  bool warning;     /* of the last good one */
} encoder_readings;

void encoder_start(encoder_readings readings[2]);

/* Begins to read both encoders into answer[number], 0 .. ENCODER_READS_PER_TICK - 1. The one before must be over. */
void encoder_begin_read(encoder_readings readings[2], int number);

/* Decodes the oldest reading of this tick that is not decoded yet, and must be over. */
void encoder_decode(encoder_readings *readings);

/* Decodes what is left, and takes what was read since the last call: the mean angle of the good readings; false when
 * there was none. */
bool encoder_take(encoder_readings *readings, uint32_t *angle_turn32);

#endif
