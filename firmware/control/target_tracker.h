/* SPDX-License-Identifier: Apache-2.0 */
/* Tracking loop of one axis: from the camera's pixel error (50 Hz, a frame old) to a rate set-point at 1 kHz.
 *
 * TRACKER_PI is the paper's loop (section IV.C, about 2 Hz): a PI on the error as it arrives, held between frames.
 *
 * TRACKER_PREDICTIVE adds what the paper's loop lacks. The rates of the last 128 ms give the rotation of the line of
 * sight since the frame was exposed, which removes the delay from the measurement. An alpha-beta-gamma filter (Kalata,
 * critically damped) estimates the target's rate and acceleration for feedforward. The loop on the estimated error
 * closes at 1 kHz. So the camera's delay is in the estimator only, not in the loop.
 *
 * All states are differences of angles, a few mrad, so single precision resolves far below a microradian. When frames
 * stop, the tracker coasts at the estimated rate for `coast_s`, then commands rate 0. */
#ifndef TRACKSERVO_CONTROL_TARGET_TRACKER_H
#define TRACKSERVO_CONTROL_TARGET_TRACKER_H

#include <stdbool.h>

#include "base/status.h"
#include "control/speed_loop.h"

#define TARGET_TRACKER_HISTORY 128    /* ticks, a power of two */
#define TARGET_TRACKER_BLOCK 16       /* ticks in one sum */
#define TARGET_TRACKER_STALE_TICKS 60 /* three frames at 50 Hz; after that TRACKER_PI ignores the last error */

typedef enum { TRACKER_PI = 0, TRACKER_PREDICTIVE } tracker_kind;

typedef struct {
  tracker_kind kind;
  float proportional_per_s; /* kp, 0 .. 100 */
  float integral_per_s2;    /* ki of TRACKER_PI, 0 .. 1000 */
  float estimator_rad_s;    /* bandwidth of the alpha-beta-gamma filter, 0.1 .. 50 */
  float rate_limit_rad_s;   /* 1e-5 .. 100 */
  float coast_s;            /* 0 .. 10 */
} target_tracker_params;

typedef struct {
  float integral_rad_s;
  float error_rad;         /* target - line of sight, now */
  float untaken_rad;       /* what the last frame said beyond it: the error as seen is the sum */
  float target_rate_rad_s; /* inertial */
  float target_acceleration_rad_s2;
  float los_sum_rad_s[TARGET_TRACKER_HISTORY]; /* ring, one entry per tick: sum of the rates since the start of its
                                                    block */
  unsigned newest;
  int ticks_since_frame;
  bool locked; /* a frame arrived within coast_s */
} target_tracker_state;

/* Alpha, beta and gamma of a frame. */
typedef struct {
  int ticks; /* since the frame before; 0: not prepared */
  float alpha;
  float beta;
  float gamma;
  float interval_s;
} target_tracker_gains;

typedef struct {
  bool fresh;      /* true in the tick in which a result arrives */
  bool valid;      /* the target was found */
  int age_ticks;   /* from exposure to now, 0 .. 127 */
  float error_rad; /* target - line of sight at exposure, positive when the target is ahead */
} camera_frame;

control_status target_tracker_check(const target_tracker_params *params);
void target_tracker_reset(target_tracker_state *state);

/* Returns how far the line of sight has turned during the last `age_ticks` ticks (0 .. TARGET_TRACKER_HISTORY - 1),
 * rad. */
float target_tracker_los_motion_rad(const target_tracker_state *state, int age_ticks, float dt_s);

/* Returns the gains of a frame `ticks` after the one before, at least 1. */
target_tracker_gains target_tracker_gains_after(int ticks, float estimator_rad_s, float dt_s);

/* Returns what the frame of this tick said beyond the estimate before it, rad, and takes it back, as if it had not
 * come. Call in the ms in which it came, after the tick; `gains` and `age_ticks` are those by which it counted. A frame
 * that counted almost in full, after a long time, has no residual: 0. */
float target_tracker_residual_rad(const target_tracker_state *state, const target_tracker_gains *gains);
void target_tracker_take_back(target_tracker_state *state, const target_tracker_gains *gains, int age_ticks,
                              float dt_s);

/* Returns the gains of a frame in the next tick. Call between two ticks. */
target_tracker_gains target_tracker_prepare_gains(const target_tracker_state *state,
                                                  const target_tracker_params *params, float dt_s);

/* Computes one tick of two components that share their frames, as TRACKER_PREDICTIVE; the rate that follows from them
 * is the caller's. Of `frame`, `error_rad` is left out; both errors count, or none. Gains that were not prepared for
 * this tick are computed. */
void target_tracker_step_components(target_tracker_state components[2], const target_tracker_params *params,
                                    const target_tracker_gains *prepared, const camera_frame *frame,
                                    const float error_rad[2], const float los_rate_rad_s[2], float dt_s);

/* Changes the acceleration by the jerk of a straight path. Call between two of these ticks, while the target is
 * known. */
void target_tracker_follow_straight_path(target_tracker_state components[2], float dt_s);

/* Returns the error (rad) now by the last frame alone, whose exposure was `age_ticks` old: of a target that has moved
 * at `rate_rad_s` since. */
float target_tracker_seen_rad(const target_tracker_state *state, int age_ticks, float rate_rad_s, float dt_s);

/* Takes a target that another source than a frame has given. Call between two ticks. */
void target_tracker_assume(target_tracker_state *state, float error_rad, float rate_rad_s, float acceleration_rad_s2);

/* Remembers the motion of the line of sight and forgets the target, in a tick in which another estimate is in use. */
void target_tracker_remember(target_tracker_state *state, float los_rate_rad_s);

/* Computes one tick. `los_rate_rad_s` is the measured inertial rate of the line of sight. A frame with an age outside
 * its range, or an error that is not finite or beyond half a turn, counts as not valid. */
speed_reference target_tracker_step(target_tracker_state *state, const target_tracker_params *params,
                                    const camera_frame *frame, float los_rate_rad_s, float dt_s);

#endif
