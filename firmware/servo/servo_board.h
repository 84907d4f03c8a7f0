/* The servo on a machine: the only place where the core meets the HAL.
 *
 * Path of a sample: hal_joint_angle, hal_gyro_rate -> servo_app_tick -> current set-point; hal_current_a ->
 * servo_app_pwm -> hal_set_duty. A platform calls `servo_board_tick` every 1 ms and `servo_board_pwm` for each axis
 * every PWM period. */
#ifndef TRACKSERVO_SERVO_SERVO_BOARD_H
#define TRACKSERVO_SERVO_SERVO_BOARD_H

#include "hal.h"
#include "servo/servo_app.h"

typedef struct {
  servo_app app;
  servo_samples samples; /* of this tick */
  servo_command command; /* command of the axes from the next tick on */
  hal *machine;
} servo_board;

/* All axes off, duties 0; parameters checked and taken, or an error and nothing changed. */
control_status servo_board_start(servo_board *board, hal *machine, const servo_params *params);

/* A tick in two halves, for a caller that computes the commands between them: samples in, then control. */
void servo_board_sample(servo_board *board);
void servo_board_control(servo_board *board);

/* Both halves, with the present command. */
void servo_board_tick(servo_board *board);

void servo_board_pwm(servo_board *board, int axis);

#endif
