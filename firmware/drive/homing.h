/* SPDX-License-Identifier: Apache-2.0 */
/* Homing, mode of operation 6: finds the turn of an axis whose encoder knows one turn only. One step per ms, outside of
 * the tick.
 *
 *     6098 = -1, -2    moves down, or up, until motion has excluded all turns but one. At an end stop it turns round.
 *     6098 = 35, 37    does not move: confirms the turn that the operator has written to 607C
 *
 * Standard: CiA 402-2 / IEC 61800-7-201 clause 7.5: controlword bit 4 (start), statusword bits 10 (at rest), 12 (homing
 * attained) and 13 (homing error). Methods -1 and -2 are of this manufacturer. An end stop never decides which turn it
 * is, because a jam looks the same: it only ends the first path. Between two end stops the second path excludes the
 * other turn without a contact; a second contact is an error. The angle is always the encoder's, so no position but
 * the turn is changed. */
#ifndef TRACKSERVO_DRIVE_HOMING_H
#define TRACKSERVO_DRIVE_HOMING_H

#include <stdbool.h>
#include <stdint.h>

#include "drive/drive_objects.h"

/* 6098. */
enum { HOMING_NONE = 0, HOMING_DOWN_FIRST = -1, HOMING_UP_FIRST = -2, HOMING_HERE_OLD = 35, HOMING_HERE = 37 };

typedef enum {
  HOMING_NOT_STARTED = 0, /* or interrupted */
  HOMING_CONFIRMING,      /* the caller takes the turn of 607C */
  HOMING_FIRST_PATH,
  HOMING_SECOND_PATH, /* in the other direction, after a contact */
  HOMING_ATTAINED,
  HOMING_FAILED
} homing_phase;

typedef struct {
  bool runs;           /* in operation, not halted, whatever the mode */
  bool in_mode;        /* of homing */
  bool start;          /* bit 4 of the controlword */
  bool position_known; /* the turn is certain */
  bool turn_seen;      /* 607C has been written, and its turn not been confirmed yet */
  bool torque_limited;
  float rate_rad_s;
  float reference_rad_s; /* set-point of the rate */
  float contact_s;       /* so long at the torque limit without motion is a contact */
} homing_inputs;

typedef struct {
  homing_phase phase;
  float direction;    /* of the present path, -1 or 1; 0: stands */
  float target_rad_s; /* set-point for the ramp */
  float blocked_s;
  bool start_before; /* bit 4 in the last step */
  bool ran_before;   /* enabling the axis starts nothing */
} drive_homing;

bool homing_method_supported(int8_t method);

/* Commands and speeds are taken from `objects`. Leaving operation or the mode, and bit 4 = 0, interrupt it. */
void homing_step(drive_homing *state, const drive_homing_objects *objects, const homing_inputs *in, float dt_s);

/* Returns whether it has ended, or has not begun. */
static inline bool homing_is_idle(const drive_homing *state) {
  return state->phase == HOMING_NOT_STARTED || state->phase >= HOMING_ATTAINED;
}

/* Monitors bit 4 only. Call it in another mode instead of a step, while homing is idle. */
static inline void homing_pass(drive_homing *state, bool runs, bool start) {
  state->start_before = start;
  state->ran_before = runs;
}

#endif
