/* SPDX-License-Identifier: Apache-2.0 */
#include "control/target_return.h"

#include <math.h>

#include "base/scalar.h"
#include "control/approach.h"

#define MET_RAD (0.5f * SCALAR_PI) /* so close, the shorter turn is that of `direction` */

void target_return_begin(target_return *self, const target_return_limits *limits, const target_return_start *start) {
  self->limits = *limits;
  self->now = *start;
  self->steps = 0;
  self->held_steps = 0;
  self->running = true;
}

float target_return_error_rad(float difference_rad, float direction) {
  const float turns = scalar_round(difference_rad / (2.0f * SCALAR_PI));
  const float shorter_rad = difference_rad - turns * 2.0f * SCALAR_PI;
  return shorter_rad * direction < 0.0f ? shorter_rad + direction * 2.0f * SCALAR_PI : shorter_rad;
}

float target_return_rate_rad_s(const joint_target *target, float error_rad, float proportional_per_s,
                               float limit_rad_s2) {
  const float braking_rad_s2 = approach_braking(limit_rad_s2, error_rad, target->acceleration_rad_s2);
  return target->rate_rad_s + approach_rate(proportional_per_s, braking_rad_s2, error_rad);
}

/* Of one joint. */
typedef struct {
  float *angle_rad;
  float *rate_rad_s;
  float limit_rad_s;
  float limit_rad_s2;
} moving_joint;

/* Moves a joint; returns whether its rate is not limited. */
static bool move(const moving_joint *joint, const joint_target *target, float error_rad, float proportional_per_s) {
  const float step_rad_s = TARGET_RETURN_STEP_S * joint->limit_rad_s2;
  const float wanted_rad_s = target_return_rate_rad_s(target, error_rad, proportional_per_s, joint->limit_rad_s2);
  const float change_rad_s = scalar_clamp(wanted_rad_s, -joint->limit_rad_s, joint->limit_rad_s) - *joint->rate_rad_s;
  *joint->rate_rad_s += scalar_clamp(change_rad_s, -step_rad_s, step_rad_s);
  *joint->angle_rad += *joint->rate_rad_s * TARGET_RETURN_STEP_S;
  return scalar_within(wanted_rad_s, joint->limit_rad_s);
}

/* At an end of the travel the azimuth stops. */
static void keep_within_travel(target_return *self) {
  const float inside_rad = joint_travel_clamp(&self->limits.azimuth_travel, self->now.joint_rad.azimuth);
  if (inside_rad != self->now.joint_rad.azimuth) {
    self->now.joint_rad.azimuth = inside_rad;
    self->now.joint_rad_s.azimuth = 0.0f;
  }
}

void target_return_step(target_return *self) {
  if (!self->running) {
    return;
  }
  const target_return_limits *limits = &self->limits;
  target_return_start *now = &self->now;
  const float time_s = (float)self->steps * TARGET_RETURN_STEP_S;
  const target_place target = target_path_at(&now->path, now->path_s + time_s);
  const float azimuth_rad = target_return_error_rad(target.azimuth.angle_rad - now->joint_rad.azimuth, now->direction);
  const float pitch_rad = target.pitch.angle_rad - now->joint_rad.pitch;
  const float across_rad = azimuth_rad * target.horizontal;
  const float miss = across_rad * across_rad + pitch_rad * pitch_rad;
  now->direction = scalar_within(azimuth_rad, MET_RAD) ? 0.0f : now->direction;
  const moving_joint azimuth = {&now->joint_rad.azimuth, &now->joint_rad_s.azimuth, limits->rate_limit_rad_s.azimuth,
                                limits->acceleration_limit_rad_s2.azimuth};
  const moving_joint pitch = {&now->joint_rad.pitch, &now->joint_rad_s.pitch, limits->rate_limit_rad_s.pitch,
                              limits->acceleration_limit_rad_s2.pitch};
  const bool azimuth_free = move(&azimuth, &target.azimuth, azimuth_rad, limits->proportional_per_s);
  const bool pitch_free = move(&pitch, &target.pitch, pitch_rad, limits->proportional_per_s);
  keep_within_travel(self);
  const bool back = azimuth_free && pitch_free && miss <= TARGET_RETURN_MISS_RAD * TARGET_RETURN_MISS_RAD;
  self->held_steps = back ? self->held_steps + 1 : 0;
  self->steps++;
  const bool stays = self->held_steps == TARGET_RETURN_HELD_STEPS;
  if (stays || self->steps == TARGET_RETURN_STEPS) {
    self->running = false;
    self->found = stays;
    self->after_s = time_s - (float)(TARGET_RETURN_HELD_STEPS - 1) * TARGET_RETURN_STEP_S;
  }
}
