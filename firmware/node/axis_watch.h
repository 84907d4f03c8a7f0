/* Protection of one axis within the node: collects the inputs of the detection and keeps the history of the fault
 * log. */
#ifndef TRACKSERVO_NODE_AXIS_WATCH_H
#define TRACKSERVO_NODE_AXIS_WATCH_H

#include "drive/drive_motion.h"
#include "protection/axis_protection.h"
#include "protection/fault_log.h"
#include "servo/servo_board.h"

typedef struct {
  protection_limits limits; /* 0x2060, in effect */
  protection_inputs seen;   /* by the last step */
  axis_protection state;
} axis_watch;

/* No fault detected yet; the limits stay. */
void axis_watch_reset(axis_watch *watch);

/* The faults that the samples of this tick show; `position` is that of the drive in the last tick. Call it between
 * `servo_board_sample` and `servo_board_control`. */
fault_set axis_watch_step(axis_watch *watch, const servo_board *board, int axis, drive_angle position,
                          float bus_voltage_v);

/* Adds the inputs of the last step to the history of the log. */
void axis_watch_remember(const axis_watch *watch, int axis, fault_log *log);

/* Limits of the axis for its drive: from 0x2060, motor and inertia of its parameters. */
drive_machine axis_watch_machine(const axis_watch *watch, const servo_axis_params *params);

/* The default of 607D: the hard travel less 1 degree at each end, so that a ramp to 607D stops well before the fault.
 * {0, 0}, which limits nothing, without a hard travel or when it is less than 4 degrees. */
drive_travel axis_watch_default_travel(const axis_watch *watch);

#endif
