/* SPDX-License-Identifier: Apache-2.0 */
#include "servo/servo_board.h"

static void read_samples(hal *machine, servo_samples *samples) {
  samples->bus_voltage_v = hal_bus_voltage_v(machine);
  for (int i = 0; i < SERVO_AXES; ++i) {
    hal_sample(machine, i, &samples->axis[i].sensors);
  }
  servo_samples_complete(samples);
}

control_status servo_board_start(servo_board *board, hal *machine, const servo_params *params) {
  servo_samples samples = {0};
  read_samples(machine, &samples);
  const control_status status = servo_app_configure(&board->app, params, &samples);
  if (status == CONTROL_OK) {
    board->machine = machine;
    board->samples = samples;
    board->command = (servo_command){0};
    for (int i = 0; i < SERVO_AXES; ++i) {
      motor_stage_reset(&board->motor[i]);
      hal_set_duty(machine, i, 0.0f);
    }
  }
  return status;
}

void servo_board_sample(servo_board *board) {
  read_samples(board->machine, &board->samples);
  for (int i = 0; i < SERVO_AXES; ++i) {
    servo_axis_samples *axis = &board->samples.axis[i];
    const motor_stage *motor = &board->motor[i];
    axis->motor_limited = atomic_load_explicit(&motor->limited, memory_order_relaxed);
    axis->tick_voltage_v = atomic_load_explicit(&motor->tick_voltage_v, memory_order_relaxed);
    axis->tick_current_a = atomic_load_explicit(&motor->tick_current_a, memory_order_relaxed);
  }
}

static motor_setpoint setpoint_of(const servo_axis *axis) {
  return (motor_setpoint){.on = servo_mode_drives(axis->mode),
                          .current_a = axis->current_reference_a,
                          .joint_rate_rad_s = axis->signals.rates.joint_rate_rad_s};
}

void servo_board_control(servo_board *board) {
  servo_app *app = &board->app;
  servo_app_tick(app, &board->command, &board->samples);
  for (int i = 0; i < SERVO_AXES; ++i) {
    motor_stage_hand_over(&board->motor[i], setpoint_of(&app->axis[i]), &app->params.axis[i].current);
    hal_power_bridge(board->machine, i, app->axis[i].mode != SERVO_OFF);
  }
}

void servo_board_tick(servo_board *board) {
  servo_board_sample(board);
  servo_board_control(board);
}

void servo_board_pwm_period(servo_board *board, uint32_t period) {
  const float bus_voltage_v = hal_bus_voltage_v(board->machine);
  for (int i = 0; i < SERVO_AXES; ++i) {
    const float current_a = hal_current_a(board->machine, i);
    hal_set_duty(board->machine, i, motor_stage_step(&board->motor[i], period, current_a, bus_voltage_v));
  }
}
