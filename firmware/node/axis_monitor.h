/* Protection of one axis within the node: collects the inputs of the detection and keeps the history of the fault
 * log. */
#ifndef TRACKSERVO_NODE_AXIS_MONITOR_H
#define TRACKSERVO_NODE_AXIS_MONITOR_H

#include "drive/drive_motion.h"
#include "drive/holding_brake.h"
#include "protection/axis_protection.h"
#include "protection/fault_log.h"
#include "protection/oscillation.h"
#include "protection/slow_monitors.h"
#include "servo/servo_board.h"

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
  fault_set found;              /* by the last step */
  slow_monitors slow;
  angle_turn32 last_position; /* commanded, when the slow monitors judged last */
} axis_monitor;

/* No fault detected yet; the limits stay. */
void axis_monitor_reset(axis_monitor *monitor);

/* The faults that the samples of this tick show, and those that the last deferred task has judged; `position` is that
 * of the drive in the last tick. Call it between `servo_board_sample` and `servo_board_control`. */
fault_set axis_monitor_step(axis_monitor *monitor, const servo_board *board, int axis, drive_angle position);

/* What the monitors cannot see on the board. */
typedef struct {
  uint32_t tick;      /* counts */
  bool new_gains;     /* the active ones are not proven yet */
  bool stimulated;    /* an experiment moves the axis */
  bool reduced_speed; /* 2062 */
} axis_monitor_setting;

/* After each tick, in the deferred task: the monitors that need many ticks, so that one more does not count. */
void axis_monitor_judge(axis_monitor *monitor, const servo_board *board, int axis, const axis_monitor_setting *setting);

/* The gains have changed: an oscillation that the old ones caused no longer counts. */
void axis_monitor_retuned(axis_monitor *monitor);

/* Adds the inputs of the last step to the history of the log. */
void axis_monitor_remember(const axis_monitor *monitor, int axis, fault_log *log);

/* Limits of the axis for its drive: from 0x2060, motor and inertia of its parameters. */
drive_machine axis_monitor_machine(const axis_monitor *monitor, const servo_axis_params *params);

/* Of the axis' holding brake, from 0x2060. */
holding_brake_times axis_monitor_brake(const axis_monitor *monitor);

/* The default of 607D: the hard travel less 1 degree at each end, so that a ramp to 607D stops well before the fault.
 * {0, 0}, which limits nothing, without a hard travel or when it is less than 4 degrees. */
drive_travel axis_monitor_default_travel(const axis_monitor *monitor);

#endif
