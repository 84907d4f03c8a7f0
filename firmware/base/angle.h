/* SPDX-License-Identifier: Apache-2.0 */
/* A joint angle as a binary fraction of a turn.
 *
 * An absolute encoder delivers up to 32 bits; a float has only 24. So the angle travels as a uint32 in units of 2^-32
 * turn (1.46 nrad), whatever the encoder's own resolution, and wraps by itself. Only differences are converted to
 * floats in rad. */
#ifndef TRACKSERVO_BASE_ANGLE_H
#define TRACKSERVO_BASE_ANGLE_H

#include <math.h>
#include <stdint.h>

typedef uint32_t angle_turn32;

#define ANGLE_RAD_PER_TURN32 (6.28318530717959f / 4294967296.0f)

/* Returns the shortest path from `from` to `to`, in [-pi, pi) rad. */
static inline float angle_difference_rad(angle_turn32 to, angle_turn32 from) {
  return (float)(int32_t)(to - from) * ANGLE_RAD_PER_TURN32;
}

/* Converts a whole number of 2^-32 turn to an integer; |whole| must be below 2^63. */
static inline int64_t angle_integer(float whole) {
  /* Up to half a turn, more than any tick moves, the FPU converts; beyond that the conversion is a library function of
   * 200 instructions. */
  return fabsf(whole) < 2147483648.0f ? (int64_t)(int32_t)whole : (int64_t)whole;
}

#endif
