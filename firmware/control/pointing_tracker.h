/* SPDX-License-Identifier: Apache-2.0 */
/* Tracking with both axes: from the camera's image errors to rates and accelerations of both joints.
 *
 * Seen from a turning camera a target on a straight path seems to curve: near the zenith the image rolls faster than
 * any filter per joint can follow. So the target is estimated in a frame N that turns with the line of sight but does
 * not roll about it (parallel transport): a motion along a great circle has constant components there. N differs from
 * the image by the angle phi, the integral of the roll rate. In N each component is an alpha-beta-gamma estimator of
 * its own (target_tracker.h, TRACKER_PREDICTIVE), which also removes the age of the frames.
 *
 * Then exact geometry gives the joints (line_of_sight.h). With the target's rate w and acceleration a along the image
 * axes at the target, at azimuth psi and pitch theta:
 *
 *     psi'  = w_x / cos theta           psi''  = a_x / cos theta + 2 psi' theta' tan theta
 *     theta' = w_y                      theta'' = a_y - psi'^2 sin theta cos theta
 *
 * The command adds `proportional_per_s` times the joint errors, less where the joints could not brake in time
 * (approach.h). It is limited to the rate limits of the joints, without a limit of their acceleration. Closer to the
 * zenith than POINTING_ZENITH_COSINE the azimuth's feedforward fades: no joint could follow it there. */
#ifndef TRACKSERVO_CONTROL_POINTING_TRACKER_H
#define TRACKSERVO_CONTROL_POINTING_TRACKER_H

#include <stdbool.h>

#include "control/line_of_sight.h"
#include "control/target_tracker.h"

#define POINTING_ZENITH_COSINE 0.005f /* 0.3 degrees */

typedef struct {
  float proportional_per_s;      /* 0 .. 100 */
  float estimator_rad_s;         /* bandwidth, 0.1 .. 50 */
  float coast_s;                 /* 0 .. 10 */
  joint_vector rate_limit_rad_s; /* 1e-5 .. 100 */
  joint_vector braking_rad_s2;   /* that the joints may have; 0: not limited, 0 .. 1e4 */
} pointing_tracker_params;

typedef struct {
  target_tracker_state along[2]; /* components of N */
  angle_turn32 phi;              /* from N to the image: an image vector is turned by it to get that of N */
  angle_turn32 past_phi[TARGET_TRACKER_HISTORY];
  unsigned newest;
  target_tracker_gains gains; /* of a frame in the next tick */
  float azimuth_rad_s2;       /* of the azimuth that keeps pointing at the target, in the last tick */
  joint_vector softer_per_s;  /* of proportional_per_s, so that the joints can brake in time */
} pointing_tracker_state;

/* A result of the image processing, as camera_frame, for both image axes. */
typedef struct {
  bool fresh;
  bool valid;
  int age_ticks;      /* from exposure to now, 0 .. TARGET_TRACKER_HISTORY - 1 */
  image_vector error; /* target minus line of sight at exposure, by camera_error */
} pointing_frame;

typedef struct {
  bool locked; /* a frame arrived within coast_s: otherwise all rates are 0 */
  bool limited;
  image_vector error_rad; /* estimated, now */
  joint_vector error_of_joints_rad;
  joint_vector seen_rad;   /* the same by the last frame, without its filter */
  joint_vector rate_rad_s; /* commanded, about the azimuth's and the pitch's axis */
  joint_vector acceleration_rad_s2;
} pointing_command;

/* Returns CONTROL_OK, or why these parameters are refused. */
control_status pointing_tracker_check(const pointing_tracker_params *params);

/* Forgets the target. */
void pointing_tracker_reset(pointing_tracker_state *state);

/* Return how far the line of sight has turned during the last `age_ticks` ticks (0 .. TARGET_TRACKER_HISTORY - 1), rad,
 * and the error of a frame: both as components of N, in the tick of the last step. */
image_vector pointing_tracker_los_motion(const pointing_tracker_state *state, int age_ticks, float dt_s);
image_vector pointing_tracker_frame_error(const pointing_tracker_state *state, const pointing_frame *frame);

/* What is estimated of the target, now, along the image axes of the line of sight. */
typedef struct {
  image_vector error;
  image_vector rate_rad_s; /* inertial */
  image_vector acceleration_rad_s2;
} pointing_target;

pointing_target pointing_tracker_target(const pointing_tracker_state *state);

/* Sets what is known of the target, as if it had not been seen since its last frame, or that it is no longer known.
 * Call between two ticks. */
void pointing_tracker_assume(pointing_tracker_state *state, const pointing_target *target);
void pointing_tracker_lose(pointing_tracker_state *state);

/* Computes one tick. `los` holds the measured inertial rates of the image frame, `pitch` is of the joint angle. Frames
 * with an age or an error out of range count as not valid, as in target_tracker_step. */
pointing_command pointing_tracker_step(pointing_tracker_state *state, const pointing_tracker_params *params,
                                       const pointing_frame *frame, const line_of_sight_rates *los, rotation pitch,
                                       float dt_s);

/* Computes the braking and the frame gains of the next tick, and the jerk of a straight path. Call between two ticks.
 * `error_rad` is that of the joints in the last tick. */
void pointing_tracker_prepare(pointing_tracker_state *state, const pointing_tracker_params *params,
                              joint_vector error_rad, float dt_s);

#endif
