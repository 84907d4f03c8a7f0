/* A picture that is sent again and again as if it were new: the counter advances, the target's place in it does not,
 * and the axes move after it.
 *
 * A place off the centre that stays within a count is that of a target which the line of sight follows with a
 * lag, as with a wrong age; then its rate is constant. After a picture that nobody takes any more the line of sight
 * runs faster and faster, because the target in it does not come nearer. So a picture is frozen when its place has
 * stayed for two windows of FROZEN_WINDOW_TICKS, and the line of sight has moved in the second one further than in the
 * first, by FROZEN_RATIO times as much as the place is off, and by FROZEN_COUNTS counts. A place within
 * FROZEN_MIN_COUNTS of the centre says nothing: a coarse camera shows it for a target that is followed well. A frozen
 * picture whose place agrees with the motion so far looks like a target that is followed well, too, and is not found.
 * Pictures without a target say nothing: they neither end a window nor what was found. A window that lasts longer than
 * FROZEN_LONGEST_WINDOW_TICKS, because none showed a target, begins anew.
 */
#ifndef TRACKSERVO_SERVO_FROZEN_PICTURE_H
#define TRACKSERVO_SERVO_FROZEN_PICTURE_H

#include <stdbool.h>
#include <stdint.h>

#include "base/rotation.h"
#include "servo/camera_input.h"

enum {
  FROZEN_WINDOW_TICKS = 250,
  FROZEN_LONGEST_WINDOW_TICKS = 375,
  FROZEN_RATIO = 2,
  FROZEN_COUNTS = 25,
  FROZEN_MIN_COUNTS = 2,
  FROZEN_JITTER_COUNTS = 1
};

typedef struct {
  angle_turn32 azimuth;
  angle_turn32 pitch;
} joint_place;

/* How far the line of sight has moved along both axes. */
typedef struct {
  float azimuth_rad;
  float pitch_rad;
} sight_motion;

typedef struct {
  bool seen; /* the rest is of a picture with a target */
  bool frozen;
  bool has_before; /* a window is complete */
  int16_t x;
  int16_t y;
  uint32_t since_tick; /* when this window began */
  joint_place from;    /* the joints then */
  sight_motion before; /* in the window before */
} frozen_picture;

/* Takes a message that counted in tick `tick`, whose target is `off_rad` from where it is to be held; `count_rad`:
 * 3071:1. */
void frozen_picture_take(frozen_picture *self, const camera_message *message, float off_rad, float count_rad,
                         joint_place joints, uint32_t tick);

/* Returns whether the target of a message is within FROZEN_JITTER_COUNTS of the place of the first one. */
static inline bool frozen_picture_is_at(const frozen_picture *self, const camera_message *message) {
  const int x = message->x - self->x;
  const int y = message->y - self->y;
  return x <= FROZEN_JITTER_COUNTS && x >= -FROZEN_JITTER_COUNTS && y <= FROZEN_JITTER_COUNTS &&
         y >= -FROZEN_JITTER_COUNTS;
}

/* Returns whether a message is of the frozen picture. */
static inline bool frozen_picture_shows(const frozen_picture *self, const camera_message *message) {
  return self->frozen && message->quality != CAMERA_NO_TARGET && frozen_picture_is_at(self, message);
}

#endif
