/* SPDX-License-Identifier: Apache-2.0 */
/* Each joint follows the target by itself, with the tracking loop of one axis (control/target_tracker.h): for an axis
 * that tracks alone, and for the paper's loop. servo/pointing.h is the way of both axes together.
 *
 * Use: in each tick, between servo_board_sample and servo_board_control, joint_tracking_step or
 * joint_tracking_remember. */
#ifndef TRACKSERVO_SERVO_JOINT_TRACKING_H
#define TRACKSERVO_SERVO_JOINT_TRACKING_H

#include "control/line_of_sight.h"
#include "servo/servo_app.h"
#include "servo/servo_target.h"

#define JOINT_STEADY_RAD_S 0.02f
enum { JOINT_STEADY_TICKS = 600 }; /* three time constants of the estimator delivered with 2011:3 */

/* Since when the joint has turned at one rate. While the rate changes, an age of the frames that is not exact looks
 * like a motion of the target. */
typedef struct {
  float rate_rad_s; /* at which it began; then within JOINT_STEADY_RAD_S of it */
  uint16_t ticks;   /* up to JOINT_STEADY_TICKS */
} joint_steadiness;

typedef struct {
  target_tracker_state axis[SERVO_AXES];
  joint_steadiness steady[SERVO_AXES];
  bool tracks[SERVO_AXES]; /* the axis is in mode -1; set it before the tick */
} joint_tracking;

/* A result of the camera. */
typedef struct {
  bool fresh;             /* true in the tick in which it arrives */
  bool valid;             /* the target was found */
  int age_ticks;          /* from exposure to now, see camera_frame */
  joint_vector error_rad; /* how far each joint must turn, as of the exposure */
} joint_frame;

/* Forgets the target and the motion of the joints. */
void joint_tracking_reset(joint_tracking *self);

/* Forgets the target. */
void joint_tracking_lose(joint_tracking *self);

/* Computes one tick, by the loops of the app's parameters and the rates of its last tick. In every mode, so that motion
 * and target are known when an axis begins to track. */
void joint_tracking_step(joint_tracking *self, const servo_app *app, const joint_frame *frame,
                         servo_target targets[SERVO_AXES]);

/* Remembers the motion and forgets the target, in a tick in which both axes track together. */
void joint_tracking_remember(joint_tracking *self, const servo_app *app);

#endif
