/* SPDX-License-Identifier: Apache-2.0 */
/* How the set-point of the speed loop moves when it jumps: as a second-order system, with the acceleration that the
 * motion needs. The loop then follows by feedforward and its PI has only disturbances to reject, so its gains may have
 * any damping without overshoot.
 *
 *     x = r - y,   p' = d p - g x,   y' = y + (a - p') dt          output: rate y, acceleration a - p'
 *
 * r and a: set-point and its announced acceleration over the coming tick. A ramp that is announced passes unchanged:
 * only x, what y lacks, decays, with the poles of (s + w)^2:
 *
 *     d = exp(-2 w dt),   g dt = (1 - exp(-w dt))^2
 *
 * A jump does not overshoot and has 90 % after 3.9 / w; a ramp that is not announced lags by 2 / w. Source:
 * two-degree-of-freedom control with model following (Astrom & Murray, Feedback Systems, 8.5). Cost: 25 instructions.
 */
#ifndef TRACKSERVO_CONTROL_SETPOINT_MODEL_H
#define TRACKSERVO_CONTROL_SETPOINT_MODEL_H

#include "base/status.h"

#define SETPOINT_MODEL_LOWEST_RAD_S 100.0f
#define SETPOINT_MODEL_HIGHEST_RAD_S 1000.0f

/* All 0: no model, the set-point passes unchanged. */
typedef struct {
  float decay;      /* d, 0 .. 1 */
  float gain_per_s; /* g */
} setpoint_model_params;

typedef struct {
  float rate_rad_s;      /* y */
  float catch_up_rad_s2; /* p, negative while y rises beyond its announced acceleration */
} setpoint_model_state;

typedef struct {
  float rate_rad_s;
  float acceleration_rad_s2; /* over the coming tick; 0 when unknown */
} speed_reference;

/* Designs the model: natural frequency 0 (off) or SETPOINT_MODEL_LOWEST_RAD_S .. SETPOINT_MODEL_HIGHEST_RAD_S. On an
 * error `*params` is left unchanged. */
control_status setpoint_model_design(setpoint_model_params *params, float frequency_rad_s, float dt_s);

control_status setpoint_model_check(const setpoint_model_params *params, float dt_s);

/* Starts at this rate, without acceleration. */
static inline void setpoint_model_reset(setpoint_model_state *state, float rate_rad_s) {
  state->rate_rad_s = rate_rad_s;
  state->catch_up_rad_s2 = 0.0f;
}

/* Computes one tick; returns what the loop shall do. */
static inline speed_reference setpoint_model_step(setpoint_model_state *state, const setpoint_model_params *params,
                                                  const speed_reference *wanted, float dt_s) {
  if (params->gain_per_s == 0.0f) {
    setpoint_model_reset(state, wanted->rate_rad_s);
    return *wanted;
  }
  const float lacking_rad_s = wanted->rate_rad_s - state->rate_rad_s;
  state->catch_up_rad_s2 = params->decay * state->catch_up_rad_s2 - params->gain_per_s * lacking_rad_s;
  speed_reference shown;
  shown.rate_rad_s = state->rate_rad_s;
  shown.acceleration_rad_s2 = wanted->acceleration_rad_s2 - state->catch_up_rad_s2;
  state->rate_rad_s += dt_s * shown.acceleration_rad_s2;
  return shown;
}

#endif
