/* SPDX-License-Identifier: Apache-2.0 */
#include "control/friction_feedforward.h"

#include <stdbool.h>

#include "base/scalar.h"

control_status friction_feedforward_check(const friction_feedforward_params *params) {
  if ((unsigned)params->model > (unsigned)FRICTION_LUGRE) {
    return CONTROL_OUT_OF_RANGE;
  }
  const scalar_range ranges[] = {
      {params->gain, 0.0f, 1.5f},
      {params->lead_limit_rad_s, 1e-6f, 1e2f},
      {params->sign_width_rad_s, 1e-6f, 1.0f},
  };
  const control_status status = scalar_check_ranges(ranges, 3);
  return status == CONTROL_OK ? lugre_check(&params->lugre) : status;
}

void friction_feedforward_reset(friction_feedforward_state *state) { lugre_reset(&state->lugre); }

void friction_feedforward_retune(friction_feedforward_state *state, const friction_feedforward_params *from,
                                 const friction_feedforward_params *to, float joint_rate_rad_s) {
  if (from->model == FRICTION_LUGRE) {
    state->lugre.deflection_rad *= from->lugre.stiffness_nm_rad / to->lugre.stiffness_nm_rad;
    return;
  }
  const lugre_direction *direction = joint_rate_rad_s >= 0.0f ? &to->lugre.positive : &to->lugre.negative;
  const bool slides = scalar_abs(joint_rate_rad_s) > direction->stribeck_speed_rad_s;
  lugre_settle(&state->lugre, &to->lugre, slides ? joint_rate_rad_s : 0.0f);
}

float friction_feedforward_rate(const friction_feedforward_params *params, const friction_feedforward_input *input) {
  const float lead_rad_s = input->reference_rad_s - input->base_rate_rad_s - input->joint_rate_rad_s;
  return input->joint_rate_rad_s + scalar_clamp(lead_rad_s, -params->lead_limit_rad_s, params->lead_limit_rad_s);
}

static float memoryless_nm(const friction_feedforward_params *params, float rate_rad_s) {
  const lugre_direction *direction = rate_rad_s >= 0.0f ? &params->lugre.positive : &params->lugre.negative;
  const float sign = scalar_clamp(rate_rad_s / params->sign_width_rad_s, -1.0f, 1.0f);
  const float level_nm =
      params->model == FRICTION_STEADY ? lugre_stribeck_nm(direction, rate_rad_s) : direction->coulomb_nm;
  return sign * level_nm + direction->viscous_nm_s_rad * rate_rad_s;
}

float friction_feedforward_step(friction_feedforward_state *state, const friction_feedforward_params *params,
                                const friction_feedforward_input *input, float dt_s) {
  if (params->model == FRICTION_NONE) {
    return 0.0f;
  }
  const float rate_rad_s = friction_feedforward_rate(params, input);
  const float torque_nm = params->model == FRICTION_LUGRE ? lugre_step(&state->lugre, &params->lugre, rate_rad_s, dt_s)
                                                          : memoryless_nm(params, rate_rad_s);
  return params->gain * torque_nm;
}
