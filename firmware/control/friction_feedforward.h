/* SPDX-License-Identifier: Apache-2.0 */
/* Friction feedforward: adds the expected seal friction to the torque before a rate error shows it.
 *
 * The friction model runs on the *intended joint rate*: the inertial rate set-point less the base's own rate.
 * So start-up and reversal are compensated in the tick that commands them, and sensor noise does not reach the model at
 * standstill. While the axis cannot follow (end stop, torque limit) the model must not run ahead, so the intended rate
 * is kept within `lead_limit_rad_s` of the measured joint rate.
 *
 * In the tick: after the estimate, before the speed controller; its torque is added to the command and taken out
 * of what the disturbance observer sees, so that nothing is compensated twice. */
#ifndef TRACKSERVO_CONTROL_FRICTION_FEEDFORWARD_H
#define TRACKSERVO_CONTROL_FRICTION_FEEDFORWARD_H

#include "control/lugre.h"

typedef enum {
  FRICTION_NONE = 0,
  FRICTION_COULOMB, /* Tc sign(v) + s2 v: the model of most drives */
  FRICTION_STEADY,  /* eq. (5): adds the Stribeck effect, no memory */
  FRICTION_LUGRE    /* eqs (1)-(3) */
} friction_model;

typedef struct {
  friction_model model;
  float gain;             /* blend, 0 .. 1.5; 1 gives the whole model torque */
  float lead_limit_rad_s; /* 1e-6 .. 1e2; largest difference between intended and measured joint rate; choose it well
                             above the noise of that rate */
  float sign_width_rad_s; /* 1e-6 .. 1; sign(v) of the memoryless models is linear within this rate */
  lugre_params lugre;
} friction_feedforward_params;

typedef struct {
  lugre_state lugre;
} friction_feedforward_state;

/* Inputs of one tick, all in rad/s. */
typedef struct {
  float reference_rad_s;  /* inertial rate set-point */
  float base_rate_rad_s;  /* inertial rate of the base; 0 where only an encoder is fitted */
  float joint_rate_rad_s; /* measured rate of the rotor relative to the seal */
} friction_feedforward_input;

control_status friction_feedforward_check(const friction_feedforward_params *params);
void friction_feedforward_reset(friction_feedforward_state *state);

/* Changes the parameters; the bristles keep their torque. If the old model had no bristles, they start as in sliding at
 * `joint_rate_rad_s` when that is above the Stribeck rate. Below it the direction is uncertain and they start
 * relaxed. */
void friction_feedforward_retune(friction_feedforward_state *state, const friction_feedforward_params *from,
                                 const friction_feedforward_params *to, float joint_rate_rad_s);

/* Returns the rate that drives the model: set-point minus base rate, kept near the measured joint rate. */
float friction_feedforward_rate(const friction_feedforward_params *params, const friction_feedforward_input *input);

/* Computes one tick; returns the compensating torque in Nm, with the sign of the motor torque. */
float friction_feedforward_step(friction_feedforward_state *state, const friction_feedforward_params *params,
                                const friction_feedforward_input *input, float dt_s);

#endif
