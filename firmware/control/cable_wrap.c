/* SPDX-License-Identifier: Apache-2.0 */
#include "control/cable_wrap.h"

#include <math.h>
#include <stdbool.h>

#include "base/scalar.h"

static bool is_limited(const joint_travel *travel) { return travel->lowest_rad < travel->highest_rad; }

float joint_travel_clamp(const joint_travel *travel, float angle_rad) {
  return is_limited(travel) ? scalar_clamp(angle_rad, travel->lowest_rad, travel->highest_rad) : angle_rad;
}

float cable_wrap_lasts_s(const joint_travel *travel, float angle_rad, float rate_rad_s) {
  if (joint_travel_clamp(travel, angle_rad) != angle_rad) {
    return 0.0f;
  }
  if (!is_limited(travel) || rate_rad_s == 0.0f) {
    return INFINITY;
  }
  const float end_rad = rate_rad_s < 0.0f ? travel->lowest_rad : travel->highest_rad;
  return (end_rad - angle_rad) / rate_rad_s;
}

int cable_wrap_turns(const joint_travel *travel, float angle_rad, float rate_rad_s) {
  int best = 0;
  float longest_s = cable_wrap_lasts_s(travel, angle_rad, rate_rad_s);
  for (int turns = -1; turns <= 1; turns += 2) {
    const float lasts_s = cable_wrap_lasts_s(travel, angle_rad + (float)turns * 2.0f * SCALAR_PI, rate_rad_s);
    if (lasts_s > longest_s) {
      longest_s = lasts_s;
      best = turns;
    }
  }
  return best;
}
