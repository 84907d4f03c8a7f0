/* An experiment moves one axis so that friction, inertia or the loop's response can be told from what it does.
 *
 *     stimulus (what to do next) -> limits (may it?) -> servo_axis_command, once per tick, until done or stopped
 *
 * It runs on an axis that is enabled and at rest, gives the set-point in place of a mode of operation, and hands the
 * axis back at rest. No gain is touched. The limits hold whatever the set-up says: an axis that leaves its travel or
 * its speed, or an experiment that lasts too long, ends it; the drive then stops the axis along its ramp.
 *
 * Paper: the sweep is the constant-speed run of eqs (4)-(7), torque ramps and hysteresis loops are the pre-sliding runs
 * of eqs (8)-(11) and (16). */
#ifndef TRACKSERVO_COMMISSIONING_EXPERIMENT_H
#define TRACKSERVO_COMMISSIONING_EXPERIMENT_H

#include "commissioning/stimulus.h"
#include "servo/servo_axis.h"

/* How far from its start, how fast, how strong, how long. */
typedef struct {
  float travel_rad; /* to each side, 1e-6 .. 3 */
  float rate_rad_s; /* of the joint, 1e-6 .. 100 */
  float torque_nm;  /* both directions, above 0 .. 1e4 */
  float duration_s; /* above 0 .. 3600 */
} experiment_limits;

typedef enum {
  EXPERIMENT_IDLE = 0, /* none was started */
  EXPERIMENT_RUNNING,
  EXPERIMENT_DONE,        /* to its end */
  EXPERIMENT_ABORTED,     /* by command */
  EXPERIMENT_LEFT_TRAVEL, /* by a limit ... */
  EXPERIMENT_TOO_FAST,
  EXPERIMENT_TOO_LONG,
  EXPERIMENT_DRIVE_STOPPED /* the axis was not in operation, or not without a mode, any more */
} experiment_state;

typedef struct {
  experiment_state state;
  stimulus_setup setup;
  experiment_limits limits;
  float whole_s; /* that the set-up takes, about */
  stimulus_state stimulus;
  angle_turn32 last_angle;
  int64_t travel_turn32; /* from the start, unwrapped */
  uint32_t ticks;
} experiment;

/* CONTROL_OK, or that the set-up or a limit is out of range, or that the two do not fit together: a rate, torque or
 * amplitude beyond its limit, a sweep that cannot turn round within the travel, a run that is longer than allowed. */
control_status experiment_check(const stimulus_setup *setup, const experiment_limits *limits);

/* At `angle`, at rest. On a complaint nothing is changed. */
control_status experiment_start(experiment *e, const stimulus_setup *setup, const experiment_limits *limits,
                                angle_turn32 angle);

/* Ends a running experiment; one that is over keeps its state. */
void experiment_abort(experiment *e, experiment_state reason);

/* One tick: true while `command` is to be obeyed; false once it is over, and the drive has to stop the axis. */
bool experiment_step(experiment *e, angle_turn32 angle, float joint_rate_rad_s, servo_axis_command *command,
                     float dt_s);

/* 0 .. 100: the time gone of that which the set-up takes. */
int experiment_progress_percent(const experiment *e, float dt_s);

#endif
