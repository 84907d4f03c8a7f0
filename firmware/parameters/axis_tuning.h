/* SPDX-License-Identifier: Apache-2.0 */
/* Gains are set as a whole: staged by writes, checked together, applied between two ticks, and reversible.
 *
 * The object dictionary writes into `staged` only. `apply` builds the staged set. Either the whole set takes effect
 * from the next tick on (bumpless, also while the axis turns), or nothing changes and the reason can be read. `revert`
 * discards the staged values, `undo` restores the set before the last apply. Object 0x2070 provides this on the bus. */
#ifndef TRACKSERVO_PARAMETERS_AXIS_TUNING_H
#define TRACKSERVO_PARAMETERS_AXIS_TUNING_H

#include <stdbool.h>

#include "control/loop_stability.h"
#include "parameters/axis_parameters.h"

enum { AXIS_TUNING_STAGED = 1, AXIS_TUNING_DIRTY = 2 };

/* Of quiet running until a set is proven: ten periods of the slowest oscillation that is detected. */
enum { AXIS_TUNING_PROVEN_TICKS = 10000 };

typedef struct {
  axis_parameters staged;
  axis_parameters active;
  axis_parameters previous; /* in effect before the last apply */
  axis_parameters
      proven; /* the last set that ran long enough without oscillation; before the first: that of the start */
  bool proven_is_active;
  bool can_take_back;   /* there is a proven set other than the active one, for the same motor and plant */
  uint32_t quiet_ticks; /* with the active set, a loop closed and no oscillation */
  uint32_t active_crc;
  uint32_t stored_crc;       /* of the stored values; maintained by the owner of the store */
  uint32_t last_result;      /* control_status of the last apply */
  parameter_refusal refusal; /* of the last apply: the value that was wrong, in azimuth's indices */
  uint32_t flags;            /* AXIS_TUNING_* bits, updated by axis_tuning_refresh */
  bool overridden;           /* the active set was applied without the check of its stability */
  bool gains_follow; /* set once by the owner: the axis' gains follow its inertia (2056:1 to 2056:2), the azimuth's */
  bool judging;
  axis_parameters judged_set; /* the staged set when that began */
  loop_stability judgement;
  loop_stability_input judged;
  uint8_t command;  /* 0x2070:1 as last written */
  uint32_t changes; /* of the active set, on purpose: counted for guarded_sets.h */
} axis_tuning;

/* Starts with one set as staged, active and previous; refuses a set that does not build and then changes nothing. */
control_status axis_tuning_start(axis_tuning *tuning, const axis_parameters *parameters, servo_axis_params *in_force);

/* Frequencies of one slice: 0.4 ms on the board. */
enum { AXIS_TUNING_SLICE = 12 };

/* Computes one slice of the check of the staged set: whether it is stable on the plant that it names (0x2056), and
 * whether its feedforwards fit this plant and the motor (feedforward_check.h). Call it once per ms until it no longer
 * returns LOOP_RUNNING; it starts again when the staged set has changed. After LOOP_REFUSED `refusal` names the
 * feedforward that is too large, its range and the value that sets its limit. For loops that are not stable it names
 * the value that differs most from the active set, with the active value as both limits and no bound. A set that cannot
 * be built counts as stable: axis_tuning_apply reports what is wrong with it. */
loop_verdict axis_tuning_judge(axis_tuning *tuning);

/* Makes the staged set active, also on a running axis. Call it between ticks. */
control_status axis_tuning_apply(axis_tuning *tuning, servo_axis *axis, servo_axis_params *in_force, float tick_s);

/* Makes the active set the staged one: discards what is staged. */
void axis_tuning_revert(axis_tuning *tuning);

/* Makes the set before the last apply staged and active again. A second call is a redo. */
control_status axis_tuning_undo(axis_tuning *tuning, servo_axis *axis, servo_axis_params *in_force, float tick_s);

/* Makes the set before the last apply staged, as the first half of axis_tuning_undo. */
void axis_tuning_stage_previous(axis_tuning *tuning);

/* Counts a ms of the active set. `closed`: a loop is closed and does not oscillate. After AXIS_TUNING_PROVEN_TICKS such
 * calls the active set is proven. Call it every ms. */
void axis_tuning_ran(axis_tuning *tuning, bool closed);

/* Returns whether there is a proven set other than the active one, for the same motor and plant: these are guarded, and
 * never come back without the lock. */
static inline bool axis_tuning_can_take_back(const axis_tuning *tuning) { return tuning->can_take_back; }

/* Restores the proven set and closes the loop with `holding_nm` as initial torque. Call when the active set makes the
 * axis oscillate. The staged set stays. */
void axis_tuning_take_back(axis_tuning *tuning, servo_axis *axis, servo_axis_params *in_force, float holding_nm,
                           float tick_s);

/* Updates `flags`: whether staged differs from active, and active from the stored values. */
void axis_tuning_refresh(axis_tuning *tuning);

#endif
