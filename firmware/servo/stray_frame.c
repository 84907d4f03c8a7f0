/* SPDX-License-Identifier: Apache-2.0 */
#include "servo/stray_frame.h"

#include "base/scalar.h"

void stray_frames_pass_ms(stray_frames *self) {
  self->ms = (uint16_t)(self->ms < UINT16_MAX ? self->ms + 1 : self->ms);
}

void stray_frames_settle(stray_frames *self, bool follows) {
  if (!follows) {
    self->settled_ms = 0;
  } else if (self->settled_ms < STRAY_SETTLED_MS) {
    self->settled_ms++;
  }
}

/* On the same side, and at least half as far. */
static bool confirms(const stray_frames *self, image_vector residual_rad) {
  const image_vector before = self->residual_rad;
  const float along = residual_rad.x * before.x + residual_rad.y * before.y;
  return self->waits && along > 0.5f * (before.x * before.x + before.y * before.y);
}

bool stray_frames_take(stray_frames *self, image_vector residual_rad) {
  const float size_rad = scalar_max(scalar_abs(residual_rad.x), scalar_abs(residual_rad.y));
  const float limit_rad = scalar_max(STRAY_RATIO * self->usual_rad, STRAY_RAD);
  const bool may_wait = self->settled_ms >= STRAY_SETTLED_MS && self->ms <= STRAY_LONGEST_MS;
  if (may_wait && size_rad > limit_rad && !confirms(self, residual_rad)) {
    self->usual_rad += (limit_rad - self->usual_rad) / (float)STRAY_FRAMES;
    self->waits = true;
    self->residual_rad = residual_rad;
    return true;
  }
  self->waits = false;
  self->ms = 0;
  self->usual_rad += (size_rad - self->usual_rad) / (float)STRAY_FRAMES;
  return false;
}
