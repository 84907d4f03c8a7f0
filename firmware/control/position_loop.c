/* SPDX-License-Identifier: Apache-2.0 */
#include "control/position_loop.h"

#include <math.h>

#include "base/scalar.h"

control_status position_loop_check(const position_loop_params *params) {
  const scalar_range ranges[] = {
      {params->proportional_per_s, 0.01f, 1e3f},
      {params->rate_limit_rad_s, 1e-5f, 1e2f},
      {params->deceleration_rad_s2, 1e-4f, 1e4f},
  };
  return scalar_check_ranges(ranges, 3);
}

/* Rate at `distance_rad` >= 0 from which the axis can stop at the target. */
static float approach_rad_s(const position_loop_params *params, float distance_rad) {
  const float kp = params->proportional_per_s;
  const float a = params->deceleration_rad_s2;
  const float join_rad = a / (kp * kp); /* line and parabola meet here with equal value and slope */
  if (distance_rad <= join_rad) {
    return kp * distance_rad;
  }
  return sqrtf(2.0f * a * (distance_rad - 0.5f * join_rad));
}

float position_loop_rate(const position_loop_params *params, angle_turn32 target, angle_turn32 measured,
                         float feedforward_rad_s) {
  const float error_rad = angle_difference_rad(target, measured);
  const float approach = approach_rad_s(params, scalar_abs(error_rad));
  const float rate_rad_s = feedforward_rad_s + (error_rad < 0.0f ? -approach : approach);
  return scalar_clamp(rate_rad_s, -params->rate_limit_rad_s, params->rate_limit_rad_s);
}
