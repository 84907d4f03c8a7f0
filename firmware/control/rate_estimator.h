/* SPDX-License-Identifier: Apache-2.0 */
/* Joint rate from an absolute encoder: the least-squares slope through the last N angles.
 *
 *     rate = sum_i w_i (angle_i - angle_newest) / dt,   w_i the end-point slope weights of N equidistant samples
 *
 * A finite window has a known delay of (N-1)/2 ticks and no transient of its own; quantisation noise falls with
 * N^1.5. N = 2 is the plain difference and suits encoders of 24 bits or more.
 *
 * A longer window does not help a coarse encoder: its delay takes phase margin from a fast loop, above all from one
 * with a disturbance observer, and the loop oscillates. With an encoder of 22 bits or less, close the loop on the gyro
 * (RATE_FROM_GYRO). Without a gyro, lower the bandwidths when you lengthen the window. The simulator refuses a plant
 * file whose window is too long for its bandwidths, and names a bandwidth that would work. */
#ifndef TRACKSERVO_CONTROL_RATE_ESTIMATOR_H
#define TRACKSERVO_CONTROL_RATE_ESTIMATOR_H

#include "base/angle.h"
#include "base/status.h"

#define RATE_ESTIMATOR_MAX_WINDOW 16 /* a power of two */

typedef struct {
  int window_ticks; /* N, 2 .. 16 */
} rate_estimator_params;

typedef struct {
  angle_turn32 history[RATE_ESTIMATOR_MAX_WINDOW]; /* ring */
  unsigned newest;
} rate_estimator_state;

control_status rate_estimator_check(const rate_estimator_params *params);

/* Starts at rest at `angle`. */
void rate_estimator_reset(rate_estimator_state *state, angle_turn32 angle);

/* Computes one tick; returns the joint rate in rad/s. Correct for less than half a turn within the window. */
float rate_estimator_step(rate_estimator_state *state, const rate_estimator_params *params, angle_turn32 angle,
                          float dt_s);

#endif
