/* SPDX-License-Identifier: Apache-2.0 */
#include "servo/frozen_picture.h"

#include <math.h>

#include "base/scalar.h"

static bool is_at(const frozen_axis *self, float error_rad) {
  return scalar_within(error_rad - self->place_rad, self->steady_rad);
}

/* Of the line of sight. */
static image_vector motion_of(joint_place from, joint_place to) {
  return (image_vector){.x = angle_difference_rad(to.azimuth, from.azimuth) * rotation_cosine(to.pitch),
                        .y = angle_difference_rad(to.pitch, from.pitch)};
}

/* `lasts` ticks: what counts is the motion in FROZEN_WINDOW_TICKS of them. */
static void judge_window(frozen_axis *self, bool vertical, float count_rad, joint_place joints, uint32_t lasts) {
  const float share = (float)FROZEN_WINDOW_TICKS / (float)lasts;
  const image_vector motion = motion_of(self->from, joints);
  const float along_rad = share * (vertical ? motion.y : motion.x);
  const float in_all_rad = share * sqrtf(motion.x * motion.x + motion.y * motion.y);
  const float faster_rad =
      scalar_min(scalar_abs(along_rad - self->along_rad), scalar_abs(in_all_rad - self->in_all_rad));
  const float off_rad = scalar_abs(self->place_rad);
  self->frozen =
      self->frozen || (self->has_before && off_rad > (float)FROZEN_MIN_COUNTS * count_rad &&
                       faster_rad > (float)FROZEN_COUNTS * count_rad && faster_rad > (float)FROZEN_RATIO * off_rad);
  self->along_rad = along_rad;
  self->in_all_rad = in_all_rad;
  self->has_before = true;
}

static void begin_at(frozen_axis *self, float error_rad, float count_rad) {
  const float part_rad = scalar_abs(error_rad) / (float)FROZEN_STEADY_PART;
  *self = (frozen_axis){.seen = true,
                        .place_rad = error_rad,
                        .steady_rad = scalar_max(part_rad, (float)FROZEN_JITTER_COUNTS * count_rad)};
}

/* `vertical`: along the pitch. Returns whether it has judged. */
static bool take(frozen_axis *self, bool vertical, float error_rad, float count_rad, joint_place joints,
                 uint32_t tick) {
  const uint32_t lasts = tick - self->since_tick;
  const bool judges = lasts <= (uint32_t)FROZEN_LONGEST_WINDOW_TICKS;
  const bool left = !self->seen || !is_at(self, error_rad);
  if (left) {
    begin_at(self, error_rad, count_rad);
  } else if (lasts < FROZEN_WINDOW_TICKS) {
    return false;
  } else if (judges) {
    judge_window(self, vertical, count_rad, joints, lasts);
  } else {
    self->has_before = false;
  }
  self->from = joints;
  self->since_tick = tick;
  return judges && !left;
}

void frozen_picture_take(frozen_picture *self, image_vector error, float count_rad, joint_place joints, uint32_t tick) {
  if (!take(&self->azimuth, false, error.x, count_rad, joints, tick)) { /* one of them in a ms: it takes time */
    (void)take(&self->pitch, true, error.y, count_rad, joints, tick);
  }
}

static void forget_unless_frozen(frozen_axis *self) {
  if (!self->frozen) {
    *self = (frozen_axis){0};
  }
}

void frozen_picture_begin(frozen_picture *self) {
  forget_unless_frozen(&self->azimuth);
  forget_unless_frozen(&self->pitch);
}

static bool shows(const frozen_axis *self, float error_rad) { return self->frozen && is_at(self, error_rad); }

bool frozen_picture_shows(const frozen_picture *self, image_vector error) {
  return shows(&self->azimuth, error.x) || shows(&self->pitch, error.y);
}
