#include "node/axis_monitor.h"

#include <math.h>

#include "base/scalar.h"

void axis_monitor_reset(axis_monitor *monitor) {
  axis_protection_reset(&monitor->state);
  monitor->slow = (slow_monitors){.found = 0};
  monitor->judged = 0;
  axis_monitor_retuned(monitor);
}

void axis_monitor_retuned(axis_monitor *monitor) {
  oscillation_reset(&monitor->swings);
  monitor->oscillates = false;
}

static protection_motor motor_of(const servo_axis_params *params) {
  return (protection_motor){
      .resistance_ohm = params->resistance_ohm,
      .back_emf_v_s_rad = params->current.back_emf_v_s_rad,
      .current_limit_a = params->current_limit_a,
      .torque_constant_nm_a = params->torque_constant_nm_a,
      .time_constant_s = params->current.pi.proportional_gain / params->current.pi.integral_gain,
  };
}

static void look(protection_inputs *in, const servo_board *board, int i, drive_angle position) {
  const servo_axis *axis = &board->app.axis[i];
  const servo_axis_samples *samples = &board->samples.axis[i];
  const bool closed = servo_mode_closes(axis->mode);
  in->angle_valid = !samples->sensors.encoder_failed;
  in->angle = samples->sensors.joint_angle_turn32;
  in->gyro_valid = samples->sensors.gyro_valid;
  in->gyro_used = board->app.params.axis[i].speed.rate_fusion.source != RATE_FROM_ENCODER;
  in->gyro_rad_s = samples->sensors.gyro_rad_s;
  in->position_rad = drive_angle_difference_rad(position, 0);
  in->mean_current_a = samples->sensors.mean_current_a;
  in->voltage_v = samples->motor_voltage_v;
  in->tick_voltage_v = samples->tick_voltage_v;
  in->tick_current_a = samples->tick_current_a;
  in->bus_voltage_v = board->samples.bus_voltage_v;
  in->powered = axis->mode != SERVO_OFF;
  in->closed = closed;
  in->speed_closed = closed && axis->mode != SERVO_TORQUE;
  in->limited = axis->signals.torque.limited;
  in->torque_nm = axis->commanded_nm;
  in->reference_rad_s = axis->signals.reference.rate_rad_s;
  in->rate_rad_s = axis->signals.rates.rate_rad_s;
}

/* What the torque limits of the last command leave; never less than a tenth of the motor's torque: below it nothing
 * shakes. */
static float torque_in_force_nm(const servo_axis_params *params, const servo_axis_command *command) {
  const float motor_nm = params->current_limit_a * params->torque_constant_nm_a;
  if (!command->torque_limited) {
    return motor_nm;
  }
  return scalar_clamp(scalar_max(command->limits.maximum_nm, -command->limits.minimum_nm), 0.1f * motor_nm, motor_nm);
}

static float friction_nm(const servo_axis_params *params) {
  const lugre_params *lugre = &params->speed.friction.lugre;
  return scalar_max(lugre->positive.coulomb_nm, lugre->negative.coulomb_nm);
}

/* The rate that the axis gets from outside. In tracking the camera decides it: an alternating one is slow. */
static float outer_reference_rad_s(axis_monitor *monitor, const servo_axis *axis, const servo_axis_command *command) {
  const float increment_rad = angle_difference_rad(command->position, monitor->last_setpoint);
  monitor->last_setpoint = command->position;
  switch (axis->mode) {
    case SERVO_SPEED:
      return axis->signals.reference.rate_rad_s;
    case SERVO_POSITION:
      return increment_rad / SERVO_TICK_S;
    default:
      return 0.0f;
  }
}

/* The commands of this tick, for the motion that the next one sees. */
static void note_commands(axis_monitor *monitor, const servo_axis *axis, const servo_axis_params *params,
                          const servo_axis_command *command) {
  monitor->torque_nm = torque_in_force_nm(params, command);
  monitor->commanded =
      (oscillation_inputs){.reference_rad_s = outer_reference_rad_s(monitor, axis, command),
                           .loop_nm = axis->commanded_nm - axis->added_nm,
                           .feedforward_nm = axis->signals.torque.friction_nm + axis->signals.torque.acceleration_nm,
                           .added_nm = axis->added_nm};
}

static bool look_for_oscillation(axis_monitor *monitor, const servo_axis_params *params, bool suspect) {
  const oscillation_params plant = {.inertia_kg_m2 = params->plant_inertia_kg_m2,
                                    .friction_nm = scalar_min(friction_nm(params), 0.3f * monitor->torque_nm),
                                    .torque_nm = monitor->torque_nm,
                                    .suspect = suspect};
  oscillation_inputs in = monitor->commanded;
  in.closed = monitor->seen.speed_closed && monitor->seen.angle_valid;
  in.rate_rad_s = monitor->state.last_step_rad / SERVO_TICK_S;
  return oscillation_step(&monitor->swings, &plant, &in, SERVO_TICK_S);
}

/* In a fast oscillation the voltage of the last PWM period does not belong to the mean current of the tick: until the
 * new gains are proven or taken back, that shows no broken sensor. */
static fault_set without_current(axis_monitor *monitor, fault_set found) {
  if (!monitor->may_shake) {
    return found;
  }
  monitor->state.mismatch_ticks = 0;
  return found & ~(fault_bit(FAULT_CURRENT_SENSOR) | fault_bit(FAULT_MOTOR_CONTRADICTS) | fault_bit(FAULT_MOTOR_WEAK));
}

fault_set axis_monitor_step(axis_monitor *monitor, const servo_board *board, int axis, drive_angle position) {
  const protection_motor motor = motor_of(&board->app.params.axis[axis]);
  look(&monitor->seen, board, axis, position);
  monitor->found = axis_protection_step(&monitor->state, &monitor->limits, &motor, &monitor->seen, SERVO_TICK_S);
  return monitor->judged | without_current(monitor, monitor->found);
}

/* Set-point 0, or a position that does not change. */
static bool stands(axis_monitor *monitor, const servo_axis_command *command) {
  const bool held = command->mode == SERVO_POSITION && command->position == monitor->last_position;
  monitor->last_position = command->position;
  return (held || command->mode == SERVO_SPEED) && command->speed.rate_rad_s == 0.0f;
}

/* The axes in different ticks. */
static bool judges_slowly(uint32_t tick, int axis) {
  const uint32_t period = SLOW_MONITOR_TICKS;
  return (tick + (uint32_t)axis * (period / (uint32_t)SERVO_AXES)) % period == 0;
}

static fault_set judge_slowly(axis_monitor *monitor, const servo_axis_command *command, int axis,
                              const axis_monitor_setting *setting) {
  slow_monitors_add(&monitor->slow, &monitor->state, monitor->found);
  if (judges_slowly(setting->tick, axis)) {
    const slow_commands commands = {.standing = stands(monitor, command) && !setting->stimulated,
                                    .reduced = setting->reduced_speed};
    slow_monitors_judge(&monitor->slow, &monitor->limits, &monitor->state, &monitor->seen, &commands, SERVO_TICK_S);
  }
  return monitor->slow.found;
}

void axis_monitor_judge(axis_monitor *monitor, const servo_board *board, int axis,
                        const axis_monitor_setting *setting) {
  const servo_axis_params *params = &board->app.params.axis[axis];
  const servo_axis_command *command = &board->command.axis[axis];
  const protection_motor motor = motor_of(params);
  const fault_set found =
      axis_protection_judge(&monitor->state, &monitor->limits, &motor, &monitor->seen, SERVO_TICK_S);
  monitor->oscillates = look_for_oscillation(monitor, params, setting->new_gains);
  monitor->may_shake = setting->new_gains && oscillation_may_begin(&monitor->swings);
  monitor->judged = without_current(monitor, found) | judge_slowly(monitor, command, axis, setting);
  note_commands(monitor, &board->app.axis[axis], params, command);
}

void axis_monitor_remember(const axis_monitor *monitor, int axis, fault_log *log) {
  const protection_inputs *seen = &monitor->seen;
  const fault_log_sample sample = {
      .joint_angle_rad = angle_difference_rad(seen->angle, 0),
      .joint_rate_rad_s = monitor->state.last_step_rad / SERVO_TICK_S,
      .gyro_rad_s = seen->gyro_valid ? seen->gyro_rad_s : NAN,
      .reference_rad_s = seen->reference_rad_s,
      .rate_rad_s = seen->rate_rad_s,
      .torque_nm = seen->torque_nm,
      .current_a = seen->mean_current_a,
      .bus_voltage_v = seen->bus_voltage_v,
  };
  fault_log_sample_tick(log, axis, &sample);
}

static int32_t position_of(float angle_rad) {
  const float counts_per_rad = 1e7f;
  return (int32_t)(angle_rad * counts_per_rad);
}

static drive_travel hard_travel(const protection_limits *limits) {
  return (drive_travel){position_of(limits->minimum_rad), position_of(limits->maximum_rad)};
}

drive_machine axis_monitor_machine(const axis_monitor *monitor, const servo_axis_params *params) {
  const protection_limits *limits = &monitor->limits;
  return (drive_machine){.hard = hard_travel(limits),
                         .margin = position_of(limits->stopping_margin_rad),
                         .overspeed_rad_s = limits->overspeed_rad_s,
                         .torque_nm = params->current_limit_a * params->torque_constant_nm_a,
                         .inertia_kg_m2 = params->speed.observer.inertia_kg_m2};
}

holding_brake_times axis_monitor_brake(const axis_monitor *monitor) {
  const protection_limits *limits = &monitor->limits;
  return (holding_brake_times){.release_s = limits->brake_release_s,
                               .engage_s = limits->brake_engage_s,
                               .feedback_used = limits->brake_feedback >= 0.5f};
}

drive_travel axis_monitor_default_travel(const axis_monitor *monitor) {
  const int32_t margin = 174533; /* 1 degree */
  const drive_travel hard = hard_travel(&monitor->limits);
  if ((int64_t)hard.maximum - hard.minimum < 4 * (int64_t)margin) {
    return (drive_travel){0, 0};
  }
  return (drive_travel){hard.minimum + margin, hard.maximum - margin};
}
