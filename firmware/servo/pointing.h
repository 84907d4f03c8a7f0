/* SPDX-License-Identifier: Apache-2.0 */
/* Both axes together hold a target in the camera's image: from a frame to the set-points of both speed loops, once per
 * tick.
 *
 *     frame -> pointing_tracker_step -> rates and accelerations -> pointing_torques_nm -> references and torques
 *
 * The result is a set-point for SERVO_SPEED, within the limits of the drive.
 *
 *     rate                  the target's rate, and `proportional_per_s` times the error of the joint
 *     acceleration          the target's; the speed loop multiplies it with its own inertia, which follows the pitch
 *     torque_nm             what the speed loop lacks: the centrifugal torque on the pitch, the Coriolis torque on the
 *                           azimuth, and the acceleration of an inertia that it does not feed forward
 *
 * The torque is added behind the speed loop, so its disturbance observer does not see it (servo_axis.h).
 *
 * Use: in each tick, between servo_board_sample and servo_board_control:
 *
 *     const pointing_motion motion = pointing_motion_of(&board->app, &board->samples);
 *     const pointing_output out = pointing_step(&pointing, &frame, &motion, SERVO_TICK_S);
 *
 * Step it in every tick from the reset on: a frame that was exposed before the reset counts as not valid. */
#ifndef TRACKSERVO_SERVO_POINTING_H
#define TRACKSERVO_SERVO_POINTING_H

#include "control/pointing_tracker.h"
#include "servo/servo_app.h"

typedef struct {
  pointing_tracker_params tracker;
  pointing_inertia inertia;       /* of the machine: 1e-9 .. 1e5, at every pitch; swing -1e5 .. 1e5 */
  joint_vector fed_forward_kg_m2; /* acceleration_inertia_kg_m2 of both speed loops, 0 .. 1e5; azimuth: at pitch 0 */
} pointing_params;

typedef struct {
  pointing_params params;
  float largest_kg_m2;     /* of the azimuth, which the speed loop follows from: see servo_azimuth_pose */
  float fed_forward_share; /* of its inertia that the speed loop feeds forward */
  pointing_tracker_state tracker;
  int known_ticks; /* since the reset, up to TARGET_TRACKER_HISTORY */
} pointing;

/* Of the line of sight. */
typedef struct {
  rotation pitch;              /* of its joint angle, now */
  joint_vector inertial_rad_s; /* measured rates about the azimuth's and the pitch's axis */
} pointing_motion;

typedef struct {
  bool locked;                      /* a frame arrived within coast_s: otherwise the references and torques are 0 */
  bool limited;                     /* by the rate limit of an axis */
  image_vector error_rad;           /* estimated, now: cross-elevation and elevation */
  joint_vector error_of_joints_rad; /* how far each joint must turn */
  joint_vector seen_rad;            /* the same by the last frame, without its filter */
  speed_reference reference[SERVO_AXES];
  float torque_nm[SERVO_AXES];
} pointing_output;

/* Returns CONTROL_OK, or why these parameters are refused. */
control_status pointing_check(const pointing_params *params);

/* Takes the parameters after checking them, and forgets the target; on an error nothing changes. */
control_status pointing_configure(pointing *self, const pointing_params *params);

/* Forgets the target. */
void pointing_reset(pointing *self);

/* Forgets the target, and makes frames invalid that were exposed before now or in the next tick. Call between two
 * ticks. */
void pointing_look_away(pointing *self);

/* Returns the motion from the pitch's angle in this tick and both axes' rates of the last tick. A sum of rates since an
 * exposure then begins and ends a tick earlier: half a tick before the motion, as it would be half a tick behind it
 * with the rates of this tick. Counting the frames a tick younger moves no error of test_tracking_over_bus by more than
 * 0.03 urad. */
pointing_motion pointing_motion_of(const servo_app *app, const servo_samples *samples);

/* Computes one tick. See pointing_tracker_step for frames out of range. Not inlined, like drive_motion_step. */
pointing_output pointing_step(pointing *self, const pointing_frame *frame, const pointing_motion *motion, float tick_s)
    __attribute__((noinline));

#endif
