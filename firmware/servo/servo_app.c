/* SPDX-License-Identifier: Apache-2.0 */
#include "servo/servo_app.h"

#include "base/scalar.h"

speed_loop_pose servo_azimuth_pose(const servo_axis_params *azimuth, float pitch_cosine) {
  const float least = speed_loop_inertia_share(azimuth->min_inertia_kg_m2, azimuth->plant_inertia_kg_m2);
  return (speed_loop_pose){
      .inertia_share = scalar_min(least + (1.0f - least) * pitch_cosine * pitch_cosine, 1.0f),
      .gyro_share = azimuth->gyro == GYRO_ON_LINE_OF_SIGHT ? pitch_cosine : 1.0f,
      .gyro_below = azimuth->gyro == GYRO_BELOW_JOINT,
  };
}

static void pose_pitch(servo_app *app) {
  app->axis[SERVO_PITCH].pose.gyro_below = app->params.axis[SERVO_PITCH].gyro == GYRO_BELOW_JOINT;
}

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
  app->axis[SERVO_AZIMUTH].pose = servo_azimuth_pose(&params->axis[SERVO_AZIMUTH], samples->pitch.cosine);
  pose_pitch(app);
  return CONTROL_OK;
}

static void pose_azimuth(servo_app *app, const servo_samples *samples) {
  if (samples->axis[SERVO_PITCH].sensors.encoder_failed) {
    return;
  }
  speed_loop_pose *pose = &app->axis[SERVO_AZIMUTH].pose;
  const float before = pose->inertia_share;
  *pose = servo_azimuth_pose(&app->params.axis[SERVO_AZIMUTH], samples->pitch.cosine);
  pose->inertia_share = scalar_clamp(pose->inertia_share, before - SERVO_SHARE_STEP, before + SERVO_SHARE_STEP);
}

void servo_app_tick(servo_app *app, const servo_command *command, const servo_samples *samples) {
  pose_azimuth(app, samples);
  pose_pitch(app);
  for (int i = 0; i < SERVO_AXES; ++i) {
    servo_axis_tick(&app->axis[i], &app->params.axis[i], &command->axis[i], &samples->axis[i], SERVO_TICK_S);
  }
}
