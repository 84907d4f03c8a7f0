/* SPDX-License-Identifier: Apache-2.0 */
/* One axis as a CiA 402 drive, in two halves of a ms.
 *
 *     before servo_axis_tick    inputs -> power state -> mode of operation -> servo_axis_command
 *     after it                  actual values -> following error, windows -> statusword; the ramp of the next tick
 *
 * Standard: CiA 402-2 / IEC 61800-7-201. The node writes commands and parameters into `drive_objects` and the step
 * reads them. The results are the values marked ro there. The drive adds two faults to those that it receives: samples
 * that the servo axis refused, and a following error (6065, or a quarter turn, beyond which the position loop could
 * choose the wrong direction). The reaction to each fault is in protection/fault_table.h. */
#ifndef TRACKSERVO_DRIVE_DRIVE_AXIS_H
#define TRACKSERVO_DRIVE_DRIVE_AXIS_H

#include <stdbool.h>
#include <stdint.h>

#include "drive/drive_motion.h"
#include "drive/drive_objects.h"
#include "drive/drive_state.h"
#include "drive/drive_units.h"
#include "drive/dwell_timer.h"
#include "drive/holding_brake.h"
#include "drive/homing.h"
#include "protection/fault_table.h"
#include "servo/servo_axis.h"

/* CiA 402 has no state for this; bits 10 and 12 of the statusword show less. */
typedef enum {
  DRIVE_NOT_TRACKING = 0, /* another mode, or not in operation */
  DRIVE_SEARCHING = 1,    /* no target since tracking began; the axis stands */
  DRIVE_ACQUIRING = 2,    /* a target is followed, not within 6067 for 6068 yet, or outside for 6068 */
  DRIVE_ON_TARGET = 3,
  DRIVE_COASTING = 4,   /* no frame with a target for DRIVE_COASTS_AFTER ticks; the axis goes on as estimated */
  DRIVE_TARGET_LOST = 5 /* for longer than 2011:5; the axis stands */
} drive_tracking;

enum { DRIVE_COASTS_AFTER = 120 }; /* a camera of 10 Hz does not coast between its frames */

typedef struct {
  angle_turn32 joint_angle;
  float rate_rad_s;       /* the rate that the speed loop controls: signals.rates.rate_rad_s */
  float reference_rad_s;  /* its set-point in the last tick: signals.reference.rate_rad_s */
  float torque_nm;        /* torque that the motor can give */
  float torque_demand_nm; /* torque command of the last tick */
  bool torque_limited;
  bool implausible;           /* the servo axis refused the last samples */
  const servo_target *target; /* of the camera; NULL: none */
  bool ready;                 /* self-test done */
  bool may_enable;            /* protection knows the end of the travel */
  bool position_known;        /* protection knows the turn */
  bool turn_seen;             /* the operator has written where the axis is, see homing.h */
  float contact_s;            /* the same */
  bool turns;                 /* protection: the axis has power, or turns since it had */
  bool at_rest;               /* protection: the protective stop has ended */
  float protective_nm;        /* torque of the protective stop in this tick */
  bool voltage_present;       /* the bus voltage is high enough for the motor */
  bool warning;
  bool remote;                        /* the controlword is executed: the node is not stopped */
  bool setpoint_arrived;              /* 607A, 60FF or 6071 was written since the last tick, also with the same value */
  holding_brake_times brake;          /* of the axis' holding brake */
  bool brake_contact_open;            /* its contact reports that it is released */
  const servo_axis_command *stimulus; /* of an experiment, used in operation with 6060 = 0; or NULL */
  fault_set faults;                   /* as seen outside the drive */
} drive_axis_inputs;

typedef struct {
  drive_state state;
  drive_motion motion;
  drive_angle position;
  drive_angle trusted_position; /* the last one at which nothing contradicted the encoder; its owner keeps it */
  uint16_t controlword;         /* of the last step */
  dwell_timer following_error;
  dwell_timer position_reached;
  dwell_timer velocity_reached;
  dwell_timer target_window; /* of tracking: entered, or left */
  drive_tracking tracking;   /* how far tracking has got */
  drive_homing homing;
  dwell_timer moving;
  dwell_timer ramp_ended;
  holding_brake brake;     /* `coil_on` is its output */
  bool following_failed;   /* reported in the last tick */
  drive_setpoint setpoint; /* of the last step */
  fault_set faults;        /* all of the last step, also those that came while the axis was in another */
  fault_id fault;          /* of 603F; FAULT_NONE when there was none since the last reset */
} drive_axis;

/* Returns whether an experiment may give the set-point: in operation, not halted, no mode of operation selected,
 * holding brake released, and not stopped at a position limit. */
bool drive_axis_obeys_stimulus(const drive_axis *axis);

/* Returns whether the axis is commanded to move: in operation, with a ramp that is not at rest or an experiment.
 * `inputs`: of the last step. */
bool drive_axis_turns(const drive_axis *axis, const drive_axis_inputs *inputs);

/* Resets the drive: not ready to switch on, axis off, position within half a turn of the encoder's zero. */
void drive_axis_reset(drive_axis *axis, angle_turn32 joint_angle);

/* Fills the inputs that the servo axis knows; leaves the others unchanged. */
void drive_axis_sense(drive_axis_inputs *inputs, const servo_axis *servo, const servo_axis_params *params,
                      const servo_axis_samples *samples);

/* Resets as drive_axis_reset, but keeps the turns counted so far. */
void drive_axis_restart(drive_axis *axis, angle_turn32 joint_angle);

/* Shifts the position, and everything that refers to it, by whole turns. Call when the turn counted so far was wrong.
 * Drops a target of pp, because its reference was wrong. */
void drive_axis_shift(drive_axis *axis, int turns);

/* Returns the command for the axis in this tick; the drive owns it. A stop is complete when its ramp has ended and the
 * axis turns no faster than 606F, or after another 200 ms: waiting longer would not stop an axis that still turns.
 * Inputs that are implausible or not finite cause fault 7300, which removes the torque. */
const servo_axis_command *drive_axis_step(drive_axis *axis, const drive_objects *objects,
                                          const drive_axis_inputs *inputs, float dt_s);

/* Writes the results that the bus can read; may run after the set-points of the tick are handed over. A following error
 * found here is a fault of the next step. */
void drive_axis_report(drive_axis *axis, drive_objects *objects, const drive_axis_inputs *inputs, float dt_s);

/* Prepares the ramp of the next tick. Call it last, before the next step. A travel that becomes limited refers to the
 * position that the bus has shown: whole ranges (607B) counted before are dropped, and with them a target of pp. */
void drive_axis_prepare(drive_axis *axis, const drive_objects *objects, const drive_machine *machine, float dt_s);

#endif
