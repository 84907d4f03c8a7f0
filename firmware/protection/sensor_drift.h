/* SPDX-License-Identifier: Apache-2.0 */
/* On a base that does not turn, encoder and gyro show the same angle in the long run: finds what is too slow for
 * 2060:2, a gyro bias or an encoder that creeps.
 *
 *     s' = gyro - joint rate - s / T,     p' = |joint rate| - p / T,     fault: |s| > window + 0.5 % of p
 *
 * A constant difference r is found after -T ln(1 - window / (r T)), if r > window / T: that is the gyro bias that is
 * tolerated. The caller limits r: what is faster has its own monitor. Smaller ones stay; the standstill monitor bounds
 * the motion that they cause. A base that moves makes the two differ legally: with a window of 0 nothing is compared.
 * Cost: about 20 instructions. */
#ifndef TRACKSERVO_PROTECTION_SENSOR_DRIFT_H
#define TRACKSERVO_PROTECTION_SENSOR_DRIFT_H

#include <stdbool.h>

#define SENSOR_DRIFT_MEMORY_S 5.0f /* T */

typedef struct {
  float difference_rad; /* s */
  float path_rad;       /* p */
} sensor_drift;

/* Computes one tick, with gyro minus joint rate. Returns whether the two have drifted apart. */
bool sensor_drift_step(sensor_drift *drift, float window_rad, float difference_rad_s, float joint_rate_rad_s,
                       float dt_s);

#endif
