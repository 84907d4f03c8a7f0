/* SPDX-License-Identifier: Apache-2.0 */
/* The motions of the experiments, one set-point per tick.
 *
 * - sweep: constant speeds, slowest first, each `dwell_s` in both directions, reversing at the ends of the travel;
 * - torque ramps: a triangle of torque in pre-sliding;
 * - hysteresis: a triangle of position over a few bristle lengths; the loop holds the axis against the wind;
 * - chirp: a torque of rising frequency on top of a constant speed, forward and back;
 * - break-away: torque rises from zero until the axis moves, alternating between the directions.
 *
 * Every stimulus begins and ends at rest. */
#ifndef TRACKSERVO_COMMISSIONING_STIMULUS_H
#define TRACKSERVO_COMMISSIONING_STIMULUS_H

#include "servo/servo_axis.h"

typedef enum {
  STIMULUS_NONE = 0,
  STIMULUS_SWEEP,
  STIMULUS_TORQUE_RAMPS,
  STIMULUS_HYSTERESIS,
  STIMULUS_CHIRP,
  STIMULUS_BREAKAWAY
} stimulus_kind;

/* A kind does not use the members that it does not name. */
typedef struct {
  stimulus_kind kind;
  float low_rad_s;   /* sweep: the slowest speed; chirp: the constant speed. 1e-6 .. 100 */
  float speed_ratio; /* sweep: ratio of one speed to the next, 1 .. 10 */
  uint32_t count;    /* speeds, triangles, chirps (each once forward, once back) or break-aways; 1 .. 1000 */
  float dwell_s; /* sweep: at each speed and direction; chirp: one rise; break-away: to the full torque; triangles: one
                    period. 0.01 .. 1000 */
  float amplitude_nm;        /* torque ramps, chirp, break-away; above 0 .. 1e4 */
  float amplitude_rad;       /* hysteresis: to each side; break-away: angle that counts as motion. 1e-7 .. 3 */
  float low_hz;              /* chirp, 0.01 .. 400 */
  float high_hz;             /* chirp, low_hz .. 400 */
  float acceleration_rad_s2; /* sweep and chirp, 1e-4 .. 1e4 */
} stimulus_setup;

/* Directions of motion, as indices. */
enum { STIMULUS_BACKWARD, STIMULUS_FORWARD };

/* Break-away torques of one direction so far (Welford). */
typedef struct {
  uint32_t count;
  float mean_nm;
  float square_sum_nm2; /* of the deviations from the mean */
} breakaway_statistics;

typedef struct {
  angle_turn32 start_angle;
  uint32_t step;     /* completed speeds, triangles, chirps, break-aways */
  float direction;   /* -1 or 1 */
  float speed_rad_s; /* sweep: of this step */
  float rate_rad_s;  /* set-point, on its ramp */
  float time_s[2];   /* sweep: time at the speed, backward and forward; otherwise [1]: time in this step */
  float phase_turns; /* chirp */
  float resting_s;   /* break-away: remaining rest */
  float from_rad;    /* break-away: start angle of the ramp */
  bool leg_useful;   /* sweep: this direction needs more time */
  bool ending;       /* only the motion to rest is left */
  breakaway_statistics breakaway[2]; /* backward, forward */
} stimulus_state;

/* State of the axis: its travel from the start of the experiment, and the limits to each side. */
typedef struct {
  float travel_rad;
  float room_rad;
} stimulus_view;

control_status stimulus_check(const stimulus_setup *setup);

/* Return the largest joint rate and torque that it will command, rad/s and Nm; 0 where the loop decides. */
float stimulus_peak_rate_rad_s(const stimulus_setup *setup);
float stimulus_peak_torque_nm(const stimulus_setup *setup);

/* Returns the approximate duration, s. A sweep may take longer, because of the return from its turning points. */
float stimulus_duration_s(const stimulus_setup *setup);

void stimulus_start(stimulus_state *s, const stimulus_setup *setup, angle_turn32 angle);

/* Writes the set-point of this tick; returns false once it has ended. */
bool stimulus_step(stimulus_state *s, const stimulus_setup *setup, const stimulus_view *view,
                   servo_axis_command *command, float dt_s);

#endif
