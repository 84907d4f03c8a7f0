#include "servo/frozen_picture.h"

#include "base/scalar.h"

static bool is_at(const frozen_axis *self, float error_rad) {
  return scalar_within(error_rad - self->place_rad, self->steady_rad);
}

static void judge_window(frozen_axis *self, float count_rad, float motion_rad) {
  const float off_rad = scalar_abs(self->place_rad);
  const float faster_rad = scalar_abs(motion_rad - self->before_rad);
  self->frozen =
      self->frozen || (self->has_before && off_rad > (float)FROZEN_MIN_COUNTS * count_rad &&
                       faster_rad > (float)FROZEN_COUNTS * count_rad && faster_rad > (float)FROZEN_RATIO * off_rad);
  self->before_rad = motion_rad;
  self->has_before = true;
}

/* `share` of the joint's motion moves the line of sight along this axis. */
static void take(frozen_axis *self, float error_rad, float count_rad, angle_turn32 joint, float share, uint32_t tick) {
  const uint32_t lasts = tick - self->since_tick;
  if (!self->seen || !is_at(self, error_rad)) {
    const float part_rad = scalar_abs(error_rad) / (float)FROZEN_STEADY_PART;
    *self = (frozen_axis){.seen = true,
                          .place_rad = error_rad,
                          .steady_rad = scalar_max(part_rad, (float)FROZEN_JITTER_COUNTS * count_rad)};
  } else if (lasts > (uint32_t)FROZEN_LONGEST_WINDOW_TICKS) {
    self->has_before = false;
  } else if (lasts >= FROZEN_WINDOW_TICKS) {
    judge_window(self, count_rad, share * angle_difference_rad(joint, self->from));
  } else {
    return;
  }
  self->from = joint;
  self->since_tick = tick;
}

void frozen_picture_take(frozen_picture *self, image_vector error, float count_rad, joint_place joints, uint32_t tick) {
  take(&self->azimuth, error.x, count_rad, joints.azimuth, rotation_cosine(joints.pitch), tick);
  take(&self->pitch, error.y, count_rad, joints.pitch, 1.0f, tick);
}

static bool shows(const frozen_axis *self, float error_rad) { return self->frozen && is_at(self, error_rad); }

bool frozen_picture_shows(const frozen_picture *self, image_vector error) {
  return shows(&self->azimuth, error.x) || shows(&self->pitch, error.y);
}
