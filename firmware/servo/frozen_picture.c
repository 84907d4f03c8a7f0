#include "servo/frozen_picture.h"

#include "base/scalar.h"

static sight_motion motion_of(joint_place from, joint_place to) {
  return (sight_motion){.azimuth_rad = angle_difference_rad(to.azimuth, from.azimuth) * rotation_cosine(to.pitch),
                        .pitch_rad = angle_difference_rad(to.pitch, from.pitch)};
}

static float difference_rad(sight_motion a, sight_motion b) {
  return scalar_max(scalar_abs(a.azimuth_rad - b.azimuth_rad), scalar_abs(a.pitch_rad - b.pitch_rad));
}

static void begin_window(frozen_picture *self, joint_place joints, uint32_t tick) {
  self->from = joints;
  self->since_tick = tick;
}

static void judge_window(frozen_picture *self, float off_rad, float count_rad, joint_place joints) {
  const sight_motion motion = motion_of(self->from, joints);
  const float faster_rad = difference_rad(motion, self->before);
  self->frozen =
      self->frozen || (self->has_before && off_rad > (float)FROZEN_MIN_COUNTS * count_rad &&
                       faster_rad > (float)FROZEN_COUNTS * count_rad && faster_rad > (float)FROZEN_RATIO * off_rad);
  self->before = motion;
  self->has_before = true;
}

void frozen_picture_take(frozen_picture *self, const camera_message *message, float off_rad, float count_rad,
                         joint_place joints, uint32_t tick) {
  if (message->quality == CAMERA_NO_TARGET) {
    return;
  }
  const bool stays = self->seen && frozen_picture_is_at(self, message);
  const uint32_t lasts = tick - self->since_tick;
  if (!stays) {
    *self = (frozen_picture){.seen = true, .x = message->x, .y = message->y};
  } else if (lasts > (uint32_t)FROZEN_LONGEST_WINDOW_TICKS) {
    self->has_before = false;
  } else if (lasts >= FROZEN_WINDOW_TICKS) {
    judge_window(self, off_rad, count_rad, joints);
  } else {
    return;
  }
  begin_window(self, joints, tick);
}
