#include "control/disturbance_observer.h"

#include "control/scalar.h"

control_status disturbance_observer_check(const disturbance_observer_params *params, float dt_s) {
  const scalar_range ranges[] = {
      {params->inertia_kg_m2, 1e-9f, 1e5f},         {params->viscous_nm_s_rad, 0.0f, 1e4f},
      {params->bandwidth_rad_s, 0.01f, 2e3f},       {params->limit_nm, 0.0f, 1e4f},
      {params->bandwidth_rad_s * dt_s, 0.0f, 1.0f},
  };
  return scalar_check_ranges(ranges, 5);
}

/* Exact pole of Q for the tick: 1 - exp(-w dt). */
static float blend_of(const disturbance_observer_params *params, float dt_s) {
  return 1.0f - scalar_exp_minus(params->bandwidth_rad_s * dt_s);
}

static void predict(disturbance_observer_state *state, const disturbance_observer_params *params, float auxiliary_nm,
                    float blend, float momentum_gain, float rate_rad_s) {
  state->prediction_nm =
      (1.0f - blend) * auxiliary_nm + blend * (momentum_gain - params->viscous_nm_s_rad) * rate_rad_s;
}

void disturbance_observer_reset(disturbance_observer_state *state, const disturbance_observer_params *params,
                                float rate_rad_s, float dt_s) {
  state->estimate_nm = 0.0f;
  disturbance_observer_retune(state, params, rate_rad_s, dt_s);
}

void disturbance_observer_retune(disturbance_observer_state *state, const disturbance_observer_params *params,
                                 float rate_rad_s, float dt_s) {
  const float blend = blend_of(params, dt_s);
  const float momentum_gain = blend * params->inertia_kg_m2 / dt_s;
  predict(state, params, state->estimate_nm + momentum_gain * rate_rad_s, blend, momentum_gain, rate_rad_s);
}

float disturbance_observer_step(disturbance_observer_state *state, const disturbance_observer_params *params,
                                float rate_rad_s, float torque_nm, float dt_s) {
  const float blend = blend_of(params, dt_s);
  const float momentum_gain = blend * params->inertia_kg_m2 / dt_s; /* the discrete w J */
  const float auxiliary_nm = state->prediction_nm + blend * torque_nm;
  state->estimate_nm = auxiliary_nm - momentum_gain * rate_rad_s;
  predict(state, params, auxiliary_nm, blend, momentum_gain, rate_rad_s);
  return scalar_clamp(state->estimate_nm, -params->limit_nm, params->limit_nm);
}
