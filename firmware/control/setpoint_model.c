/* SPDX-License-Identifier: Apache-2.0 */
#include "control/setpoint_model.h"

#include "base/scalar.h"

control_status setpoint_model_check(const setpoint_model_params *params, float dt_s) {
  const scalar_range ranges[] = {
      {params->decay, 0.0f, 1.0f},
      {params->gain_per_s * dt_s, 0.0f, 1.0f},
  };
  return scalar_check_ranges(ranges, sizeof ranges / sizeof ranges[0]);
}

control_status setpoint_model_design(setpoint_model_params *params, float frequency_rad_s, float dt_s) {
  if (frequency_rad_s == 0.0f) {
    *params = (setpoint_model_params){.decay = 0.0f, .gain_per_s = 0.0f};
    return CONTROL_OK;
  }
  const scalar_range range = {frequency_rad_s, SETPOINT_MODEL_LOWEST_RAD_S, SETPOINT_MODEL_HIGHEST_RAD_S};
  const control_status status = scalar_check_ranges(&range, 1);
  if (status != CONTROL_OK) {
    return status;
  }
  const float pole = scalar_exp_minus(frequency_rad_s * dt_s);
  const float moved = 1.0f - pole;
  *params = (setpoint_model_params){.decay = pole * pole, .gain_per_s = moved * moved / dt_s};
  return CONTROL_OK;
}
