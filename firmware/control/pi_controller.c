/* SPDX-License-Identifier: Apache-2.0 */
#include "control/pi_controller.h"

#include "base/scalar.h"

control_status pi_controller_check(const pi_controller_params *params, float dt_s) {
  const scalar_range ranges[] = {
      {params->proportional_gain, 0.0f, 1e6f},
      {params->integral_gain, 0.0f, 1e8f},
      {params->setpoint_weight, 0.0f, 1.0f},
      {params->tracking_rate_per_s * dt_s, 0.0f, 1.0f},
  };
  return scalar_check_ranges(ranges, 4);
}

void pi_controller_reset(pi_controller_state *state, float integral) { state->integral = integral; }
