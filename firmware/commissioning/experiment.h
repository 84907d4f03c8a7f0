/* SPDX-License-Identifier: Apache-2.0 */
/* An experiment moves one axis so that friction, inertia or the loop's response can be identified.
 *
 *     stimulus (what to do next) -> limits (may it?) -> servo_axis_command, once per tick, until done or stopped
 *
 * It runs on an axis that is enabled and at rest, replaces the set-point of a mode of operation, and leaves the axis at
 * rest. It does not change gains. The limits apply regardless of the set-up: an axis that leaves its travel or exceeds
 * its speed, or an experiment that lasts too long, ends the experiment. The drive then stops the axis along its ramp.
 *
 * Paper: the sweep is the constant-speed run of eqs (4)-(7), torque ramps and hysteresis loops are the pre-sliding runs
 * of eqs (8)-(11) and (16). */
#ifndef TRACKSERVO_COMMISSIONING_EXPERIMENT_H
#define TRACKSERVO_COMMISSIONING_EXPERIMENT_H

#include "commissioning/stimulus.h"
#include "servo/servo_axis.h"

/* Limits of travel from the start, rate, torque and duration. */
typedef struct {
  float travel_rad; /* to each side, 1e-6 .. 3 */
  float rate_rad_s; /* of the joint, 1e-6 .. 100 */
  float torque_nm;  /* both directions, above 0 .. 1e4 */
  float duration_s; /* above 0 .. 3600 */
} experiment_limits;

typedef enum {
  EXPERIMENT_IDLE = 0, /* none was started */
  EXPERIMENT_RUNNING,
  EXPERIMENT_DONE,        /* completed */
  EXPERIMENT_ABORTED,     /* by command */
  EXPERIMENT_LEFT_TRAVEL, /* stopped by a limit ... */
  EXPERIMENT_TOO_FAST,
  EXPERIMENT_TOO_LONG,
  EXPERIMENT_DRIVE_STOPPED /* the axis left operation, or a mode was selected */
} experiment_state;

typedef struct {
  experiment_state state;
  stimulus_setup setup;
  experiment_limits limits;
  float whole_s; /* approximate duration of the set-up */
  stimulus_state stimulus;
  angle_turn32 last_angle;
  int64_t travel_turn32; /* from the start, unwrapped */
  uint32_t ticks;
} experiment;

/* Returns CONTROL_OK, or an error: the set-up or a limit is out of range, or the two do not fit together (a rate,
 * torque or amplitude beyond its limit, a sweep that cannot turn round within the travel, a run longer than
 * allowed). */
control_status experiment_check(const stimulus_setup *setup, const experiment_limits *limits);

/* Starts at `angle`, at rest. On an error nothing is changed. */
control_status experiment_start(experiment *e, const stimulus_setup *setup, const experiment_limits *limits,
                                angle_turn32 angle);

/* Ends a running experiment; one that has ended keeps its state. */
void experiment_abort(experiment *e, experiment_state reason);

/* Computes one tick. Returns true while `command` must be followed, false once it has ended and the drive has to stop
 * the axis. */
bool experiment_step(experiment *e, angle_turn32 angle, float joint_rate_rad_s, servo_axis_command *command,
                     float dt_s);

/* Returns the elapsed share of the approximate duration, 0 .. 100 %. */
int experiment_progress_percent(const experiment *e, float dt_s);

#endif
