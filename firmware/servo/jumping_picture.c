#include "servo/jumping_picture.h"

#include "base/scalar.h"

/* Against the last jump. */
static bool jumps_back(jumping_picture *self, image_vector change, int ticks, float dt_s) {
  const float farthest_rad = JUMPING_RAD_S * dt_s * (float)(ticks > 1 ? ticks : 1);
  if (scalar_max(scalar_abs(change.x), scalar_abs(change.y)) <= farthest_rad) {
    return false;
  }
  const bool back = change.x * self->jump.x + change.y * self->jump.y < 0.0f;
  self->jump = change;
  return back;
}

static uint8_t score_after(uint8_t score, bool jump) {
  if (jump) {
    return score < JUMPING_HIGHEST_SCORE - 1 ? (uint8_t)(score + 2) : JUMPING_HIGHEST_SCORE;
  }
  return score > 0 ? (uint8_t)(score - 1) : 0;
}

bool jumping_picture_take(jumping_picture *self, const pointing_frame *frame, float dt_s) {
  self->ticks = self->ticks < UINT8_MAX ? (uint8_t)(self->ticks + 1) : UINT8_MAX;
  if (!frame->fresh || !frame->valid) {
    return false;
  }
  const image_vector change = {.x = frame->error.x - self->error.x, .y = frame->error.y - self->error.y};
  const int ticks = self->ticks + self->age_ticks - frame->age_ticks; /* between the exposures */
  self->score = score_after(self->score, self->seen && jumps_back(self, change, ticks, dt_s));
  self->jumps = self->score >= JUMPING_SCORE || (self->jumps && self->score > 0);
  self->seen = true;
  self->ticks = 0;
  self->age_ticks = frame->age_ticks;
  self->error = frame->error;
  return self->jumps;
}
