/* SPDX-License-Identifier: Apache-2.0 */
/* Scalar arithmetic that gives the same bits on every machine.
 *
 * The C library's expf, sinf and cosf differ in the last bit between host and target, so they cannot be used in a trace
 * that is compared bit by bit. (sqrtf, roundf and frexpf are exact by definition and may be used.) These are short
 * polynomials in float, built without fused multiply-add. All functions need finite arguments in the stated range. */
#ifndef TRACKSERVO_BASE_SCALAR_H
#define TRACKSERVO_BASE_SCALAR_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>

#include "base/status.h"

#define SCALAR_PI 3.14159265358979f

static inline float scalar_min(float a, float b) { return a < b ? a : b; }
static inline float scalar_max(float a, float b) { return a > b ? a : b; }
static inline float scalar_abs(float a) { return fabsf(a); }

/* Limits `value` to [low, high]; low <= high. NaN stays NaN: a limit must not turn it into full torque. */
static inline float scalar_clamp(float value, float low, float high) {
  if (value < low) {
    return low;
  }
  return value > high ? high : value;
}

/* Returns whether |value| <= bound; false for NaN. */
static inline bool scalar_within(float value, float bound) { return scalar_abs(value) <= bound; }

/* Rounds as roundf(), inline: to the nearest whole number, halves away from 0. */
static inline float scalar_round(float value) {
  const float all_are_whole = 8388608.0f; /* from 2^23 on */
  if (!(scalar_abs(value) < all_are_whole)) {
    return value; /* also NaN and infinity */
  }
  const float whole = (float)(int32_t)value;
  const float rest = value - whole; /* exact */
  return whole + (rest >= 0.5f ? 1.0f : 0.0f) - (rest <= -0.5f ? 1.0f : 0.0f);
}

/* Returns exp(-x) for x >= 0, within 1.25 units of the last place; exactly 1 at 0 and exactly 0 from 87 on. */
float scalar_exp_minus(float x);

/* Return sin and cos of an angle in [0, pi] rad, absolute error below 4e-7. For filter design, not for the tick. */
float scalar_sin(float angle_rad);
float scalar_cos(float angle_rad);

/* Returns the angle of the vector (x, y) from the x axis, in [-pi, pi] rad, within 3e-7 of itself; 0 for the vector (0,
 * 0). A small angle keeps all its digits. */
float scalar_atan2(float y, float x);

/* One entry of a parameter check: the value must be finite and within [low, high]. */
typedef struct {
  float value;
  float low;
  float high;
} scalar_range;

/* Returns the first error among `count` ranges, or CONTROL_OK. */
control_status scalar_check_ranges(const scalar_range *ranges, int count);

#endif
