/* SPDX-License-Identifier: Apache-2.0 */
#include "servo/servo_axis.h"

#include <math.h>
#include <stddef.h>

#include "base/scalar.h"

control_status servo_axis_check(const servo_axis_params *params, float tick_s, float pwm_period_s) {
  const scalar_range ranges[] = {
      {params->torque_constant_nm_a, 1e-6f, 1e4f},  {params->current_limit_a, 0.0f, 1e4f},
      {params->plant_inertia_kg_m2, 1e-9f, 1e5f},   {params->min_inertia_kg_m2, 1e-9f, 1e5f},
      {params->plant_viscous_nm_s_rad, 0.0f, 1e4f}, {params->plant_stiffness_nm_rad, 0.0f, 1e9f},
      {params->plant_damping_nm_s_rad, 0.0f, 1e6f},
  };
  if ((unsigned)params->gyro > (unsigned)GYRO_BELOW_JOINT) {
    return CONTROL_OUT_OF_RANGE;
  }
  const control_status parts[] = {
      speed_loop_check(&params->speed, tick_s),
      position_loop_check(&params->position),
      target_tracker_check(&params->tracker),
      current_loop_check(&params->current, pwm_period_s),
      scalar_check_ranges(ranges, sizeof ranges / sizeof ranges[0]),
  };
  for (unsigned i = 0; i < sizeof parts / sizeof parts[0]; ++i) {
    if (parts[i] != CONTROL_OK) {
      return parts[i];
    }
  }
  return CONTROL_OK;
}

void servo_axis_reset(servo_axis *axis, const servo_axis_params *params, angle_turn32 angle, float tick_s) {
  *axis = (servo_axis){.mode = SERVO_OFF, .last_angle = angle};
  speed_loop_reset(&axis->speed, &params->speed, angle, tick_s);
  axis->pose = axis->speed.pose;
}

static bool samples_are_plausible(const hal_axis_samples *sensors) {
  return !sensors->encoder_failed && scalar_within(sensors->mean_current_a, SERVO_PLAUSIBLE_CURRENT_A) &&
         (!sensors->gyro_valid || scalar_within(sensors->gyro_rad_s, SERVO_PLAUSIBLE_RATE_RAD_S));
}

/* No axis turns this far in a tick; after a gap in the samples the rate is unknown. */
static bool angle_is_plausible(const servo_axis *axis, angle_turn32 angle, float tick_s) {
  const float step_rad = angle_difference_rad(angle, axis->last_angle);
  return axis->implausible || scalar_within(step_rad, SERVO_PLAUSIBLE_RATE_RAD_S * tick_s);
}

static bool command_is_plausible(const servo_axis_command *command) {
  const bool limits_plausible = scalar_within(command->limits.minimum_nm, SERVO_PLAUSIBLE_TORQUE_NM) &&
                                scalar_within(command->limits.maximum_nm, SERVO_PLAUSIBLE_TORQUE_NM);
  return (unsigned)command->mode <= (unsigned)SERVO_PROTECTIVE_STOP &&
         scalar_within(command->speed.rate_rad_s, SERVO_PLAUSIBLE_RATE_RAD_S) &&
         scalar_within(command->speed.acceleration_rad_s2, SERVO_PLAUSIBLE_ACCELERATION_RAD_S2) &&
         scalar_within(command->rate_limit_rad_s, SERVO_PLAUSIBLE_RATE_RAD_S) && command->rate_limit_rad_s >= 0.0f &&
         scalar_within(command->torque_nm, SERVO_PLAUSIBLE_TORQUE_NM) && (limits_plausible || !command->torque_limited);
}

static speed_reference position_reference(const servo_axis_params *params, const servo_axis_command *command,
                                          angle_turn32 joint_angle) {
  const float rate_rad_s =
      position_loop_rate(&params->position, command->position, joint_angle, command->speed.rate_rad_s);
  const float limit_rad_s = command->rate_limit_rad_s > 0.0f ? command->rate_limit_rad_s : SERVO_PLAUSIBLE_RATE_RAD_S;
  return (speed_reference){.rate_rad_s = scalar_clamp(rate_rad_s, -limit_rad_s, limit_rad_s),
                           .acceleration_rad_s2 = command->speed.acceleration_rad_s2};
}

/* What the speed loop shall do in this tick. */
static speed_reference choose_reference(servo_axis *axis, const servo_axis_params *params,
                                        const servo_axis_command *command, const servo_axis_samples *samples,
                                        const speed_loop_rates *rates, float tick_s) {
  if (axis->mode == SERVO_TORQUE) { /* no error: the integral of the speed loop follows the applied torque */
    speed_loop_let_follow(&axis->speed, rates->feedback_rad_s);
    return (speed_reference){.rate_rad_s = rates->feedback_rad_s};
  }
  if (!servo_mode_closes(axis->mode)) {
    return (speed_reference){0};
  }
  const bool holds_position = axis->mode == SERVO_POSITION;
  const speed_reference wanted =
      holds_position ? position_reference(params, command, samples->sensors.joint_angle_turn32) : command->speed;
  speed_reference reference = speed_loop_shape(&axis->speed, &params->speed, &wanted, tick_s);
  if (holds_position) { /* the joint's: what others know of the base's rate is no part of it */
    reference.rate_rad_s += axis->speed.carried_rad_s;
  }
  return reference;
}

static void open_loops(servo_axis *axis, servo_mode mode) {
  axis->mode = mode == SERVO_BRAKE ? SERVO_BRAKE : SERVO_OFF;
  axis->commanded_nm = 0.0f;
  axis->added_nm = 0.0f;
  axis->current_reference_a = 0.0f;
  axis->signals.torque = (speed_loop_output){0};
}

/* The torque that the motor gave since the last tick: the command, unless the bus could not drive the current. */
static float applied_torque_nm(const servo_axis *axis, const servo_axis_params *params,
                               const servo_axis_samples *samples) {
  return samples->motor_limited ? params->torque_constant_nm_a * samples->sensors.mean_current_a : axis->commanded_nm;
}

static torque_limits limits_in_force(const servo_axis_params *params, const servo_axis_command *command) {
  const float limit_nm = params->current_limit_a * params->torque_constant_nm_a;
  if (!command->torque_limited) {
    return (torque_limits){.minimum_nm = -limit_nm, .maximum_nm = limit_nm};
  }
  return (torque_limits){.minimum_nm = scalar_clamp(command->limits.minimum_nm, -limit_nm, 0.0f),
                         .maximum_nm = scalar_clamp(command->limits.maximum_nm, 0.0f, limit_nm)};
}

/* The speed loop within the limits that the added torque leaves. In SERVO_TORQUE these are zero, so its anti-windup
 * holds the integral at the applied torque, and closing a loop again causes no step. */
static void control_torque(servo_axis *axis, const servo_axis_params *params, const servo_axis_command *command,
                           const speed_loop_rates *rates, float applied_nm, float tick_s) {
  const torque_limits all = limits_in_force(params, command);
  const float given_nm = scalar_clamp(command->torque_nm, all.minimum_nm, all.maximum_nm);
  const bool torque_mode = axis->mode == SERVO_TORQUE;
  const float added_nm = torque_mode ? 0.0f : given_nm;
  const torque_limits room = {.minimum_nm = (torque_mode ? given_nm : all.minimum_nm) - added_nm,
                              .maximum_nm = (torque_mode ? given_nm : all.maximum_nm) - added_nm};
  axis->signals.torque = speed_loop_control(&axis->speed, &params->speed, rates, &axis->signals.reference,
                                            applied_nm - axis->added_nm, &room, tick_s);
  axis->signals.torque.limited = given_nm != command->torque_nm || (axis->signals.torque.limited && !torque_mode);
  axis->added_nm = added_nm;
  /* Limit again: the difference and the sum round. */
  axis->signals.torque.torque_nm =
      scalar_clamp(axis->signals.torque.torque_nm + added_nm, all.minimum_nm, all.maximum_nm);
  if (!isfinite(axis->signals.torque.torque_nm)) { /* no plausible input leads here; if one does, the axis is off */
    axis->implausible = true;
    open_loops(axis, SERVO_OFF);
    return;
  }
  axis->commanded_nm = axis->signals.torque.torque_nm;
  axis->current_reference_a = axis->commanded_nm / params->torque_constant_nm_a;
}

/* The torque of protection: no loop above the current loop, no limit that a user sets. */
static void brake_protectively(servo_axis *axis, const servo_axis_params *params, float torque_nm) {
  const float limit_nm = params->current_limit_a * params->torque_constant_nm_a;
  open_loops(axis, SERVO_OFF);
  axis->mode = SERVO_PROTECTIVE_STOP;
  axis->commanded_nm = scalar_clamp(torque_nm, -limit_nm, limit_nm);
  axis->current_reference_a = axis->commanded_nm / params->torque_constant_nm_a;
}

void servo_axis_tick(servo_axis *axis, const servo_axis_params *params, const servo_axis_command *command,
                     const servo_axis_samples *samples, float tick_s) {
  const bool samples_missed = axis->implausible;
  const bool angle_plausible = angle_is_plausible(axis, samples->sensors.joint_angle_turn32, tick_s);
  axis->last_angle = samples->sensors.joint_angle_turn32;
  axis->implausible = !samples_are_plausible(&samples->sensors) || !angle_plausible || !command_is_plausible(command);
  if (axis->implausible) {
    open_loops(axis, command->mode);
    return;
  }
  if (samples_missed) { /* the sensed state has a gap */
    const speed_loop_pose pose = axis->pose;
    servo_axis_reset(axis, params, samples->sensors.joint_angle_turn32, tick_s);
    axis->pose = pose;
  }
  if (axis->pose.inertia_share != axis->speed.pose.inertia_share ||
      axis->pose.gyro_share != axis->speed.pose.gyro_share || axis->pose.gyro_below != axis->speed.pose.gyro_below) {
    speed_loop_follow(&axis->speed, &params->speed, &axis->pose, &axis->signals.rates, &axis->signals.reference,
                      tick_s);
  }
  const bool closes = !servo_mode_closes(axis->mode) && servo_mode_closes(command->mode);
  axis->mode = command->mode;

  const speed_loop_samples motion = {.joint_angle = samples->sensors.joint_angle_turn32,
                                     .gyro_rad_s = samples->sensors.gyro_rad_s,
                                     .gyro_valid = samples->sensors.gyro_valid};
  const speed_loop_rates rates = speed_loop_sense(&axis->speed, &params->speed, &motion, tick_s);
  if (closes) {
    speed_loop_close(&axis->speed, &params->speed, &rates, tick_s);
  }
  const speed_reference reference = choose_reference(axis, params, command, samples, &rates, tick_s);
  axis->signals.rates = rates;
  axis->signals.reference = reference;
  if (axis->mode == SERVO_PROTECTIVE_STOP) {
    brake_protectively(axis, params, command->torque_nm);
    return;
  }
  if (!servo_mode_closes(axis->mode)) {
    open_loops(axis, axis->mode);
    return;
  }
  control_torque(axis, params, command, &rates, applied_torque_nm(axis, params, samples), tick_s);
}

void servo_axis_retune(servo_axis *axis, servo_axis_params *in_force, const servo_axis_params *next, float tick_s) {
  if (servo_mode_closes(axis->mode)) {
    speed_loop_retune(&axis->speed, &in_force->speed, &next->speed, &axis->signals.rates, &axis->signals.reference,
                      axis->commanded_nm - axis->added_nm, tick_s);
  }
  *in_force = *next;
}

void servo_axis_replace(servo_axis *axis, servo_axis_params *in_force, const servo_axis_params *next, float holding_nm,
                        float tick_s) {
  *in_force = *next;
  if (servo_mode_closes(axis->mode)) {
    speed_loop_restart(&axis->speed, &next->speed, &axis->signals.rates, holding_nm, tick_s);
  }
}
