/* The whole servo as one value: both axes, their parameters, and the two functions that a timer calls.
 *
 * `servo_app_tick` runs once per millisecond, `servo_app_pwm` once per axis and PWM period. Neither touches
 * hardware: the same code runs on the board (main.c behind the HAL), in the simulator and in the tests. */
#ifndef TRACKSERVO_SERVO_SERVO_APP_H
#define TRACKSERVO_SERVO_SERVO_APP_H

#include "servo/servo_axis.h"

#define SERVO_TICK_S 0.001f
#define SERVO_PWM_PERIOD_S 0.00005f
#define SERVO_PWM_PER_TICK 20

enum { SERVO_AZIMUTH = 0, SERVO_PITCH = 1, SERVO_AXES = 2 };

typedef struct {
  servo_axis_params axis[SERVO_AXES];
} servo_params;

typedef struct {
  servo_axis_samples axis[SERVO_AXES];
} servo_samples;

typedef struct {
  servo_axis_command axis[SERVO_AXES];
} servo_command;

typedef struct {
  servo_params params;
  servo_axis axis[SERVO_AXES];
} servo_app;

/* Takes the parameters after checking all of them; on an error the app is unchanged. `samples` give the start angles.
 * All axes are off afterwards. */
control_status servo_app_configure(servo_app *app, const servo_params *params, const servo_samples *samples);

/* One 1 ms tick of both axes. */
void servo_app_tick(servo_app *app, const servo_command *command, const servo_samples *samples);

/* One PWM period of one axis (SERVO_AZIMUTH or SERVO_PITCH): the duty in [-1, 1]. */
float servo_app_pwm(servo_app *app, int axis, float current_a, float bus_voltage_v);

#endif
