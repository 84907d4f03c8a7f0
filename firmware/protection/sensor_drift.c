/* SPDX-License-Identifier: Apache-2.0 */
#include "protection/sensor_drift.h"

#include "base/scalar.h"

#define OF_PATH 0.005f /* scale error of the gyro, eccentricity of the encoder */

bool sensor_drift_step(sensor_drift *drift, float window_rad, float difference_rad_s, float joint_rate_rad_s,
                       float dt_s) {
  if (window_rad <= 0.0f) {
    *drift = (sensor_drift){0};
    return false;
  }
  const float forgotten = dt_s / SENSOR_DRIFT_MEMORY_S;
  drift->difference_rad += difference_rad_s * dt_s - drift->difference_rad * forgotten;
  drift->path_rad += scalar_abs(joint_rate_rad_s) * dt_s - drift->path_rad * forgotten;
  return !scalar_within(drift->difference_rad, window_rad + OF_PATH * drift->path_rad);
}
