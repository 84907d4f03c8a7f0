/* SPDX-License-Identifier: Apache-2.0 */
/* One answer of a BiSS-C encoder, read by an SPI master that clocked a fixed number of bytes.
 *
 *     1 .. 1 | 0 .. 0 | 1 | 0 | position, 26 bits | error | warning | CRC, 6 bits | 0 ..
 *     line    acknowledge start CDS                  low active        inverted
 *
 * Source: iC-Haus, "BiSS C Protocol Description" (single cycle data). The start bit is searched, so the delay of line
 * and encoder may be any number of clocks up to BISS_MAX_DELAY_BITS. CRC: polynomial 0x43 (x^6 + x + 1) over position,
 * error and warning, first bit first, start value 0. */
#ifndef TRACKSERVO_SENSORS_BISS_H
#define TRACKSERVO_SENSORS_BISS_H

#include <stdbool.h>
#include <stdint.h>

enum {
  BISS_BYTES = 8,
  BISS_POSITION_BITS = 26,
  BISS_CHECKED_BITS = BISS_POSITION_BITS + 2,
  BISS_CRC_BITS = 6,
  BISS_MAX_DELAY_BITS = 8 * BISS_BYTES - 2 - BISS_CHECKED_BITS - BISS_CRC_BITS /* line and acknowledge together */
};

typedef enum {
  BISS_OK = 0,
  BISS_NO_ANSWER, /* no acknowledge or no start bit in time */
  BISS_BAD_CRC,
  BISS_ERROR /* the encoder reports that its position is not valid */
} biss_status;

typedef struct {
  uint32_t angle_turn32; /* the position, in 2^-32 turn */
  bool warning;          /* the position is valid, but the encoder needs service */
} biss_reading;

/* Decodes a frame. Writes `reading` only with BISS_OK. Cost: about 60 instructions. */
biss_status biss_decode(const uint8_t bytes[BISS_BYTES], biss_reading *reading);

/* Returns the CRC, not inverted, of the 28 bits that it protects. */
uint32_t biss_crc(uint32_t checked_bits);

#endif
