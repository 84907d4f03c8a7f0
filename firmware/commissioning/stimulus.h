/* The motions of the experiments, one set-point per tick.
 *
 * - sweep: constant speeds, slowest first, each `dwell_s` in both directions, turning round at the ends of the travel;
 * - torque ramps: a triangle of torque in pre-sliding;
 * - hysteresis: a triangle of position over a few bristle lengths; the loop holds the axis against the wind;
 * - chirp: a torque of rising frequency on top of a constant speed, forth and back;
 * - break-away: torque rises from zero until the axis moves, in turns in both directions.
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

/* What a kind does not name it does not use. */
typedef struct {
  stimulus_kind kind;
  float low_rad_s;           /* sweep: the slowest speed; chirp: the speed below it. 1e-6 .. 100 */
  float speed_ratio;         /* sweep: from one speed to the next, 1 .. 10 */
  uint32_t count;            /* speeds, triangles, chirps (each once forth, once back) or break-aways; 1 .. 1000 */
  float dwell_s;             /* sweep: at each speed and direction; chirp: once up; break-away: to the whole torque;
                                triangles: one period. 0.01 .. 1000 */
  float amplitude_nm;        /* torque ramps, chirp, break-away; above 0 .. 1e4 */
  float amplitude_rad;       /* hysteresis: to each side; break-away: what counts as moved. 1e-7 .. 3 */
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
  uint32_t step;                     /* speeds, triangles, chirps, break-aways that are done */
  float direction;                   /* -1 or 1 */
  float speed_rad_s;                 /* sweep: of this step */
  float rate_rad_s;                  /* set-point, on its ramp */
  float time_s[2];                   /* sweep: at the speed, backward and forward; else [1]: in this step */
  float phase_turns;                 /* chirp */
  float resting_s;                   /* break-away: rest still to come */
  float from_rad;                    /* break-away: where the ramp began */
  bool leg_useful;                   /* sweep: this way still needs its time */
  bool ending;                       /* only the way to rest is left */
  breakaway_statistics breakaway[2]; /* backward, forward */
} stimulus_state;

/* What the axis does: its travel from the start of the experiment, and how far it may go to each side. */
typedef struct {
  float travel_rad;
  float room_rad;
} stimulus_view;

control_status stimulus_check(const stimulus_setup *setup);

/* The largest joint rate and torque it will ask for, rad/s and Nm; 0 where the loop decides. */
float stimulus_peak_rate_rad_s(const stimulus_setup *setup);
float stimulus_peak_torque_nm(const stimulus_setup *setup);

/* About how long it takes, s. A sweep may take longer by the ways back from its turning points. */
float stimulus_duration_s(const stimulus_setup *setup);

void stimulus_start(stimulus_state *s, const stimulus_setup *setup, angle_turn32 angle);

/* The set-point of this tick; false once it is over. */
bool stimulus_step(stimulus_state *s, const stimulus_setup *setup, const stimulus_view *view,
                   servo_axis_command *command, float dt_s);

#endif
