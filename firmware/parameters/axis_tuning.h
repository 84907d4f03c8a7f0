/* Gains are set in one piece: staged by writes, checked together, put in force between two ticks, taken back at will.
 *
 * The object dictionary writes into `staged` only. `apply` builds the staged set, and either all of it is in force from
 * the next tick on (bumpless, also while the axis turns) or nothing changes and the reason can be read. `revert`
 * forgets what is staged, `undo` goes back to the set before the last apply. Object 0x2070 is this, on the bus. */
#ifndef TRACKSERVO_PARAMETERS_AXIS_TUNING_H
#define TRACKSERVO_PARAMETERS_AXIS_TUNING_H

#include "parameters/axis_parameters.h"

enum { AXIS_TUNING_STAGED = 1, AXIS_TUNING_DIRTY = 2 };

typedef struct {
  axis_parameters staged;
  axis_parameters active;
  axis_parameters previous; /* in force before the last apply */
  uint32_t active_crc;
  uint32_t stored_crc;  /* of what the store holds; kept by whoever stores */
  uint32_t last_result; /* control_status of the last apply */
  uint32_t flags;       /* AXIS_TUNING_* bits, renewed by axis_tuning_refresh */
  uint8_t command;      /* 0x2070:1 as last written */
} axis_tuning;

/* Starts with one set as staged, active and previous; refuses a set that does not build and changes nothing then. */
control_status axis_tuning_start(axis_tuning *tuning, const axis_parameters *parameters, servo_axis_params *in_force);

/* Staged becomes active, on a running axis, too. Call between ticks. */
control_status axis_tuning_apply(axis_tuning *tuning, servo_axis *axis, servo_axis_params *in_force, float tick_s);

/* Staged becomes what is active. */
void axis_tuning_revert(axis_tuning *tuning);

/* The set before the last apply becomes staged and active again; twice is a redo. */
control_status axis_tuning_undo(axis_tuning *tuning, servo_axis *axis, servo_axis_params *in_force, float tick_s);

/* Renews `flags`: staged differs from active; active differs from what is stored. */
void axis_tuning_refresh(axis_tuning *tuning);

#endif
