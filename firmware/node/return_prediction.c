/* SPDX-License-Identifier: Apache-2.0 */
#include "node/return_prediction.h"

#include "base/scalar.h"

void return_prediction_reset(return_prediction *self) {
  self->ahead.running = false;
  self->known = false;
  self->late = false;
}

/* While the azimuth turns back nobody sees the target. */
static target_return_start start_of(const return_prediction_inputs *inputs, uint32_t tick) {
  const turn_back *turn = inputs->turn;
  if (turn->running) {
    return (target_return_start){.path = turn->path,
                                 .path_s = (float)(tick - turn->begun) * SERVO_TICK_S,
                                 .joint_rad = inputs->joint_rad,
                                 .joint_rad_s = inputs->motion->inertial_rad_s,
                                 .direction = turn->direction};
  }
  const pointing_target target = pointing_tracker_target(&inputs->line_of_sight->tracker);
  return (target_return_start){.path = target_path_straight(inputs->joint_rad, &target),
                               .joint_rad = inputs->joint_rad,
                               .joint_rad_s = inputs->motion->inertial_rad_s};
}

static void begin(return_prediction *self, const target_return_limits *limits, const return_prediction_inputs *inputs,
                  uint32_t tick) {
  const target_return_start start = start_of(inputs, tick);
  target_return_begin(&self->ahead, limits, &start);
  self->begun = tick;
}

static bool is_too_fast(const pointing_output *target, joint_vector limit_rad_s) {
  return target->limited || !scalar_within(target->reference[SERVO_AZIMUTH].rate_rad_s, limit_rad_s.azimuth) ||
         !scalar_within(target->reference[SERVO_PITCH].rate_rad_s, limit_rad_s.pitch);
}

static bool is_near(image_vector error) {
  return scalar_within(error.x, TARGET_RETURN_MISS_RAD) && scalar_within(error.y, TARGET_RETURN_MISS_RAD);
}

static void predict(return_prediction *self) {
  if (!self->ahead.running) {
    return;
  }
  target_return_step(&self->ahead);
  if (!self->ahead.running) {
    self->known = self->ahead.found;
    self->back_at = self->begun + (uint32_t)(self->ahead.after_s / SERVO_TICK_S);
  }
}

uint16_t return_prediction_step(return_prediction *self, const target_return_limits *limits,
                                const return_prediction_inputs *inputs, uint32_t tick) {
  const bool too_fast = is_too_fast(inputs->target, limits->rate_limit_rad_s);
  if (!inputs->target->locked || (!too_fast && is_near(inputs->target->error_rad))) {
    return_prediction_reset(self);
    return 0;
  }
  if (!self->late) {
    self->late = true;
    self->since = tick;
  }
  if (too_fast && !self->ahead.running) {
    begin(self, limits, inputs, tick);
  }
  predict(self);
  if (!self->known) {
    return RETURN_UNKNOWN;
  }
  const int32_t left = (int32_t)(self->back_at - tick);
  return left > 1 ? (uint16_t)left : 1;
}

float return_prediction_absence_s(const return_prediction *self) {
  return self->known ? (float)(self->back_at - self->since) * SERVO_TICK_S : 0.0f;
}
