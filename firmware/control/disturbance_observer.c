/* SPDX-License-Identifier: Apache-2.0 */
#include "control/disturbance_observer.h"

#include "base/scalar.h"

control_status disturbance_observer_check(const disturbance_observer_params *params, float dt_s) {
  const scalar_range ranges[] = {
      {params->inertia_kg_m2, 1e-9f, 1e5f},         {params->viscous_nm_s_rad, 0.0f, 1e4f},
      {params->bandwidth_rad_s, 0.01f, 1e3f},       {params->limit_nm, 0.0f, 1e4f},
      {params->bandwidth_rad_s * dt_s, 0.0f, 1.0f},
  };
  return scalar_check_ranges(ranges, 5);
}

static void predict(disturbance_observer_state *state, float auxiliary_nm, float rate_rad_s) {
  state->prediction_nm = (1.0f - state->blend) * auxiliary_nm + state->prediction_nm_s_rad * rate_rad_s;
}

void disturbance_observer_reset(disturbance_observer_state *state, const disturbance_observer_params *params,
                                float rate_rad_s, float dt_s) {
  state->estimate_nm = 0.0f;
  disturbance_observer_retune(state, params, rate_rad_s, dt_s);
}

void disturbance_observer_retune(disturbance_observer_state *state, const disturbance_observer_params *params,
                                 float rate_rad_s, float dt_s) {
  state->blend = 1.0f - scalar_exp_minus(params->bandwidth_rad_s * dt_s);
  disturbance_observer_follow(state, params, params->inertia_kg_m2, rate_rad_s, dt_s);
}

void disturbance_observer_follow(disturbance_observer_state *state, const disturbance_observer_params *params,
                                 float inertia_kg_m2, float rate_rad_s, float dt_s) {
  state->momentum_nm_s_rad = state->blend * inertia_kg_m2 / dt_s;
  state->prediction_nm_s_rad = state->blend * (state->momentum_nm_s_rad - params->viscous_nm_s_rad);
  predict(state, state->estimate_nm + state->momentum_nm_s_rad * rate_rad_s, rate_rad_s);
}

float disturbance_observer_step(disturbance_observer_state *state, const disturbance_observer_params *params,
                                float rate_rad_s, float torque_nm) {
  const float auxiliary_nm = state->prediction_nm + state->blend * torque_nm;
  state->estimate_nm = auxiliary_nm - state->momentum_nm_s_rad * rate_rad_s;
  predict(state, auxiliary_nm, rate_rad_s);
  return scalar_clamp(state->estimate_nm, -params->limit_nm, params->limit_nm);
}
