#include "node/axis_watch.h"

#include <math.h>

void axis_watch_reset(axis_watch *watch) { axis_protection_reset(&watch->state); }

static protection_motor motor_of(const servo_axis_params *params) {
  return (protection_motor){
      .resistance_ohm = params->resistance_ohm,
      .back_emf_v_s_rad = params->current.back_emf_v_s_rad,
      .current_limit_a = params->current_limit_a,
      .torque_constant_nm_a = params->torque_constant_nm_a,
  };
}

static protection_inputs inputs_of(const servo_board *board, int i, drive_angle position) {
  const servo_axis *axis = &board->app.axis[i];
  const servo_axis_samples *samples = &board->samples.axis[i];
  const bool closed = servo_mode_closes(axis->mode);
  return (protection_inputs){
      .angle_valid = !samples->encoder_failed,
      .angle = samples->motion.joint_angle,
      .gyro_valid = samples->motion.gyro_valid,
      .gyro_used = board->app.params.axis[i].speed.rate_fusion.source != RATE_FROM_ENCODER,
      .gyro_rad_s = samples->motion.gyro_rad_s,
      .position_rad = drive_angle_difference_rad(position, 0),
      .mean_current_a = samples->mean_current_a,
      .voltage_v = axis->current.voltage_v,
      .bus_voltage_v = hal_bus_voltage_v(board->machine),
      .powered = axis->mode != SERVO_OFF,
      .closed = closed,
      .speed_closed = closed && axis->mode != SERVO_TORQUE,
      .limited = axis->signals.torque.limited,
      .torque_nm = axis->commanded_nm,
      .reference_rad_s = axis->signals.reference.rate_rad_s,
      .rate_rad_s = axis->signals.rates.rate_rad_s,
  };
}

static void remember(const axis_watch *watch, const protection_inputs *in, int axis, fault_log *log) {
  const fault_log_sample sample = {
      .joint_angle_rad = angle_difference_rad(in->angle, 0),
      .joint_rate_rad_s = watch->state.last_step_rad / SERVO_TICK_S,
      .gyro_rad_s = in->gyro_valid ? in->gyro_rad_s : NAN,
      .reference_rad_s = in->reference_rad_s,
      .rate_rad_s = in->rate_rad_s,
      .torque_nm = in->torque_nm,
      .current_a = in->mean_current_a,
      .bus_voltage_v = in->bus_voltage_v,
  };
  fault_log_sample_tick(log, axis, &sample);
}

fault_set axis_watch_step(axis_watch *watch, const servo_board *board, int axis, drive_angle position, fault_log *log) {
  const protection_motor motor = motor_of(&board->app.params.axis[axis]);
  const protection_inputs in = inputs_of(board, axis, position);
  const fault_set found = axis_protection_step(&watch->state, &watch->limits, &motor, &in, SERVO_TICK_S);
  remember(watch, &in, axis, log);
  return found;
}

drive_travel axis_watch_travel(const axis_watch *watch) {
  const float counts_per_rad = 1e7f;
  return (drive_travel){(int32_t)(watch->limits.minimum_rad * counts_per_rad),
                        (int32_t)(watch->limits.maximum_rad * counts_per_rad)};
}
