/* SPDX-License-Identifier: Apache-2.0 */
/* LuGre friction of a seal or bearing, discretised for a fixed tick.
 *
 * Continuous model (paper eqs (1)-(3); Canudas de Wit et al. 1995):
 *     T_f = s0 z + s1 dz/dt + s2 v,   dz/dt = v - s0 |v| / g(v) z,   g(v) = Tc + (Ts - Tc) exp(-(v/vs)^2)
 * with the direction's own Tc, Ts, vs and s2 (the paper fits each direction by itself, section II.A).
 *
 * Discretisation: with the speed held over the tick the bristle equation is linear in z and has an exact
 * exponential solution, so the step is stable for every parameter set, speed and tick length; |z| never leaves
 * max(Ts)/s0. The torque is its mean over the tick, so the energy taken from the shaft is that of the continuous model.
 * That model itself is passive only while s0 |v|/g <= 4 s0/s1 [Barahona & Canudas de Wit 2003, see docs/theory.md];
 * beyond, s1 is reduced to 4 g/|v|, which changes nothing in steady sliding (dz/dt = 0). */
#ifndef TRACKSERVO_CONTROL_LUGRE_H
#define TRACKSERVO_CONTROL_LUGRE_H

#include "base/status.h"

/* Stribeck curve of one direction of motion, eq. (5). */
typedef struct {
  float coulomb_nm;           /* Tc, 1e-6 .. 1e4 */
  float breakaway_nm;         /* Ts, Tc .. 1e4 */
  float stribeck_speed_rad_s; /* vs, 1e-6 .. 1e2 */
  float viscous_nm_s_rad;     /* s2, 0 .. 1e4 */
} lugre_direction;

typedef struct {
  float stiffness_nm_rad;   /* s0, 1e-3 .. 1e9 */
  float damping_nm_s_rad;   /* s1, 0 .. 1e6 */
  lugre_direction positive; /* used for v >= 0 */
  lugre_direction negative; /* used for v < 0 */
} lugre_params;

typedef struct {
  float deflection_rad; /* z, mean bristle deflection */
} lugre_state;

/* Checks the ranges above, Ts >= Tc, and a bristle deflection Ts/s0 of at most 1 rad in both directions. */
control_status lugre_check(const lugre_params *params);

void lugre_reset(lugre_state *state);

/* Sets the bristles to their state after long sliding at this rate; relaxed when it is 0. */
void lugre_settle(lugre_state *state, const lugre_params *params, float speed_rad_s);

/* Returns g(v) of eq. (3) in Nm, always within [Tc, Ts]. The sign of the speed has no effect. */
float lugre_stribeck_nm(const lugre_direction *direction, float speed_rad_s);

/* Returns friction torque in steady sliding, eq. (5), in Nm; 0 at standstill. */
float lugre_steady_nm(const lugre_params *params, float speed_rad_s);

/* Advances the bristles by dt_s (1e-6 .. 1 s) at constant joint rate (within +-1e6 rad/s) and returns the mean friction
 * torque over that time in Nm, positive against positive motion. */
float lugre_step(lugre_state *state, const lugre_params *params, float speed_rad_s, float dt_s);

#endif
