/* SPDX-License-Identifier: Apache-2.0 */
/* Position loop: from an angle error to a rate set-point.
 *
 *     rate = rate_ff + sign(e) { kp |e|                        for |e| <= a/kp^2
 *                              { sqrt(2 a (|e| - a/(2 kp^2)))  beyond,            within +-rate limit
 *
 * Near the target the loop is proportional. Far away it follows the parabola of constant deceleration `a` that ends at
 * the target. Both join with equal slope, so large steps do not overshoot. In the tick: between sense and control of
 * the speed loop. */
#ifndef TRACKSERVO_CONTROL_POSITION_LOOP_H
#define TRACKSERVO_CONTROL_POSITION_LOOP_H

#include "base/angle.h"
#include "base/status.h"

typedef struct {
  float proportional_per_s;  /* kp, 0.01 .. 1000 */
  float rate_limit_rad_s;    /* 1e-5 .. 100 */
  float deceleration_rad_s2; /* a, 1e-4 .. 1e4 */
} position_loop_params;

control_status position_loop_check(const position_loop_params *params);

/* Returns the rate set-point in rad/s, within +-rate_limit, towards the target on the shorter side. No state. */
float position_loop_rate(const position_loop_params *params, angle_turn32 target, angle_turn32 measured,
                         float feedforward_rad_s);

#endif
