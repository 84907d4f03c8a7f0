/* SPDX-License-Identifier: Apache-2.0 */
#include "servo/jumping_picture.h"

#include "base/scalar.h"

/* Returns how many times faster than JUMPING_RAD_S it is, against the last jump; 0: no jump, or not against it. */
static uint8_t jumps_back(jumping_picture *self, image_vector change, int ticks, float dt_s) {
  const float farthest_rad = JUMPING_RAD_S * dt_s * (float)(ticks > 1 ? ticks : 1);
  const float far_rad = scalar_max(scalar_abs(change.x), scalar_abs(change.y));
  if (far_rad <= farthest_rad) {
    return 0;
  }
  const bool back = change.x * self->jump.x + change.y * self->jump.y < 0.0f;
  self->jump = change;
  return (uint8_t)(back ? scalar_min(far_rad / farthest_rad, 255.0f) : 0.0f);
}

static void score(jumping_picture *self, uint8_t times) {
  if (times > 0) {
    self->score = self->score < JUMPING_HIGHEST_SCORE - 1 ? (uint8_t)(self->score + 2) : JUMPING_HIGHEST_SCORE;
    self->free = times < JUMPING_FREE ? (uint8_t)(times - 1) : JUMPING_FREE;
  } else if (self->free > 0) {
    self->free--;
  } else if (self->score > 0) {
    self->score--;
  }
}

bool jumping_picture_take(jumping_picture *self, const pointing_frame *frame, float dt_s) {
  self->ticks = self->ticks < UINT8_MAX ? (uint8_t)(self->ticks + 1) : UINT8_MAX;
  if (!frame->fresh || !frame->valid) {
    return false;
  }
  const image_vector change = {.x = frame->error.x - self->error.x, .y = frame->error.y - self->error.y};
  const int ticks = self->ticks + self->age_ticks - frame->age_ticks; /* between the exposures */
  score(self, self->seen ? jumps_back(self, change, ticks, dt_s) : 0);
  self->jumps = self->score >= JUMPING_SCORE || (self->jumps && self->score > 0);
  self->seen = true;
  self->ticks = 0;
  self->age_ticks = frame->age_ticks;
  self->error = frame->error;
  return self->jumps;
}
