/* SPDX-License-Identifier: Apache-2.0 */
/* When the line of sight will be back on a target that the joints cannot follow within their limits: near the zenith
 * the azimuth would have to turn faster than it may, and at the end of its travel it turns back by one revolution.
 *
 * The target goes on along its path (target_path.h). Both joints go on by the law of pointing_tracker.h within their
 * limits of rate, acceleration and travel: one step of TARGET_RETURN_STEP_S per call, so that the work per ms is small.
 * The line of sight is back at the first step at which it misses the target by at most TARGET_RETURN_MISS_RAD and no
 * rate is limited, for TARGET_RETURN_HELD_STEPS. After TARGET_RETURN_STEPS the answer is "not within that time". Wind,
 * friction and a target that turns are not in it. */
#ifndef TRACKSERVO_CONTROL_TARGET_RETURN_H
#define TRACKSERVO_CONTROL_TARGET_RETURN_H

#include <stdbool.h>

#include "control/cable_wrap.h"
#include "control/target_path.h"

#define TARGET_RETURN_STEP_S 0.01f
#define TARGET_RETURN_MISS_RAD 1e-3f

enum { TARGET_RETURN_STEPS = 1500, TARGET_RETURN_HELD_STEPS = 20 };

typedef struct {
  float proportional_per_s;
  joint_vector rate_limit_rad_s;
  joint_vector acceleration_limit_rad_s2;
  joint_travel azimuth_travel;
} target_return_limits;

/* Of target and joints, now. */
typedef struct {
  target_path path;
  float path_s; /* since its start */
  joint_vector joint_rad;
  joint_vector joint_rad_s;
  float
      direction; /* -1 or 1: the azimuth turns only in this direction until it meets the target; 0: the shorter turn */
} target_return_start;

typedef struct {
  target_return_limits limits;
  target_return_start now;
  int steps;
  int held_steps; /* on the target until now */
  bool running;
  bool found;    /* the last prediction has an answer */
  float after_s; /* the answer: from its start on */
} target_return;

/* Returns how far the azimuth must turn for this difference of angles, in `direction` or by the shorter turn, rad. */
float target_return_error_rad(float difference_rad, float direction);

/* Returns the rate of a joint that is `error_rad` from its target: the target's rate, plus the rate towards it from
 * which the joint can still brake. */
float target_return_rate_rad_s(const joint_target *target, float error_rad, float proportional_per_s,
                               float limit_rad_s2);

/* Begins a prediction; `found` and `after_s` of the last one stay. */
void target_return_begin(target_return *self, const target_return_limits *limits, const target_return_start *start);

/* Computes one step of a running prediction. */
void target_return_step(target_return *self);

#endif
