/* SPDX-License-Identifier: Apache-2.0 */
/* Velocity disturbance observer: estimates the load torque from the applied torque and the resulting rate.
 *
 *     d = Q(s) [ u - (J s + B) v ],   Q(s) = w / (s + w)
 *
 * with nominal inertia J and viscous coefficient B. Written with the auxiliary state xi = d + w J v the rate is
 * never differentiated: the noise gain from v to d is bounded by w J (Ohnishi's form of the observer).
 *
 * `torque_nm` is the torque that the motor actually gave during the last tick, less every torque that is already
 * explained (friction feedforward). So the observer sees only the residual, and a saturated command cannot wind it
 * up. */
#ifndef TRACKSERVO_CONTROL_DISTURBANCE_OBSERVER_H
#define TRACKSERVO_CONTROL_DISTURBANCE_OBSERVER_H

#include "base/status.h"

typedef struct {
  float inertia_kg_m2;    /* J, 1e-9 .. 1e5 */
  float viscous_nm_s_rad; /* B, 0 .. 1e4; 0 leaves the viscous torque to the observer */
  float bandwidth_rad_s;  /* w, 0.01 .. 1000, and w dt <= 1 */
  float limit_nm;         /* limit of the compensation, 0 .. 1e4 */
} disturbance_observer_params;

typedef struct {
  float prediction_nm; /* the predicted xi of the next tick, without the torque of this tick */
  float estimate_nm;   /* d before the limit */
  /* The parameters converted for the tick, by reset and retune: the conversion takes an exp and a division. */
  float blend;               /* 1 - exp(-w dt), the exact pole of Q */
  float momentum_nm_s_rad;   /* blend J / dt, the discrete w J */
  float prediction_nm_s_rad; /* prediction gain of the rate */
} disturbance_observer_state;

/* Checks the ranges above, and bandwidth * dt_s <= 1. */
control_status disturbance_observer_check(const disturbance_observer_params *params, float dt_s);

/* Starts with estimate 0 at the measured rate. */
void disturbance_observer_reset(disturbance_observer_state *state, const disturbance_observer_params *params,
                                float rate_rad_s, float dt_s);

/* Changes the parameters and keeps the estimate; `rate_rad_s` as in the last tick. Changed parameters take effect only
 * by this call or by a reset; the limit takes effect at once. */
void disturbance_observer_retune(disturbance_observer_state *state, const disturbance_observer_params *params,
                                 float rate_rad_s, float dt_s);

/* Changes the inertia alone and keeps the estimate; `rate_rad_s` as in the last tick. Cheap enough for every tick: some
 * multiplications. The next reset or retune takes the inertia of its parameters again. */
void disturbance_observer_follow(disturbance_observer_state *state, const disturbance_observer_params *params,
                                 float inertia_kg_m2, float rate_rad_s, float dt_s);

/* Computes one tick. `rate_rad_s` is measured now; `torque_nm` was applied since the last tick, less what friction
 * feedforward explains. Returns the torque that cancels the load, in Nm, within +-limit_nm. */
float disturbance_observer_step(disturbance_observer_state *state, const disturbance_observer_params *params,
                                float rate_rad_s, float torque_nm);

#endif
