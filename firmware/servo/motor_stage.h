/* SPDX-License-Identifier: Apache-2.0 */
/* The motor stage of one axis: from what a tick commands to the duty of each PWM period.
 *
 *     tick (1 kHz)         motor_stage_hand_over
 *     PWM period (20 kHz)  motor_stage_step: take the command -> current loop -> duty
 *
 * The PWM period interrupts the tick. Therefore the stage has two copies of the command: the tick writes the one that
 * is not in force. Mode, set-point and gains change together, in PWM period SERVO_TICK_LATENCY_PERIODS after the one in
 * which the tick sampled, however long the tick took (decision 0024). Board, emulator and simulator run this code. */
#ifndef TRACKSERVO_SERVO_MOTOR_STAGE_H
#define TRACKSERVO_SERVO_MOTOR_STAGE_H

#include "base/shared.h"
#include "control/current_loop.h"
#include "servo/servo_timing.h"

/* What a tick commands. */
typedef struct {
  bool on; /* the current loop gives the duty; false: the duty is 0 */
  float current_a;
  float joint_rate_rad_s; /* for the back-EMF */
} motor_setpoint;

typedef struct {
  motor_setpoint setpoint;
  current_loop_params params;
} motor_command;

typedef struct {
  motor_command in_force;   /* owned by the PWM period */
  motor_command next;       /* owned by the tick until `handed_over` is set */
  shared_flag handed_over;  /* `next` is complete and was not taken yet */
  current_loop_state state; /* owned by the PWM period */
  shared_flag limited;      /* in the last period the bus voltage was too low for the voltage that the loop wanted */
  float voltage_sum_v;      /* of the periods since the last tick; owned by the PWM period */
  uint32_t voltage_count;
  shared_float tick_voltage_v; /* mean over the periods of the last tick */
  shared_float tick_current_a; /* at its end, sampled in period 0 */
} motor_stage;

/* Switches the stage off. */
void motor_stage_reset(motor_stage *stage);

/* Hands a set-point over to the PWM periods. Call at the end of a tick. PWM periods may interrupt this call; it must
 * not interrupt them. */
void motor_stage_hand_over(motor_stage *stage, motor_setpoint setpoint, const current_loop_params *params);

/* Computes one PWM period, the `period`-th (0 ..) after the one in which the tick sampled. Returns the duty in [-1, 1]:
 * 0 while the current loop is off or a sample is implausible. A command that was handed over late takes effect in the
 * first period that finds it. */
float motor_stage_step(motor_stage *stage, uint32_t period, float current_a, float bus_voltage_v);

#endif
