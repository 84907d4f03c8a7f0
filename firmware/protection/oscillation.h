/* SPDX-License-Identifier: Apache-2.0 */
/* Finds a loop that shakes its axis, once per tick: oscillation that the motor itself sustains.
 *
 * Two signals are divided into swings, from one turning point to the next:
 *
 * - the rate error e = r - v. Newton gives  J de/dt + T = J dr/dt + f - d  with the motor's torque T, friction f and
 *   the external torque d. Its right side is what excites the axis from outside. Over a swing its impulse is compared
 *   with J times the swing. A loop that is stable with the usual margin (|S| <= 2) makes of an excitation a swing of at
 *   most twice its impulse. A swing of more than 2.5 times is not explained by any set-point, gust or stimulus: the
 *   motor has made it. A few of them in a row that do not decay are an oscillation.
 * - the torque T, for oscillations so fast that the axis hardly moves.
 *
 * A swing counts before its turning point, as soon as it is larger than the one before. So a loop that diverges is
 * found while it is growing. It only detects; axis_tuning and the drive react. */
#ifndef TRACKSERVO_PROTECTION_OSCILLATION_H
#define TRACKSERVO_PROTECTION_OSCILLATION_H

#include <stdbool.h>

typedef struct {
  float inertia_kg_m2; /* of the identified plant */
  float friction_nm;   /* of the seal in sliding: it may explain a part of each swing */
  float torque_nm;     /* what the motor can give */
  bool suspect;        /* new gains, that have not run for long: less evidence suffices */
} oscillation_params;

typedef struct {
  bool closed;           /* a loop above the current loop acts: speed, position or tracking */
  float reference_rad_s; /* from outside: speed set-point, increment of a position set-point, what a target asks for */
  bool reference_known;  /* false in tracking: the camera may make the axis swing slowly */
  float rate_rad_s;      /* joint rate of the last tick, from the encoder */
  float loop_nm;         /* commanded in the last tick by the loops, without what was added from outside */
  float feedforward_nm;  /* the part of it that follows from the set-point alone */
  float added_nm;        /* added from outside: a stimulus, 60B2 */
} oscillation_inputs;

/* A signal between two turning points. */
typedef struct {
  float from;   /* last turning point */
  float to;     /* furthest value since */
  float before; /* size of the swing before this one */
  float ticks;  /* from the last turning point to `to` */
  float since;  /* from `to` to now */
  float rising; /* 1 or -1: direction of this swing */
  float count;  /* swings in a row that count */
} oscillation_swings;

typedef struct {
  oscillation_swings rate;
  oscillation_swings torque;
  float last_error_rad_s;
  float last_loop_nm;
  float last_feedback_nm;
  float last_reference_rad_s;
  float slow_reference_rad_s;
  float stepped_rad_s;   /* recent changes of the set-point: the loop may still recover from them */
  float mean_nm;         /* slow mean of the torque: static loads */
  float mean_back_nm;    /* the same of the feedback's share */
  float lasted;          /* ticks of the swings in a row that count */
  float unchanged;       /* ticks since set-point or stimulus last required another torque */
  float impulse;         /* of the excitation since the last turning point, Nm s */
  float impulse_to;      /* the same at `rate.to` */
  float wrong_ticks;     /* in a row in which the motor drives the axis away from its set-point */
  float outside_high_nm; /* recent range of the torque that set-point and stimulus ask for */
  float outside_low_nm;
} oscillation;

/* Returns whether fast torque swings have begun: other monitors may see their effects first. */
static inline bool oscillation_may_begin(const oscillation *state) { return state->torque.count >= 3.0f; }

/* Forgets all swings. Call it also when a loop closes. */
void oscillation_reset(oscillation *state);

/* Computes one tick. Returns true in each tick in which the axis shakes. docs/cost.md has the cost. */
bool oscillation_step(oscillation *state, const oscillation_params *params, const oscillation_inputs *in, float dt_s);

#endif
