/* SPDX-License-Identifier: Apache-2.0 */
/* Estimates the inertial rate that the speed loop controls and the base's rate that the friction model needs, from gyro
 * and encoder.
 *
 *     base = lowpass(gyro - joint),   inertial = joint + base          (complementary filter, crossover w)
 *
 * The gyro measures the inertial rate, the encoder the joint rate; they differ by the base's own motion, which is
 * slow. Above some 10 Hz a fine encoder is quieter than a gyro. So the fused rate follows the encoder above the
 * crossover and the gyro below it. When the gyro is lost, the last base rate is held and the loop stays closed. */
#ifndef TRACKSERVO_CONTROL_RATE_FUSION_H
#define TRACKSERVO_CONTROL_RATE_FUSION_H

#include <stdbool.h>

#include "base/status.h"

typedef enum {
  RATE_FROM_ENCODER = 0, /* no gyro fitted: the base rate is taken as 0 */
  RATE_FROM_GYRO,        /* gyro alone */
  RATE_FUSED
} rate_source;

typedef struct {
  rate_source source;
  float crossover_rad_s; /* w, 0.01 .. 2000 */
} rate_fusion_params;

typedef struct {
  float base_rate_rad_s;
} rate_fusion_state;

typedef struct {
  float rate_rad_s;      /* inertial rate for feedback */
  float base_rate_rad_s; /* inertial rate of the base */
} rate_fusion_output;

control_status rate_fusion_check(const rate_fusion_params *params);
void rate_fusion_reset(rate_fusion_state *state);

/* Computes one tick; ignores `gyro_rad_s` when `gyro_valid` is false. `carried_rad_s` is added to both rates: what is
 * known of the base's rate beside these sensors. */
static inline rate_fusion_output rate_fusion_step(rate_fusion_state *state, const rate_fusion_params *params,
                                                  float gyro_rad_s, bool gyro_valid, float joint_rate_rad_s,
                                                  float carried_rad_s, float dt_s) {
  rate_fusion_output out;
  out.rate_rad_s = joint_rate_rad_s + carried_rad_s;
  out.base_rate_rad_s = carried_rad_s;
  if (params->source == RATE_FROM_ENCODER) {
    return out;
  }
  if (gyro_valid) {
    const float step = params->crossover_rad_s * dt_s;
    const float innovation_rad_s = gyro_rad_s - joint_rate_rad_s - state->base_rate_rad_s;
    state->base_rate_rad_s += step / (1.0f + step) * innovation_rad_s;
  }
  const bool gyro_alone = params->source == RATE_FROM_GYRO && gyro_valid;
  out.base_rate_rad_s += state->base_rate_rad_s;
  out.rate_rad_s = gyro_alone ? gyro_rad_s + carried_rad_s : joint_rate_rad_s + out.base_rate_rad_s;
  return out;
}

#endif
