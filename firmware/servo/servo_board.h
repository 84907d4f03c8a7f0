/* SPDX-License-Identifier: Apache-2.0 */
/* The servo on a machine: the only place where the control core meets the HAL.
 *
 *     tick         hal_sample, hal_bus_voltage_v -> servo_app_tick -> motor_stage_hand_over, hal_power_bridge
 *     PWM period   hal_current_a, hal_bus_voltage_v -> motor_stage_step -> hal_set_duty
 *
 * The interrupts of a board (through the product's main.c), the simulator and the tests call these functions. The order
 * of one tick is: PWM period 0, the tick, PWM periods 1 to SERVO_PWM_PER_TICK - 1. A PWM period may interrupt the
 * tick. */
#ifndef TRACKSERVO_SERVO_SERVO_BOARD_H
#define TRACKSERVO_SERVO_SERVO_BOARD_H

#include "hal.h"
#include "servo/motor_stage.h"
#include "servo/servo_app.h"

typedef struct {
  servo_app app;
  motor_stage motor[SERVO_AXES];
  servo_samples samples; /* of this tick */
  servo_command command; /* command of the axes from the next tick on */
  hal *machine;
} servo_board;

/* Checks and takes the parameters; all axes are off then and duties 0. If it refuses them, nothing changes. */
control_status servo_board_start(servo_board *board, hal *machine, const servo_params *params);

/* Runs the first half of a tick: reads all samples and the reports of the motor stages. The caller may compute the
 * commands between the halves. */
void servo_board_sample(servo_board *board);

/* Runs the second half of a tick: runs the control, hands the commands over to the motor stages and powers the
 * bridges. */
void servo_board_control(servo_board *board);

/* Runs both halves of a tick, with the present command. */
void servo_board_tick(servo_board *board);

/* Runs the motor stages of both axes, in PWM period 0 .. SERVO_PWM_PER_TICK - 1 after the tick's sampling. */
void servo_board_pwm_period(servo_board *board, uint32_t period);

#endif
