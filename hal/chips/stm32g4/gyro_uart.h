/* SPDX-License-Identifier: Apache-2.0 */
/* The gyros: a USART for each at 921600 baud, received by circular DMA, read in the tick. */
#ifndef TRACKSERVO_STM32G4_GYRO_UART_H
#define TRACKSERVO_STM32G4_GYRO_UART_H

#include <stdbool.h>
#include <stdint.h>

#include "sensors/gyro_frame.h"

/* Three frames: the tick may come late by two. Maximum age of a frame in ticks: gyro and board have clocks of their
 * own, so sometimes a tick has no frame and the next has two. */
enum { GYRO_RING_BYTES = 128, GYRO_MAX_AGE_TICKS = 1 };

typedef struct {
  volatile uint8_t ring[GYRO_RING_BYTES]; /* written by DMA */
  uint32_t taken;                         /* index of the next byte to take */
  gyro_frame_reader reader;
  gyro_frame last;
  uint32_t frames;    /* good ones so far */
  bool fresh;         /* one of them since the last call of gyro_take */
  uint32_t age_ticks; /* of the last good one */
} gyro_line;

/* Starts the ports of all axes; `lines` has one for each. */
void gyro_start(gyro_line lines[]);

/* Reads the received bytes, at any time. */
void gyro_read(gyro_line *line, int axis);

/* Reads the received bytes and takes the rate. Call once per tick. Returns true when `rate_rad_s` is from a recent and
 * valid frame. */
bool gyro_take(gyro_line *line, int axis, float *rate_rad_s);

#endif
