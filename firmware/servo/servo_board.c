#include "servo/servo_board.h"

static void read_frame(hal *machine, int axis, camera_frame *frame) {
  hal_camera_frame raw = {0};
  frame->fresh = hal_camera(machine, axis, &raw);
  frame->valid = raw.target_found;
  frame->age_ticks = raw.age_ticks;
  frame->error_rad = raw.error_rad;
}

/* An angle that cannot be read keeps its last value. */
static void read_samples(hal *machine, servo_samples *samples) {
  for (int i = 0; i < SERVO_AXES; ++i) {
    servo_axis_samples *axis = &samples->axis[i];
    axis->encoder_failed = !hal_joint_angle(machine, i, &axis->motion.joint_angle);
    axis->motion.gyro_rad_s = 0.0f;
    axis->motion.gyro_valid = hal_gyro_rate(machine, i, &axis->motion.gyro_rad_s);
    axis->mean_current_a = hal_mean_current_a(machine, i);
    read_frame(machine, i, &axis->frame);
  }
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
      hal_set_duty(machine, i, 0.0f);
    }
  }
  return status;
}

void servo_board_sample(servo_board *board) { read_samples(board->machine, &board->samples); }

void servo_board_control(servo_board *board) { servo_app_tick(&board->app, &board->command, &board->samples); }

void servo_board_tick(servo_board *board) {
  servo_board_sample(board);
  servo_board_control(board);
}

void servo_board_pwm(servo_board *board, int axis) {
  const float current_a = hal_current_a(board->machine, axis);
  const float bus_voltage_v = hal_bus_voltage_v(board->machine);
  hal_set_duty(board->machine, axis, servo_app_pwm(&board->app, axis, current_a, bus_voltage_v));
}
