/* SPDX-License-Identifier: Apache-2.0 */
/* The speed loop of one axis: from encoder and gyro to a torque command, once per tick.
 *
 *     torque = PI(set-point, rate) + J * set-point acceleration + disturbance estimate + friction feedforward
 *
 * The set-point is what the set-point model makes of the wanted one (speed_loop_shape).
 *
 * The tick has two halves, because the outer loops run between them: `speed_loop_sense` turns samples into rates,
 * `speed_loop_control` turns a set-point into a torque. Both follow the block diagram in docs/theory.md from top to
 * bottom. Every torque already explained by friction feedforward is hidden from the disturbance observer.
 *
 * The parameters are those for the largest inertia. Where the motor turns a share of it only, PI gains, acceleration
 * feedforward and observer take the same share, so that the loop gain stays the same: speed_loop_follow. The friction
 * stays as it is. A gyro that sees only a share of the axis' rate is scaled likewise.
 *
 * Without integral gain (P controller) the integral only carries what a bumpless change or the closing of the loop left
 * in it. No error takes this away, and it would turn the axis at set-point 0, so it is forgotten. */
#ifndef TRACKSERVO_CONTROL_SPEED_LOOP_H
#define TRACKSERVO_CONTROL_SPEED_LOOP_H

#include <stdbool.h>

#include "base/scalar.h"
#include "control/biquad.h"
#include "control/disturbance_observer.h"
#include "control/friction_feedforward.h"
#include "control/pi_controller.h"
#include "control/rate_estimator.h"
#include "control/rate_fusion.h"
#include "control/setpoint_model.h"

#define SPEED_LOOP_FORGETS_PER_S 5.0f

/* Below this share a gyro's reading is no longer divided by it: it shows the axis' rate less and less, and the encoder
 * replaces it. */
#define SPEED_LOOP_MIN_GYRO_SHARE 0.1f

/* Gains follow the inertia down to this share of the largest one. */
#define SPEED_LOOP_MIN_INERTIA_SHARE 1e-3f

typedef struct {
  rate_estimator_params rate_estimator;
  rate_fusion_params rate_fusion;
  biquad_params notch;   /* on the feedback; biquad_pass() when not used */
  biquad_params lowpass; /* on the feedback; biquad_pass() when not used */
  setpoint_model_params setpoint_model;
  pi_controller_params pi;
  float acceleration_inertia_kg_m2; /* J of the acceleration feedforward, 0 .. 1e5 */
  bool observer_on;
  disturbance_observer_params observer;
  friction_feedforward_params friction;
} speed_loop_params;

/* What the angle of another joint makes of this axis. */
typedef struct {
  float inertia_share; /* of the inertia that the parameters are for, SPEED_LOOP_MIN_INERTIA_SHARE .. 1 */
  float gyro_share;    /* of the rate about the axis that its gyro measures, -1 .. 1 */
  bool gyro_below;     /* the gyro measures what carries the joint instead */
} speed_loop_pose;

/* Returns the share of the largest inertia that the gains follow. */
static inline float speed_loop_inertia_share(float inertia_kg_m2, float largest_kg_m2) {
  return scalar_clamp(inertia_kg_m2 / largest_kg_m2, SPEED_LOOP_MIN_INERTIA_SHARE, 1.0f);
}

/* The gyro's reading times `gain`, and this part of the joint's rate, are the inertial rate about the axis. */
typedef struct {
  float gain;
  float of_joint;
} speed_loop_gyro;

/* Returns the gain for a gyro that measures this share of the rate: 1 / share; below SPEED_LOOP_MIN_GYRO_SHARE it fades
 * to 0, because there it would only be noise. */
static inline float speed_loop_gyro_gain(float share) {
  const float least = SPEED_LOOP_MIN_GYRO_SHARE;
  return scalar_abs(share) >= least ? 1.0f / share : share / (least * least);
}

static inline float speed_loop_gyro_rate(const speed_loop_gyro *gyro, float reading_rad_s, float joint_rate_rad_s) {
  return gyro->gain * reading_rad_s + gyro->of_joint * joint_rate_rad_s;
}

typedef struct {
  speed_loop_pose pose; /* 1 and 1 after a reset */
  speed_loop_gyro gyro; /* of this pose */
  float carried_rad_s;  /* what others know of the base's rate about this axis, beside its own sensors; 0 if nothing */
  rate_estimator_state rate_estimator;
  rate_fusion_state rate_fusion;
  biquad_state notch;
  biquad_state lowpass;
  setpoint_model_state setpoint_model;
  pi_controller_state pi;
  disturbance_observer_state observer;
  friction_feedforward_state friction;
  float explained_nm; /* friction feedforward applied since the last tick */
} speed_loop_state;

typedef struct {
  angle_turn32 joint_angle;
  float gyro_rad_s;
  bool gyro_valid;
} speed_loop_samples;

/* All in rad/s. */
typedef struct {
  float base_rate_rad_s;  /* rate of the base */
  float joint_rate_rad_s; /* rotor relative to stator: friction acts on it */
  float rate_rad_s;       /* inertial rate before the filters, for the outer loops */
  float feedback_rad_s;   /* after notch and low-pass, for the speed controller */
} speed_loop_rates;

/* The torque that the drive can give now: minimum <= maximum. The two may have the same sign. */
typedef struct {
  float minimum_nm;
  float maximum_nm;
} torque_limits;

typedef struct {
  float torque_nm; /* the command, within the limits */
  /* its parts, for the scope */
  float pi_nm;
  float acceleration_nm;
  float disturbance_nm;
  float friction_nm;
  bool limited;
} speed_loop_output;

control_status speed_loop_check(const speed_loop_params *params, float dt_s);

/* Starts at rest at `angle`, with all estimates 0. */
void speed_loop_reset(speed_loop_state *state, const speed_loop_params *params, angle_turn32 angle, float dt_s);

/* Closes the loop in this tick on an axis that may be turning. The sensed state stays; the controller starts with no
 * torque, and the observer starts at the measured rate. Call it between `speed_loop_sense` and the first
 * `speed_loop_control`. */
void speed_loop_close(speed_loop_state *state, const speed_loop_params *params, const speed_loop_rates *rates,
                      float dt_s);

/* Changes the pose between two ticks without a torque step; `rates` and `reference` are those of the last tick. What
 * the set-point weight and a rate error let the proportional gain give moves to the integral; the observer keeps its
 * estimate. Call it before speed_loop_sense. */
void speed_loop_follow(speed_loop_state *state, const speed_loop_params *params, const speed_loop_pose *pose,
                       const speed_loop_rates *rates, const speed_reference *reference, float dt_s);

speed_loop_rates speed_loop_sense(speed_loop_state *state, const speed_loop_params *params,
                                  const speed_loop_samples *samples, float dt_s);

/* Returns the set-point for `speed_loop_control`, from the wanted one: a jump becomes a motion that the axis can
 * follow. */
static inline speed_reference speed_loop_shape(speed_loop_state *state, const speed_loop_params *params,
                                               const speed_reference *wanted, float dt_s) {
  return setpoint_model_step(&state->setpoint_model, &params->setpoint_model, wanted, dt_s);
}

/* Lets the set-point start at this rate. Call it in a tick in which the loop is closed and nothing is wanted of it. */
static inline void speed_loop_let_follow(speed_loop_state *state, float rate_rad_s) {
  setpoint_model_reset(&state->setpoint_model, rate_rad_s);
}

/* Runs the control. `applied_nm` is the torque that the motor gave since the last tick: the last command, or as much of
 * it as the current loop could apply. */
speed_loop_output speed_loop_control(speed_loop_state *state, const speed_loop_params *params,
                                     const speed_loop_rates *rates, const speed_reference *reference, float applied_nm,
                                     const torque_limits *limits, float dt_s);

/* Changes a running loop from one set of parameters to another without a torque step. Call it once, with the inputs of
 * the last tick, before the next `speed_loop_control` with `to`. The estimates carry over. A change in friction
 * feedforward moves to the observer; the remaining difference of the two sets in that tick moves to the integral. Both
 * sets must have passed `speed_loop_check`. */
void speed_loop_retune(speed_loop_state *state, const speed_loop_params *from, const speed_loop_params *to,
                       const speed_loop_rates *rates, const speed_reference *reference, float applied_nm, float dt_s);

/* Closes a running loop again with other parameters. Call it instead of speed_loop_retune when the estimates of the old
 * ones are useless. `rates` are those of the last tick, `holding_nm` is the torque at zero rate error. */
void speed_loop_restart(speed_loop_state *state, const speed_loop_params *params, const speed_loop_rates *rates,
                        float holding_nm, float dt_s);

#endif
