#include "servo/servo_app.h"

control_status servo_app_configure(servo_app *app, const servo_params *params, const servo_samples *samples) {
  for (int i = 0; i < SERVO_AXES; ++i) {
    const control_status status = servo_axis_check(&params->axis[i], SERVO_TICK_S, SERVO_PWM_PERIOD_S);
    if (status != CONTROL_OK) {
      return status;
    }
  }
  app->params = *params;
  for (int i = 0; i < SERVO_AXES; ++i) {
    servo_axis_reset(&app->axis[i], &params->axis[i], samples->axis[i].sensors.joint_angle_turn32, SERVO_TICK_S);
  }
  return CONTROL_OK;
}

void servo_app_tick(servo_app *app, const servo_command *command, const servo_samples *samples) {
  for (int i = 0; i < SERVO_AXES; ++i) {
    servo_axis_tick(&app->axis[i], &app->params.axis[i], &command->axis[i], &samples->axis[i], SERVO_TICK_S);
  }
}
