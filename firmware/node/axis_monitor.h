/* SPDX-License-Identifier: Apache-2.0 */
/* Protection of one axis within the node: collects the inputs of the detection and keeps the history of the fault
 * log. */
#ifndef TRACKSERVO_NODE_AXIS_MONITOR_H
#define TRACKSERVO_NODE_AXIS_MONITOR_H

#include "drive/drive_axis.h"
#include "drive/holding_brake.h"
#include "protection/axis_protection.h"
#include "protection/envelope.h"
#include "protection/fault_log.h"
#include "protection/motion_proof.h"
#include "protection/oscillation.h"
#include "protection/slow_monitors.h"
#include "protection/start_position.h"
#include "servo/servo_board.h"

/* An axis that follows the set-point of its tracking loop at once, within the same limits. */
typedef struct {
  float ahead_rad; /* of the real one, since tracking began */
  float rate_rad_s;
} ideal_tracking;

typedef struct {
  protection_limits limits; /* 0x2060, in effect */
  protection_inputs seen;   /* by the last step */
  axis_protection state;
  fault_set judged; /* by the last deferred task */
  oscillation swings;
  oscillation_inputs commanded; /* in the last tick; its motion is seen in the next */
  float torque_nm;              /* that the limits of the last tick leave */
  bool oscillates;              /* seen by the last deferred task */
  bool may_shake;               /* new gains, and fast swings have begun */
  angle_turn32 last_setpoint;   /* of the position, in the tick before */
  ideal_tracking ideal;
  fault_set found;            /* by the last step */
  angle_turn32 last_position; /* commanded, when the slow monitors judged last */
  uint8_t restrictions;       /* RESTRICTED_* bits, in effect */
  envelope_limits allowed;    /* in effect; from `limits` and the start position */
  envelope_state envelope;
  start_position start;
  start_candidates candidates;
  int8_t turn;      /* of the start position, in the drive's position */
  bool jumped;      /* since the start position was looked for; the count may be off by turns */
  uint8_t misread;  /* gyro or encoder were: so often the base's rate has yet to be renewed */
  uint8_t doubtful; /* so often the encoder must yet be right before its position is trusted */
  /* Of the deferred task alone: behind what the tick reaches with short offsets. */
  slow_monitors slow;
  bool stands; /* as the slow monitors judged last */
  motion_proof proof;
  angle_turn32 last_angle; /* the last valid one */
  uint16_t gap_ticks;      /* without an angle since then */
} axis_monitor;

/* Why an axis moves slowly or is not enabled; bits of 2061:1. */
enum {
  RESTRICTED_NO_TRAVEL = 1,        /* 2060:9 and :10 limit no travel and 2060:21 does not say why: not enabled */
  RESTRICTED_POSITION_UNKNOWN = 2, /* several turns are possible: slow; pp and csp wait */
  RESTRICTED_COMMISSIONING = 4     /* 2060:21 = 2: slow */
};

/* Returns the fastest rate that is allowed now in this direction, -1 or 1. */
float axis_monitor_fastest_rad_s(const axis_monitor *monitor, float direction);

/* Returns whether it is declared that the base does not move (2060:27). */
static inline bool axis_monitor_base_is_fixed(const axis_monitor *monitor) {
  return monitor->limits.fixed_base_rad > 0.0f;
}

/* Forgets detected faults; the limits stay, and an axis that still turns is kept within them. */
void axis_monitor_reset(axis_monitor *monitor);

/* Returns the faults that the samples of this tick show, and those that the last deferred task has found; `drive` is as
 * the last tick left it. Call it between `servo_board_sample` and `servo_board_control`. */
fault_set axis_monitor_step(axis_monitor *monitor, const servo_board *board, int axis, const drive_axis *drive);

/* What the monitors cannot see on the board. */
typedef struct {
  uint32_t tick;              /* counts */
  bool new_gains;             /* the active ones are not proven yet */
  bool stimulated;            /* an experiment moves the axis */
  bool reduced_speed;         /* 2062 */
  const drive_motion *motion; /* of the drive */
} axis_monitor_setting;

/* Runs the slow monitors, for which a delay of a tick does not matter. Call after each tick, in the deferred task. */
void axis_monitor_judge(axis_monitor *monitor, const servo_board *board, int axis, const axis_monitor_setting *setting);

/* Forgets an oscillation that the old gains caused. Call when the gains have changed. */
void axis_monitor_retuned(axis_monitor *monitor);

/* Writes how the drive must brake, for a tick with a fault or a protective stop. */
void axis_monitor_protect(axis_monitor *monitor, const servo_axis_params *params, drive_axis_inputs *inputs);

/* Returns whether the axis may be switched on: its travel is known, or it is declared to have none. */
static inline bool axis_monitor_may_enable(const axis_monitor *monitor) {
  return (monitor->restrictions & RESTRICTED_NO_TRAVEL) == 0;
}

/* Forgets what broken parts have left: while an axis is off after a fault of its sensors, its bridge or its motor, what
 * the motor witness has learned of R and Ke, because these are repaired before the fault reset, and where
 * `voltage_doubted`: any axis is in a fault of the bus voltage, which all of them read; after wrong readings of gyro or
 * encoder, the base's rate, which begins at what the two differ by. Call between two ticks, every 4 ms. */
void axis_monitor_distrust(axis_monitor *monitor, const drive_axis *drive, bool voltage_doubted,
                           rate_fusion_state *fusion);

/* Finds the turn of the start position and shifts the drive's position to it. Searches again after an encoder jumped,
 * because it may have counted a turn too many. Call between two ticks, every 4 ms. */
void axis_monitor_locate(axis_monitor *monitor, drive_axis *drive);

/* Returns whether a possible turn is within a quarter turn of this position (1e-7 rad), at which the operator has seen
 * the axis; homing has yet to confirm it. */
bool axis_monitor_may_see(const axis_monitor *monitor, const drive_axis *drive, int32_t position);
void axis_monitor_see(axis_monitor *monitor, const drive_axis *drive, int32_t position);

/* Writes the inputs that homing needs. */
void axis_monitor_inform_homing(const axis_monitor *monitor, drive_axis_inputs *inputs);

/* Updates the restrictions and the limits of the envelope. Call between two ticks, every 4 ms. */
void axis_monitor_limit(axis_monitor *monitor);

/* Adds the inputs of the last step to the history of the log. */
void axis_monitor_remember(const axis_monitor *monitor, int axis, fault_log *log);

/* Returns the limits of the axis for its drive, from 0x2060 and the motor of its parameters. */
drive_machine axis_monitor_machine(const axis_monitor *monitor, const servo_axis_params *params);

/* Returns the times of the axis' holding brake, from 0x2060. */
holding_brake_times axis_monitor_brake(const axis_monitor *monitor);

/* Returns the default of 607D: the hard travel less 1 degree at each end, so that a ramp to 607D stops well before the
 * fault. Returns {0, 0}, which limits nothing, without a hard travel or when it is less than 4 degrees. */
drive_travel axis_monitor_default_travel(const axis_monitor *monitor);

#endif
