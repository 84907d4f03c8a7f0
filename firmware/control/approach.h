/* SPDX-License-Identifier: Apache-2.0 */
/* Rate towards a target for a joint that can brake only so hard: proportional to the error close to it, further away
 * the rate from which the joint still stops in time. Without it, a proportional law overshoots as soon as it asks for
 * more deceleration than the joint may have: from kp * error > braking / kp on.
 *
 *     kp e                                        for e <= b / kp^2
 *     sqrt(2 b (e - b / (2 kp^2)))                beyond; the same value and slope there */
#ifndef TRACKSERVO_CONTROL_APPROACH_H
#define TRACKSERVO_CONTROL_APPROACH_H

#include <math.h>

#include "base/scalar.h"

/* Returns braking available for an error whose target itself accelerates: at least a tenth of the limit. */
static inline float approach_braking(float limit_rad_s2, float error_rad, float target_rad_s2) {
  const float towards = error_rad < 0.0f ? -target_rad_s2 : target_rad_s2;
  return scalar_clamp(limit_rad_s2 + towards, 0.1f * limit_rad_s2, limit_rad_s2);
}

/* Returns the rate towards a target; `braking_rad_s2` 0: its deceleration is not limited. */
static inline float approach_rate(float proportional_per_s, float braking_rad_s2, float error_rad) {
  const float size_rad = scalar_abs(error_rad);
  const float square = proportional_per_s * proportional_per_s;
  if (braking_rad_s2 <= 0.0f || size_rad * square <= braking_rad_s2) {
    return proportional_per_s * error_rad;
  }
  const float rate_rad_s = sqrtf(braking_rad_s2 * (2.0f * size_rad - braking_rad_s2 / square));
  return error_rad < 0.0f ? -rate_rad_s : rate_rad_s;
}

#endif
