/* SPDX-License-Identifier: Apache-2.0 */
/* Whether the loops of an axis are stable on its identified plant, and how far from -1 their Nyquist curves stay.
 *
 * The closed loop, sampled once per tick, is stable when its characteristic function has no zero outside the unit
 * circle:
 *
 *     G(q) = D(q) (1 + L(q)),   q = 1/z,   L: every block that runs, D: its poles on the unit circle and the plant's
 *
 * G has no pole inside |q| <= 1, so the number of such zeros is the number of turns of G(e^-jw) around 0 (argument
 * principle). The phase of G is followed from w = 0 to half the tick's rate; its steps are bisected until none is
 * larger than LOOP_PHASE_STEP, so no turn is missed. With it comes |1 + L|, the distance to -1 (modulus margin).
 *
 * Blocks: PI, notch, low-pass, observer, rate estimator, fusion, as their difference equations say; inertia, current
 * loop and delays sampled exactly (zero-order hold, delay of any part of a tick); position and tracking loop around
 * them. Operating points: sliding and pre-sliding seal, largest and smallest inertia; with the gains for the inertia
 * where they follow it (speed_loop_follow). Not for the tick: work is cut into slices of some frequencies. */
#ifndef TRACKSERVO_CONTROL_LOOP_STABILITY_H
#define TRACKSERVO_CONTROL_LOOP_STABILITY_H

#include "control/position_loop.h"
#include "control/speed_loop.h"
#include "control/target_tracker.h"

/* Smallest |1 + L| at the largest inertia; at the smallest one likewise, but where the same gains turn less inertia,
 * margins shrink. */
#define LOOP_LEAST_DISTANCE 0.3f
#define LOOP_LEAST_DISTANCE_OF_FIXED_GAINS 0.1f
#define LOOP_PHASE_STEP 0.8f

enum { LOOP_OPERATING_POINTS = 4, LOOP_COUNT = 3 };

typedef struct {
  float inertia_kg_m2;
  float min_inertia_kg_m2;
  float viscous_nm_s_rad;
  float stiffness_nm_rad; /* of the bristles; 0: no pre-sliding */
  float damping_nm_s_rad; /* of the bristles */
  float encoder_delay_s;  /* from a command to its angle, without the hold: latency, current loop, encoder */
  float gyro_delay_s;     /* the same to the gyro's rate */
} loop_plant;

/* Constant while it runs. */
typedef struct {
  speed_loop_params speed;
  float position_per_s;
  target_tracker_params tracker;
  loop_plant plant;
  bool gains_follow;  /* the inertia */
  bool gyro_vanishes; /* at the smallest inertia, where the encoder then replaces it */
  bool gyro_below;    /* the joint: what the loop feeds back of its motion comes from the encoder */
  float dt_s;
} loop_stability_input;

typedef enum { LOOP_RUNNING, LOOP_STABLE, LOOP_REFUSED } loop_verdict;

typedef enum { LOOP_SPEED = 0, LOOP_POSITION = 1, LOOP_TRACKING = 2 } loop_name;

typedef struct {
  float re;
  float im;
} loop_complex;

typedef struct {
  int point;   /* operating point */
  float omega; /* rad per tick, of the last values */
  float step;
  loop_complex last[LOOP_COUNT];
  float phase[LOOP_COUNT];
  uint32_t evaluations; /* at this operating point */
  loop_verdict verdict;
  float distance; /* smallest |1 + L| so far */
} loop_stability;

void loop_stability_start(loop_stability *state);

/* Evaluates up to `count` frequencies, of about 1,500 in all. Cost: about 1,200 instructions each. */
loop_verdict loop_stability_step(loop_stability *state, const loop_stability_input *input, int count);

#endif
