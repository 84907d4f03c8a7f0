/* SPDX-License-Identifier: Apache-2.0 */
/* PI controller with set-point weight and back-calculation anti-windup (Astrom & Hagglund, Advanced PID Control).
 *
 *     u = kp (b r - y) + i,   di/dt = ki (r - y) + w_t (u_limited - u)
 *
 * The output is summed with other torques before it is limited, so a tick has two halves: `propose` computes the
 * output, then `settle` corrects the integral by what the limit took away. Unit-neutral: in the speed loop Nm from
 * rad/s, in the current loop V from A. */
#ifndef TRACKSERVO_CONTROL_PI_CONTROLLER_H
#define TRACKSERVO_CONTROL_PI_CONTROLLER_H

#include "base/status.h"

typedef struct {
  float proportional_gain;   /* kp, output unit / input unit, 0 .. 1e6 */
  float integral_gain;       /* ki, output unit / (input unit s), 0 .. 1e8 */
  float setpoint_weight;     /* b, 0 .. 1 */
  float tracking_rate_per_s; /* w_t, 0 .. 1/dt; how fast the integral leaves a limit; ki/kp is a good value */
} pi_controller_params;

typedef struct {
  float integral; /* i, in the output's unit */
} pi_controller_state;

control_status pi_controller_check(const pi_controller_params *params, float dt_s);

/* Starts with `integral` as the output at zero error, e.g. the holding torque, for a bumpless start. */
void pi_controller_reset(pi_controller_state *state, float integral);

/* Returns the output of this tick before any limit. */
static inline float pi_controller_propose(const pi_controller_state *state, const pi_controller_params *params,
                                          float reference, float measured) {
  return params->proportional_gain * (params->setpoint_weight * reference - measured) + state->integral;
}

/* Ends the tick: `excess` = limited - unlimited sum, 0 when no limit was met. */
static inline void pi_controller_settle(pi_controller_state *state, const pi_controller_params *params, float error,
                                        float excess, float dt_s) {
  state->integral += dt_s * (params->integral_gain * error + params->tracking_rate_per_s * excess);
}

#endif
