/* SPDX-License-Identifier: Apache-2.0 */
/* Experiments on the bus: 0x2100 (pitch 0x2900) sets one up, starts it and monitors it.
 *
 * The set-up objects are plain values in the units of commissioning/stimulus.h; "start" checks them together. A start
 * is refused with 0800 0022 unless the axis is in operation, at rest, without a mode (6060 = 0), and with 0604 0043
 * when the set-up does not fit its limits. */
#ifndef TRACKSERVO_NODE_EXPERIMENT_OBJECTS_H
#define TRACKSERVO_NODE_EXPERIMENT_OBJECTS_H

#include "canopen/object_dictionary.h"
#include "commissioning/experiment.h"
#include "drive/drive_axis.h"

typedef struct {
  uint32_t count;
  float mean_nm;
  float deviation_nm;
} breakaway_objects;

typedef struct {
  uint8_t command;
  uint8_t kind;
  uint8_t state;    /* experiment_state */
  uint8_t progress; /* % */
  uint8_t started;  /* number of experiments so far, wraps */
  stimulus_setup setup;
  experiment_limits limits;
  float duration_s;               /* approximate duration of the set-up */
  breakaway_objects breakaway[2]; /* forward, backward */
  experiment running;
} experiment_objects;

extern const od_table experiment_objects_table;

/* The owner of the part is the servo_node_axis. */
extern const od_hooks experiment_objects_hooks;

/* Computes one tick of a running experiment: writes the set-point for the drive into `command`; returns false when
 * there is none. */
bool experiment_objects_step(experiment_objects *objects, const drive_axis *drive, angle_turn32 angle,
                             float joint_rate_rad_s, servo_axis_command *command, float dt_s);

#endif
