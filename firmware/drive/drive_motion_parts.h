/* SPDX-License-Identifier: Apache-2.0 */
/* What the files of the drive's motion share; other rooms use drive_motion.h.
 *
 *     drive_motion.c         which mode runs, what every mode begins and ends with, experiments
 *     drive_profile_modes.c  pp, pv, hm: the ramp of the coming tick is prepared between two ticks
 *     drive_cyclic_modes.c   csp, csv, cst: set-points of the master
 *     drive_tracking_mode.c  mode -1: the camera's target */
#ifndef TRACKSERVO_DRIVE_DRIVE_MOTION_PARTS_H
#define TRACKSERVO_DRIVE_DRIVE_MOTION_PARTS_H

#include "drive/drive_motion.h"

/* --- for every mode --- */

/* Closes another loop without a step: the ramp begins at the speed loop's set-point of the last tick. */
void motion_close_loop(drive_motion *motion, servo_mode loop, const drive_feedback *feedback);

/* Returns the position from which the next set-point continues. */
drive_angle motion_start(const drive_motion *motion, drive_angle position);

/* Moves a demand; `rest` keeps what is below its last digit. */
void motion_move_demand(drive_angle *demand, float *rest, float travel_rad);

/* Returns the set-point of now, taken before the ramp makes its tick; its acceleration is known after the tick. */
drive_setpoint motion_setpoint(const drive_motion *motion, const drive_feedback *feedback);

/* Returns the limits of pv, of the cyclic modes and of a slow-down. */
profile_limits motion_velocity_limits(const drive_bounds *bounds, const drive_limit_objects *limit);

/* Returns the rate within the limits, and whether they have changed it. */
float motion_clamped_rate(float wanted_rad_s, const profile_limits *limits, bool *limited);

/* Returns whether an axis commanded in this direction must stop now to come to rest within the travel: `ahead` is its
 * ramp in the next tick. Once stopping, it continues until the command reverses: a set-point held against the limit
 * must not make it creep. An axis that drifts out of the travel without a command is stopped as well. */
bool motion_limit_blocks(drive_motion *motion, const drive_feedback *feedback, const profile_limits *braking,
                         float demanded, const profile_ramp *ahead, float dt_s);

/* Stops the axis; the interpolations are ready to continue from there. A limit of the travel holds the position: a rate
 * of 0 refers to inertial space, so the axis would drift beyond the limit with the base. */
drive_setpoint motion_stop(drive_motion *motion, const drive_feedback *feedback, const profile_limits *limits,
                           float dt_s);

/* Stops as a fault, a command or missing set-points order: not more gently than protection allows. An acceleration
 * of the ramp in the direction of the motion that its jerk cannot end soon is dropped. */
drive_setpoint motion_ordered_stop(drive_motion *motion, const drive_feedback *feedback, const profile_limits *wanted,
                                   float dt_s);

/* Returns the rate in the direction of `wanted_rad_s`, at most as fast, from which the axis can still stop within the
 * travel: at 80 % of the deceleration, because the rate itself follows with a lag. */
float motion_stoppable_rate(const drive_motion *motion, const profile_limits *braking, drive_angle position,
                            float wanted_rad_s, float dt_s);

/* Returns the torque that does not drive the axis faster than the limit: above it the accelerating torque is reduced,
 * to zero at 110 %. */
float motion_held_below_limit(float torque_nm, float rate_rad_s, float limit_rad_s);

/* --- the modes: the set-point of one tick --- */

drive_setpoint motion_profile_position(drive_motion *motion, const drive_objects *objects,
                                       const drive_feedback *feedback, float dt_s);

/* Serves pv and hm. */
drive_setpoint motion_profile_velocity(drive_motion *motion, const drive_limit_objects *limit,
                                       const drive_feedback *feedback, float dt_s);

drive_setpoint motion_cyclic_position(drive_motion *motion, const drive_objects *objects,
                                      const drive_feedback *feedback, float dt_s);

drive_setpoint motion_cyclic_velocity(drive_motion *motion, const drive_objects *objects,
                                      const drive_feedback *feedback, float dt_s);

drive_setpoint motion_cyclic_torque(drive_motion *motion, const drive_objects *objects, const drive_feedback *feedback,
                                    float dt_s);

drive_setpoint motion_track(drive_motion *motion, const drive_objects *objects, const drive_feedback *feedback,
                            float dt_s);

#endif
