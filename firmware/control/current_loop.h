/* SPDX-License-Identifier: Apache-2.0 */
/* Current loop of one DC torque motor, at the PWM rate (20 kHz).
 *
 *     v = kp (i_ref - i) + integral + Ke w,   integral' = ki (i_ref - i)
 *
 * Pole-zero cancelling PI: kp = w_c L, ki = w_c R gives a first-order response of bandwidth w_c. The voltage is limited
 * to what the bus can supply now; back-calculation keeps the integral consistent with that limit. */
#ifndef TRACKSERVO_CONTROL_CURRENT_LOOP_H
#define TRACKSERVO_CONTROL_CURRENT_LOOP_H

#include <stdbool.h>

#include "control/pi_controller.h"

typedef struct {
  pi_controller_params pi; /* V from A */
  float back_emf_v_s_rad;  /* Ke, 0 .. 1e3 */
  float duty_limit;        /* largest |duty|, 0.01 .. 1 */
} current_loop_params;

typedef struct {
  pi_controller_state pi;
  bool limited;    /* the bus could not supply the required voltage in the last period */
  float voltage_v; /* mean voltage applied over the last period; 0 after a reset */
} current_loop_state;

/* Designs the gains for a bandwidth (rad/s) with a winding of R (1e-4 .. 1e3 ohm) and L (1e-7 .. 10 H) at PWM period
 * dt_s; bandwidth * dt_s <= 0.8. Sets all of `*params`, or nothing when a value is out of range. */
control_status current_loop_design(current_loop_params *params, float resistance_ohm, float inductance_h,
                                   float back_emf_v_s_rad, float bandwidth_rad_s, float dt_s);

control_status current_loop_check(const current_loop_params *params, float dt_s);
void current_loop_reset(current_loop_state *state);

/* Computes one PWM period. Returns the duty, within +-duty_limit; 0 when the bus is below 1 V. `joint_rate_rad_s` gives
 * the back-EMF. */
float current_loop_step(current_loop_state *state, const current_loop_params *params, float reference_a,
                        float measured_a, float joint_rate_rad_s, float bus_voltage_v, float dt_s);

#endif
