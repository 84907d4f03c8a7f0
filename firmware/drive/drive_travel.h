/* SPDX-License-Identifier: Apache-2.0 */
/* The travel that set-points may use, and how an axis comes to rest within it.
 *
 *     in force   607D, within the hard travel (2060:9, :10) less the stopping margin (2060:17) at either end
 *     braking    62 % of the sure deceleration (2060:19), less where the objects limit the torque
 *
 * No ramp goes beyond it. So the overshoot of a loop has the distance between the end of a ramp and fault 8612
 * (docs/decisions/travel.md). Positions are in the units of 607D: 1e-7 rad. */
#ifndef TRACKSERVO_DRIVE_DRIVE_TRAVEL_H
#define TRACKSERVO_DRIVE_DRIVE_TRAVEL_H

#include <stdbool.h>
#include <stdint.h>

#include "drive/drive_objects.h"
#include "drive/drive_units.h"
#include "drive/profile_ramp.h"

/* Not limited unless minimum < maximum. */
typedef struct {
  int32_t minimum;
  int32_t maximum;
} drive_travel;

/* Limits of the machine, whatever the objects of CiA 402 say; 0 where unknown. */
typedef struct {
  drive_travel hard;              /* 2060:9 and :10 */
  int32_t margin;                 /* 2060:17, 0 or more; twice this is less than the hard travel */
  float overspeed_rad_s;          /* 2060:1; above it is a fault */
  float position_rad_s;           /* 2010:2, the fastest that the position loop commands */
  float torque_nm;                /* of the motor at its current limit */
  float deceleration_rad_s2;      /* 2060:19, which this torque surely gives */
  float stop_deceleration_rad_s2; /* no ordered stop is more gentle */
  bool slow;                      /* 5 degrees per second at most */
  bool position_unknown;          /* the end of the travel may be anywhere; pp and csp wait */
} drive_machine;

/* Limits in effect in a tick. */
typedef struct {
  drive_travel soft;   /* 607D when it last was consistent */
  drive_travel travel; /* in force */
  drive_angle lowest;  /* its ends, converted once */
  drive_angle highest;
  float rate_rad_s;     /* 607F, or 80 % of 2060:1 if that is less: no set-point causes fault 7180 */
  float position_rad_s; /* of pp and csp: no faster than the position loop, or the axis would fall behind */
  float braking_rad_s2;
  float stop_rad_s2;     /* least deceleration of an ordered stop */
  float jerk_rad_s3;     /* 60A4, or what it was when the ramp's acceleration began, if that is more */
  bool position_unknown; /* no position has a meaning */
} drive_bounds;

/* Renews the bounds from those of the previous tick: a 607D whose minimum is above its maximum leaves the last valid
 * one in effect. */
void drive_bounds_update(drive_bounds *bounds, const drive_objects *objects, const drive_machine *machine);

static inline bool drive_travel_is_limited(const drive_travel *travel) { return travel->minimum < travel->maximum; }

/* Returns an angle as the bus shows it (6062, 6064). Within a limited travel nothing wraps: it saturates at 34 turns.
 */
int32_t drive_travel_position(const drive_travel *travel, drive_angle angle);

/* Returns the nearest position of the travel; the position itself when the travel is not limited. */
int32_t drive_travel_clamp(const drive_travel *travel, int32_t position);

/* Returns the distance from a position to the limit in this direction, signed. */
float drive_travel_room_rad(const drive_bounds *bounds, drive_angle position, float direction);

/* Returns -1 or 1: a position at or beyond the limit on that side; 0: within the travel. */
float drive_travel_side(const drive_bounds *bounds, drive_angle position);

/* Returns the ramp limits of a stop that must end in the travel: those of the mode, but no harder than the motor can
 * brake. */
profile_limits drive_braking_within(const drive_bounds *bounds, const profile_limits *limits);

/* Finds the ramp limits of a halt or quick stop from here. If the stop would leave the travel, they are as hard as
 * needed, up to what the motor can brake. Returns whether it would leave the travel. */
bool drive_stop_within(const drive_bounds *bounds, profile_limits *limits, const profile_ramp *ramp,
                       drive_angle position);

/* Raises the limits of a stop that a fault or a command ordered to the least that protection allows. The acceleration
 * of a ramp that still gains speed is limited to what the jerk ends within 0.05 rad/s. */
void drive_stop_at_least(const drive_bounds *bounds, profile_limits *limits, profile_ramp *ramp);

/* Returns a rate, limited so that a stop along `braking` from this position ends within the travel. */
float drive_rate_within(const drive_bounds *bounds, const profile_limits *braking, drive_angle position,
                        float rate_rad_s, float dt_s);

#endif
