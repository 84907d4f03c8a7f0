/* SPDX-License-Identifier: Apache-2.0 */
#include "control/current_loop.h"

#include "base/scalar.h"

control_status current_loop_design(current_loop_params *params, float resistance_ohm, float inductance_h,
                                   float back_emf_v_s_rad, float bandwidth_rad_s, float dt_s) {
  const scalar_range ranges[] = {
      {resistance_ohm, 1e-4f, 1e3f},
      {inductance_h, 1e-7f, 10.0f},
      {bandwidth_rad_s * dt_s, 1e-4f, 0.8f},
  };
  const control_status status = scalar_check_ranges(ranges, 3);
  if (status != CONTROL_OK) {
    return status;
  }
  const current_loop_params designed = {
      .pi = {.proportional_gain = bandwidth_rad_s * inductance_h,
             .integral_gain = bandwidth_rad_s * resistance_ohm,
             .setpoint_weight = 1.0f,
             .tracking_rate_per_s = scalar_min(resistance_ohm / inductance_h, 0.5f / dt_s)},
      .back_emf_v_s_rad = back_emf_v_s_rad,
      .duty_limit = 0.98f,
  };
  const control_status check = current_loop_check(&designed, dt_s);
  if (check == CONTROL_OK) {
    *params = designed;
  }
  return check;
}

control_status current_loop_check(const current_loop_params *params, float dt_s) {
  const scalar_range ranges[] = {
      {params->back_emf_v_s_rad, 0.0f, 1e3f},
      {params->duty_limit, 0.01f, 1.0f},
  };
  const control_status status = pi_controller_check(&params->pi, dt_s);
  return status == CONTROL_OK ? scalar_check_ranges(ranges, 2) : status;
}

void current_loop_reset(current_loop_state *state) {
  pi_controller_reset(&state->pi, 0.0f);
  state->limited = false;
  state->voltage_v = 0.0f;
}

float current_loop_step(current_loop_state *state, const current_loop_params *params, float reference_a,
                        float measured_a, float joint_rate_rad_s, float bus_voltage_v, float dt_s) {
  const float lowest_useful_bus_v = 1.0f;
  if (bus_voltage_v < lowest_useful_bus_v) {
    current_loop_reset(state);
    state->limited = true;
    return 0.0f;
  }
  const float wanted_v = pi_controller_propose(&state->pi, &params->pi, reference_a, measured_a) +
                         params->back_emf_v_s_rad * joint_rate_rad_s;
  const float largest_v = params->duty_limit * bus_voltage_v;
  const float voltage_v = scalar_clamp(wanted_v, -largest_v, largest_v);
  pi_controller_settle(&state->pi, &params->pi, reference_a - measured_a, voltage_v - wanted_v, dt_s);
  state->limited = voltage_v != wanted_v;
  state->voltage_v = voltage_v;
  /* Limit again: the division rounds. */
  return scalar_clamp(voltage_v / bus_voltage_v, -params->duty_limit, params->duty_limit);
}
