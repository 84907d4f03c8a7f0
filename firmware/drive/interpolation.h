/* SPDX-License-Identifier: Apache-2.0 */
/* Set-points that arrive every few ms (csp, csv), made continuous in each tick.
 *
 *     rate:      a straight line to the new set-point, one interpolation period (60C2) long
 *     position:  a cubic from the present demand to the new set-point; its end rate is the slope of the
 *                parabola through the last three set-points, so that position and rate are exact on parabolas
 *
 * (CiA 402-2 clauses 7.10 to 7.13.) The result is one period late. When the next set-point is late, the last slope is
 * continued (position) or the last rate held, until `interpolation_stale` makes the caller stop the axis. */
#ifndef TRACKSERVO_DRIVE_INTERPOLATION_H
#define TRACKSERVO_DRIVE_INTERPOLATION_H

#include <stdbool.h>
#include <stdint.h>

#include "drive/drive_units.h"

enum { INTERPOLATION_MAX_TICKS = 255, INTERPOLATION_POINTS = 3 };

/* Set-points have stopped when none came for three periods, but not before 20 ticks: a client without a real-time
 * system is sometimes late by that much. */
enum { INTERPOLATION_HELD_PERIODS = 3, INTERPOLATION_HELD_TICKS = 20 };

/* Returns period 10^exponent s in ticks, rounded; 0 when that is not 1 .. 255: a dictionary refuses such a value. */
int interpolation_ticks(uint8_t period, int8_t exponent, float dt_s);

bool interpolation_stale(int age_ticks, int period_ticks);

typedef struct {
  float rate_rad_s; /* now */
  float target_rad_s;
  float slope_rad_s2; /* until left_ticks have passed */
  int left_ticks;
} rate_interpolation;

void rate_interpolation_reset(rate_interpolation *state, float rate_rad_s);

/* Takes a set-point that has arrived. */
void rate_interpolation_aim(rate_interpolation *state, float target_rad_s, int period_ticks, float dt_s);

typedef struct {
  float rate_rad_s;          /* now */
  float acceleration_rad_s2; /* until the next tick */
} interpolated_rate;

/* Returns the rate of now; then the state is that of the next tick. */
interpolated_rate rate_interpolation_step(rate_interpolation *state, float dt_s);

typedef struct {
  drive_angle last;      /* set-point */
  float last_travel_rad; /* to it from the previous one */
  int known_points;
  drive_angle start; /* of the cubic */
  drive_angle end;
  float travel_rad; /* from its start to its end */
  float start_rad_s;
  float end_rad_s;
  int elapsed_ticks;
  int period_ticks;
} position_interpolation;

typedef struct {
  drive_angle position;
  float rate_rad_s;
} interpolated_position;

/* Begins at `position`, which moves with `rate_rad_s` until the first one arrives. */
void position_interpolation_reset(position_interpolation *state, drive_angle position, float rate_rad_s);

/* Takes a set-point that has arrived. A distance that needs a mean rate above `rate_limit_rad_s` is shortened: the axis
 * arrives later. Returns whether it was. */
bool position_interpolation_aim(position_interpolation *state, drive_angle target, int period_ticks,
                                float rate_limit_rad_s, float dt_s);

/* Returns position and rate of now; then the state is that of the next tick. */
interpolated_position position_interpolation_step(position_interpolation *state, float dt_s);

#endif
