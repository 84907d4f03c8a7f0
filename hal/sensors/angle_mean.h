/* SPDX-License-Identifier: Apache-2.0 */
/* Mean of a few angles in 2^-32 turn that lie within half a turn of each other, around the wrap. */
#ifndef TRACKSERVO_SENSORS_ANGLE_MEAN_H
#define TRACKSERVO_SENSORS_ANGLE_MEAN_H

#include <stdint.h>

/* Returns the mean of `count` angles, 1 .. 1000, rounded to the nearest. Uses no 64-bit division, which the core does
 * not have: whole parts and remainders are summed separately. */
static inline uint32_t angle_mean(const uint32_t *angle_turn32, int count) {
  int32_t mean = 0;
  int32_t rest = 0; /* more than -count^2, less than count^2 */
  /* Bound: readings of an encoder in a tick, at most what encoder_spi.c keeps. */
  for (int i = 1; i < count; ++i) {
    const int32_t difference = (int32_t)(angle_turn32[i] - angle_turn32[0]);
    mean += difference / count;
    rest += difference % count;
  }
  const int32_t rounded = (2 * rest + count + 2 * count * count) / (2 * count) - count;
  return angle_turn32[0] + (uint32_t)(mean + rounded);
}

#endif
