/* SPDX-License-Identifier: Apache-2.0 */
/* Ramps with limited rate, acceleration and jerk: to a rate (pv, stops), or over a distance (pp).
 *
 *     to a rate         jerk +-j until the acceleration meets its limit, hold, jerk back to 0; in closed form
 *     over a distance   go on towards the profile rate as long as one can still stop in time, then stop
 *
 * (CiA 402-2 clauses 7.2 and 7.3: 6081, 6083, 6084, 60A4, 607F.) Every tick decides anew from its own state, so the
 * target and the limits may change at any time. Switching times fall between ticks: with equal acceleration and
 * deceleration a move takes the shortest time that the limits allow, plus at most two ticks and 1 %.
 *
 * The state holds a rate and an acceleration, never a position. Inputs and outputs are distances, which are short at
 * the end of a move, so single precision resolves better than the encoder. The caller sums them in integers
 * (drive_angle). */
#ifndef TRACKSERVO_DRIVE_PROFILE_RAMP_H
#define TRACKSERVO_DRIVE_PROFILE_RAMP_H

#include <stdbool.h>

#include "base/status.h"

typedef struct {
  float rate_rad_s;          /* 1e-6 .. 4300 */
  float acceleration_rad_s2; /* of changes that increase |rate|, 1e-6 .. 4300 */
  float deceleration_rad_s2; /* of changes that decrease it, 1e-6 .. 4300 */
  float jerk_rad_s3;         /* 1e-6 .. 4300 */
} profile_limits;

/* State of the ramp now. */
typedef struct {
  float rate_rad_s;
  float acceleration_rad_s2;
  /* Remainders below the last digits above: without them a gentle ramp is 1e-4 off its plan after some seconds. */
  float rate_rest_rad_s;
  float acceleration_rest_rad_s2;
} profile_ramp;

/* Motion in the coming tick. */
typedef struct {
  float travel_rad;
  float mean_acceleration_rad_s2; /* rate change / tick: with an inertia it is the torque that gives this motion */
  bool arrived;                   /* at the commanded rate, or at rest at the end of the distance */
  bool stops;                     /* within a room: it is too short to continue */
} profile_motion;

control_status profile_limits_check(const profile_limits *limits);

bool profile_at_rest(const profile_ramp *ramp);

/* Returns the stopping distance from here, signed, with the deceleration and jerk limits. */
float profile_stop_travel_rad(const profile_ramp *ramp, const profile_limits *limits);

/* Makes one tick towards `rate_rad_s` (finite; the caller limits it). No overshoot; arrives exactly. */
profile_motion profile_towards_rate(profile_ramp *ramp, const profile_limits *limits, float rate_rad_s, float dt_s);

/* Does the same, but comes to rest, along `braking`, before it has travelled more than `room_rad` in the direction of
 * `rate_rad_s`. When it is too late for that, stops as soon as these limits allow. Cost: three times that of
 * profile_towards_rate; in the tick in which the stop begins at most eight times. */
profile_motion profile_towards_rate_within(profile_ramp *ramp, const profile_limits *limits,
                                           const profile_limits *braking, float rate_rad_s, float room_rad, float dt_s);

/* Makes one tick towards rest at `distance_rad` from here, at no more than limits->rate_rad_s. Overshoots, and then
 * comes back, only when the limits make it unavoidable (or by rounding: 1e-7 of the distance). `travel_rad` is
 * `distance_rad` in the tick in which it arrives. */
profile_motion profile_towards_distance(profile_ramp *ramp, const profile_limits *limits, float distance_rad,
                                        float dt_s);

#endif
