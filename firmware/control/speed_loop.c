/* SPDX-License-Identifier: Apache-2.0 */
#include "control/speed_loop.h"

#include <float.h>

#include "base/scalar.h"

control_status speed_loop_check(const speed_loop_params *params, float dt_s) {
  const scalar_range inertia = {params->acceleration_inertia_kg_m2, 0.0f, 1e5f};
  const control_status parts[] = {
      rate_estimator_check(&params->rate_estimator),
      rate_fusion_check(&params->rate_fusion),
      biquad_check(&params->notch),
      biquad_check(&params->lowpass),
      setpoint_model_check(&params->setpoint_model, dt_s),
      pi_controller_check(&params->pi, dt_s),
      scalar_check_ranges(&inertia, 1),
      disturbance_observer_check(&params->observer, dt_s),
      friction_feedforward_check(&params->friction),
  };
  for (unsigned i = 0; i < sizeof parts / sizeof parts[0]; ++i) {
    if (parts[i] != CONTROL_OK) {
      return parts[i];
    }
  }
  return CONTROL_OK;
}

/* Gains for a share of the inertia. */
static float proportional_nm(const speed_loop_params *params, float share, float reference_rad_s, float rate_rad_s) {
  return share * params->pi.proportional_gain * (params->pi.setpoint_weight * reference_rad_s - rate_rad_s);
}

static disturbance_observer_params observer_for(const speed_loop_params *params, float share) {
  disturbance_observer_params observer = params->observer;
  observer.inertia_kg_m2 *= share;
  return observer;
}

/* The inertial rate about the axis, of which the gyro measures a share, or all but the joint's part. What the joint
 * adds is known from the encoder, also where the share is too small to divide by it. */
static speed_loop_gyro scale_gyro(const speed_loop_pose *pose) {
  if (pose->gyro_below) {
    return (speed_loop_gyro){.gain = 1.0f, .of_joint = 1.0f};
  }
  const float share = pose->gyro_share;
  const float gain = speed_loop_gyro_gain(share);
  return (speed_loop_gyro){.gain = gain, .of_joint = 1.0f - gain * share};
}

void speed_loop_reset(speed_loop_state *state, const speed_loop_params *params, angle_turn32 angle, float dt_s) {
  state->pose = (speed_loop_pose){.inertia_share = 1.0f, .gyro_share = 1.0f};
  state->gyro = scale_gyro(&state->pose);
  state->carried_rad_s = 0.0f;
  rate_estimator_reset(&state->rate_estimator, angle);
  rate_fusion_reset(&state->rate_fusion);
  biquad_reset(&state->notch, &params->notch, 0.0f);
  biquad_reset(&state->lowpass, &params->lowpass, 0.0f);
  speed_loop_close(state, params, &(speed_loop_rates){0}, dt_s);
}

void speed_loop_close(speed_loop_state *state, const speed_loop_params *params, const speed_loop_rates *rates,
                      float dt_s) {
  const float rate_rad_s = rates->feedback_rad_s;
  /* Without a rate error no torque, whatever the set-point weight is. */
  pi_controller_reset(&state->pi, -proportional_nm(params, state->pose.inertia_share, rate_rad_s, rate_rad_s));
  const disturbance_observer_params observer = observer_for(params, state->pose.inertia_share);
  disturbance_observer_reset(&state->observer, &observer, rate_rad_s, dt_s);
  friction_feedforward_reset(&state->friction);
  setpoint_model_reset(&state->setpoint_model, rate_rad_s);
  state->explained_nm = 0.0f;
}

void speed_loop_follow(speed_loop_state *state, const speed_loop_params *params, const speed_loop_pose *pose,
                       const speed_loop_rates *rates, const speed_reference *reference, float dt_s) {
  const float before = state->pose.inertia_share;
  const float share = pose->inertia_share;
  if (pose->gyro_share != state->pose.gyro_share || pose->gyro_below != state->pose.gyro_below) {
    state->gyro = scale_gyro(pose);
  }
  state->pose = *pose;
  if (share == before) {
    return;
  }
  const float rate_rad_s = rates->feedback_rad_s;
  state->pi.integral += proportional_nm(params, before - share, reference->rate_rad_s, rate_rad_s);
  disturbance_observer_follow(&state->observer, &params->observer, share * params->observer.inertia_kg_m2, rate_rad_s,
                              dt_s);
}

speed_loop_rates speed_loop_sense(speed_loop_state *state, const speed_loop_params *params,
                                  const speed_loop_samples *samples, float dt_s) {
  const float joint_rate_rad_s =
      rate_estimator_step(&state->rate_estimator, &params->rate_estimator, samples->joint_angle, dt_s);
  const float gyro_rad_s = speed_loop_gyro_rate(&state->gyro, samples->gyro_rad_s, joint_rate_rad_s);
  const rate_fusion_output fused = rate_fusion_step(&state->rate_fusion, &params->rate_fusion, gyro_rad_s,
                                                    samples->gyro_valid, joint_rate_rad_s, state->carried_rad_s, dt_s);
  const float notched_rad_s = biquad_step(&state->notch, &params->notch, fused.rate_rad_s);
  return (speed_loop_rates){
      .joint_rate_rad_s = joint_rate_rad_s,
      .base_rate_rad_s = fused.base_rate_rad_s,
      .rate_rad_s = fused.rate_rad_s,
      .feedback_rad_s = biquad_step(&state->lowpass, &params->lowpass, notched_rad_s),
  };
}

speed_loop_output speed_loop_control(speed_loop_state *state, const speed_loop_params *params,
                                     const speed_loop_rates *rates, const speed_reference *reference, float applied_nm,
                                     const torque_limits *limits, float dt_s) {
  const float feedback_rad_s = rates->feedback_rad_s;

  /* The residual load: the part of the applied torque that the friction already fed forward does not explain. */
  const float observed_nm =
      disturbance_observer_step(&state->observer, &params->observer, feedback_rad_s, applied_nm - state->explained_nm);
  const friction_feedforward_input intended = {
      .reference_rad_s = reference->rate_rad_s,
      .base_rate_rad_s = rates->base_rate_rad_s,
      .joint_rate_rad_s = rates->joint_rate_rad_s,
  };

  /* A share of the rates has the effect of that share of the PI's gains. */
  const float share = state->pose.inertia_share;
  const float pi_reference_rad_s = share * reference->rate_rad_s;
  const float pi_feedback_rad_s = share * feedback_rad_s;

  speed_loop_output out;
  out.pi_nm = pi_controller_propose(&state->pi, &params->pi, pi_reference_rad_s, pi_feedback_rad_s);
  out.acceleration_nm = share * params->acceleration_inertia_kg_m2 * reference->acceleration_rad_s2;
  out.disturbance_nm = params->observer_on ? observed_nm : 0.0f;
  out.friction_nm = friction_feedforward_step(&state->friction, &params->friction, &intended, dt_s);

  const float wanted_nm = out.pi_nm + out.acceleration_nm + out.disturbance_nm + out.friction_nm;
  out.torque_nm = scalar_clamp(wanted_nm, limits->minimum_nm, limits->maximum_nm);
  const float excess_nm = out.torque_nm - wanted_nm;
  out.limited = excess_nm != 0.0f;

  pi_controller_settle(&state->pi, &params->pi, pi_reference_rad_s - pi_feedback_rad_s, excess_nm, dt_s);
  if (params->pi.integral_gain == 0.0f) {
    state->pi.integral -= SPEED_LOOP_FORGETS_PER_S * dt_s * state->pi.integral;
  }
  state->explained_nm = out.friction_nm;
  return out;
}

/* The command of one tick without limits; works on a copy of the state. */
static speed_loop_output unlimited(speed_loop_state state, const speed_loop_params *params,
                                   const speed_loop_rates *rates, const speed_reference *reference, float applied_nm,
                                   float dt_s) {
  const torque_limits none = {.minimum_nm = -FLT_MAX, .maximum_nm = FLT_MAX};
  return speed_loop_control(&state, params, rates, reference, applied_nm, &none, dt_s);
}

/* Bristles keep their torque, the observer keeps its estimate, the filters keep their settled output. */
static speed_loop_state carried_over(const speed_loop_state *state, const speed_loop_params *from,
                                     const speed_loop_params *to, const speed_loop_rates *rates, float dt_s) {
  speed_loop_state next = *state;
  if (from->rate_fusion.source != to->rate_fusion.source) {
    next.carried_rad_s = 0.0f; /* what the old sensors lacked */
  }
  friction_feedforward_retune(&next.friction, &from->friction, &to->friction, rates->joint_rate_rad_s);
  const disturbance_observer_params observer = observer_for(to, state->pose.inertia_share);
  disturbance_observer_retune(&next.observer, &observer, rates->feedback_rad_s, dt_s);
  biquad_reset(&next.notch, &to->notch, rates->rate_rad_s);
  biquad_reset(&next.lowpass, &to->lowpass, rates->rate_rad_s);
  return next;
}

/* Friction that the feedforward no longer compensates becomes load for the observer, and vice versa. Without this the
 * observer would find it only from a rate error. */
static void hand_to_observer(speed_loop_state *state, const speed_loop_params *params, float friction_nm,
                             const speed_loop_rates *rates, float dt_s) {
  state->explained_nm -= friction_nm;
  state->observer.estimate_nm += friction_nm;
  const disturbance_observer_params observer = observer_for(params, state->pose.inertia_share);
  disturbance_observer_retune(&state->observer, &observer, rates->feedback_rad_s, dt_s);
}

void speed_loop_retune(speed_loop_state *state, const speed_loop_params *from, const speed_loop_params *to,
                       const speed_loop_rates *rates, const speed_reference *reference, float applied_nm, float dt_s) {
  const speed_loop_output before = unlimited(*state, from, rates, reference, applied_nm, dt_s);
  *state = carried_over(state, from, to, rates, dt_s);
  const float friction_nm = unlimited(*state, to, rates, reference, applied_nm, dt_s).friction_nm;
  hand_to_observer(state, to, before.friction_nm - friction_nm, rates, dt_s);
  state->pi.integral += before.torque_nm - unlimited(*state, to, rates, reference, applied_nm, dt_s).torque_nm;
}

void speed_loop_restart(speed_loop_state *state, const speed_loop_params *params, const speed_loop_rates *rates,
                        float holding_nm, float dt_s) {
  biquad_reset(&state->notch, &params->notch, rates->rate_rad_s);
  biquad_reset(&state->lowpass, &params->lowpass, rates->rate_rad_s);
  speed_loop_rates unfiltered = *rates;
  unfiltered.feedback_rad_s = rates->rate_rad_s;
  speed_loop_close(state, params, &unfiltered, dt_s);
  state->pi.integral += holding_nm;
}
