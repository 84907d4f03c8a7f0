/* SPDX-License-Identifier: Apache-2.0 */
/* The set-point of the servo axis in this tick, from the CiA 402 targets and the mode of operation.
 *
 * Standard: CiA 402-2 / IEC 61800-7-201 clauses 7.2 (pp), 7.3 (pv), 7.5 (hm), 7.11 (csp), 7.12 (csv), 7.13 (cst) and
 * the stops of 8.5; mode -1 (tracking) is of this manufacturer: the axis follows the camera's target, within the
 * limits of csv. All modes share one ramp state and one position demand, so a new mode, a halt or a stop continues
 * from the set-point of the last tick without a step. Rate and position are those of now; the acceleration is the mean
 * of the coming tick: as torque over an inertia it gives exactly the next rate. */
#ifndef TRACKSERVO_DRIVE_DRIVE_MOTION_H
#define TRACKSERVO_DRIVE_DRIVE_MOTION_H

#include <stdbool.h>

#include "base/scalar.h"
#include "drive/drive_objects.h"
#include "drive/drive_state.h"
#include "drive/drive_travel.h"
#include "drive/drive_units.h"
#include "drive/interpolation.h"
#include "drive/profile_ramp.h"
#include "drive/setpoint_queue.h"
#include "servo/servo_axis.h"
#include "servo/servo_target.h"

/* Actual values of the axis; finite. */
typedef struct {
  drive_angle position;
  float rate_rad_s;                   /* the rate that the speed loop controls */
  float reference_rad_s;              /* its set-point in the last tick */
  float torque_demand_nm;             /* commanded in the last tick */
  bool setpoint_arrived;              /* 607A, 60FF or 6071 was written since the last tick, also with the same value */
  const servo_target *target;         /* of the camera; NULL: none */
  const servo_axis_command *stimulus; /* of an experiment: replaces the mode while no mode is selected; or NULL */
  float protective_nm;                /* torque of a protective stop */
} drive_feedback;

/* Meaning of 60C2 when it was last evaluated. */
typedef struct {
  uint8_t mantissa;
  int8_t exponent;
  int ticks; /* 0: not evaluated yet */
} setpoint_period;

/* Result of the ramp of pp, pv or hm in a tick. */
typedef struct {
  bool ready;
  profile_ramp ramp;
  drive_angle demand;
  float demand_rest;
  float travel_rad;
  float mean_acceleration_rad_s2;
  drive_angle target; /* of pp */
  bool arrived;       /* there */
  bool limited;       /* a limit changed the commanded value */
  bool held;          /* of pv: a limit of the travel stops it, and holds the position */
} drive_profile_step;

/* Between which rates an axis may follow the camera's target, and how fast it changes them. */
typedef struct {
  float minimum_rad_s;
  float maximum_rad_s;
  float acceleration_rad_s2; /* largest change of the rate */
  float jerk_rad_s3;         /* largest change of the acceleration that is fed forward */
} drive_tracking_limits;

/* Returns the rate one tick after `before_rad_s`. The end of the travel takes precedence over the limit of the
 * acceleration. */
static inline float drive_tracking_rate_within(const drive_tracking_limits *limits, float wanted_rad_s,
                                               float before_rad_s, float dt_s) {
  const float step_rad_s = limits->acceleration_rad_s2 * dt_s;
  const float soft_rad_s = scalar_clamp(wanted_rad_s, before_rad_s - step_rad_s, before_rad_s + step_rad_s);
  return scalar_clamp(soft_rad_s, limits->minimum_rad_s, limits->maximum_rad_s);
}

typedef struct {
  int8_t mode;     /* drive_mode in effect */
  servo_mode loop; /* of the last tick */
  profile_ramp ramp;
  drive_angle demand;
  float demand_rest;       /* remainder below the last digit, in 2^-32 turn */
  drive_angle position;    /* of the axis in the last tick */
  float travel_rad;        /* of the ramp since then: pp, pv and stops */
  drive_profile_step next; /* prepared for the coming tick */
  setpoint_queue setpoints;
  rate_interpolation rates;
  position_interpolation positions;
  int setpoint_age_ticks;
  setpoint_period period;
  drive_bounds bounds;            /* in force */
  float blocked_direction;        /* -1 or 1: stopped before the end of the travel on that side; 0: free */
  drive_tracking_limits tracking; /* of the last tick that tracked */
  const servo_target *followed;   /* the target that it tracks in this tick; NULL: none */
  float tracked_rad_s2;           /* the acceleration that it fed forward, or that of the ramp */
  bool ordered;                   /* a command, a fault or missing set-points order a stop: protection sees to it */
  bool carried_on;                /* nothing was prepared for the last tick either */
  float torque_nm;                /* cst: moving along the torque slope */
  float homing_rad_s;             /* hm: set-point of the ramp */
  uint16_t blocked_ms;            /* for so long it has not got to a held position outside the travel */
} drive_motion;

typedef struct {
  servo_axis_command command;
  drive_angle position; /* demand; the actual position when no position is controlled */
  bool limited;         /* a limit changed the commanded value */
  bool followed;        /* the target is followed: no stop, set-points are recent */
  bool stopped;         /* a stop has ended */
} drive_setpoint;

bool drive_mode_supported(int8_t mode);

/* Returns the complete ramp limits of this tick: profile velocity and deceleration depend on the motion. A lower 60A4
 * counts when the acceleration is 0: before, the rate would pass its target, and 0, while the acceleration ends. */
profile_limits drive_profile_limits(const drive_bounds *bounds, const drive_limit_objects *limit, float rate_rad_s,
                                    uint32_t deceleration);

void drive_motion_reset(drive_motion *motion, drive_angle position);

/* Shifts every position by `by`. Call when the position of the axis was wrong by that much. */
void drive_motion_shift(drive_motion *motion, drive_angle by);

/* Computes one tick. An unsupported mode leaves the current one in effect. In pp, pv and hm it takes the prepared step.
 * In the first tick nothing is prepared, and the ramp continues with its acceleration. Not inlined: it would push the
 * monitors out of line, which costs 500 instructions in the tick. */
drive_setpoint drive_motion_step(drive_motion *motion, const drive_objects *objects, drive_action action,
                                 const drive_feedback *feedback, float dt_s) __attribute__((noinline));

/* Prepares the next step of the ramp of pp, pv or hm, between two ticks. Finding the time at which a stop must begin
 * takes too long for the tick. So targets and limits of these modes take effect one tick later, and so do the bounds of
 * travel and rate in every mode. */
void drive_motion_prepare(drive_motion *motion, const drive_objects *objects, const drive_machine *machine, float dt_s);

#endif
