/* SPDX-License-Identifier: Apache-2.0 */
/* The control core as one value: both axes and their parameters.
 *
 * `servo_app_tick` runs once per millisecond and touches no hardware. servo_board.h puts it between sensors and
 * motor stages. */
#ifndef TRACKSERVO_SERVO_SERVO_APP_H
#define TRACKSERVO_SERVO_SERVO_APP_H

#include "base/rotation.h"
#include "servo/servo_axis.h"
#include "servo/servo_timing.h"

enum { SERVO_AZIMUTH = 0, SERVO_PITCH = 1, SERVO_AXES = HAL_AXES };

typedef struct {
  servo_axis_params axis[SERVO_AXES];
} servo_params;

typedef struct {
  servo_axis_samples axis[SERVO_AXES];
  float bus_voltage_v; /* for drive and protection; no control law of the tick uses it */
  rotation pitch;      /* of the pitch's angle: servo_samples_complete */
} servo_samples;

/* Computes what several readers need of the samples. Call when the sensors of both axes have been read. */
static inline void servo_samples_complete(servo_samples *samples) {
  samples->pitch = rotation_of(samples->axis[SERVO_PITCH].sensors.joint_angle_turn32);
}

typedef struct {
  servo_axis_command axis[SERVO_AXES];
} servo_command;

typedef struct {
  servo_params params;
  servo_axis axis[SERVO_AXES];
} servo_app;

/* Returns the share of its largest inertia that the azimuth's motor turns, J0 + J1 cos^2(pitch) over J0 + J1, and what
 * of its rate its gyro measures, at this cosine of the pitch. The share of inertia is 1 when the smallest inertia is
 * not below the largest one. */
speed_loop_pose servo_azimuth_pose(const servo_axis_params *azimuth, float pitch_cosine);

/* Largest change of the inertia's share in a tick, so that one wrong angle of the pitch does no harm: at 10 rad/s the
 * share of a J1 as large as J0 changes by half of it. */
#define SERVO_SHARE_STEP 0.01f

/* Takes the parameters after checking all of them; on an error the app is unchanged. `samples` give the start angles.
 * All axes are off afterwards. */
control_status servo_app_configure(servo_app *app, const servo_params *params, const servo_samples *samples);

/* Computes one tick of 1 ms of both axes. The azimuth's gains follow its inertia over the pitch; while the pitch's
 * encoder has failed, its last angle counts. */
void servo_app_tick(servo_app *app, const servo_command *command, const servo_samples *samples);

#endif
