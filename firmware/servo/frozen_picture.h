/* SPDX-License-Identifier: Apache-2.0 */
/* A picture that is sent again and again as if it were new, or a spot on the sensor that is taken for the target: the
 * counter advances, the target's place in the picture does not, and the axes move after it. Each axis of the picture is
 * judged for itself.
 *
 * A place off the centre that stays, within FROZEN_JITTER_COUNTS or a FROZEN_STEADY_PART of what it is off, is that of
 * a target which the line of sight follows with a lag, as with a wrong age; then its rate is constant. After a picture
 * that nobody takes any more the line of sight runs faster and faster, because the target in it does not come nearer.
 * So a picture is frozen when its place has stayed for two windows of FROZEN_WINDOW_TICKS at least, and the line of
 * sight would have moved in FROZEN_WINDOW_TICKS of the second one further than in those of the first, along this axis
 * and in all, by FROZEN_RATIO times as much as the place is off, and by FROZEN_COUNTS counts. In all: on a straight
 * pass near the zenith the motion only passes from the pitch to the azimuth. A place within FROZEN_MIN_COUNTS of the
 * centre says nothing: a coarse camera shows it for a target that is followed well. A target that is as fast for as
 * long by itself has left the place soon after its pictures do not count any more, and is followed again: with a lag e
 * the loop accelerates by about 100 e in a second, so that the target is e / 16 further after 35 ms. A frozen picture
 * whose place agrees with the motion so far looks like a target that is followed well, too, and is not found.
 *
 * Pictures without a target say nothing. A window that lasts longer than FROZEN_LONGEST_WINDOW_TICKS, because none
 * showed a target, begins anew.
 */
#ifndef TRACKSERVO_SERVO_FROZEN_PICTURE_H
#define TRACKSERVO_SERVO_FROZEN_PICTURE_H

#include <stdbool.h>
#include <stdint.h>

#include "base/rotation.h"
#include "control/line_of_sight.h"

enum {
  FROZEN_WINDOW_TICKS = 250,
  FROZEN_LONGEST_WINDOW_TICKS = 1000,
  FROZEN_RATIO = 2,
  FROZEN_COUNTS = 25,
  FROZEN_MIN_COUNTS = 2,
  FROZEN_JITTER_COUNTS = 2,
  FROZEN_STEADY_PART = 16
};

typedef struct {
  angle_turn32 azimuth;
  angle_turn32 pitch;
} joint_place;

/* Along one axis of the picture. */
typedef struct {
  bool seen; /* the rest is of a picture with a target */
  bool frozen;
  bool has_before; /* a window is complete */
  float place_rad; /* of the target, from where it is to be held */
  float steady_rad;
  uint32_t since_tick; /* when this window began */
  joint_place from;    /* the joints then */
  float along_rad;     /* motion of the line of sight along the axis in FROZEN_WINDOW_TICKS of the window before */
  float in_all_rad;    /* likewise, whatever its direction */
} frozen_axis;

typedef struct {
  frozen_axis azimuth;
  frozen_axis pitch;
} frozen_picture;

/* Takes a picture that counted in tick `tick` and shows a target, whose error is that of the line of sight;
 * `count_rad`: 3071:1. */
void frozen_picture_take(frozen_picture *self, image_vector error, float count_rad, joint_place joints, uint32_t tick);

/* Restarts the windows; a place that is frozen stays so. Call after a time without frozen_picture_take. */
void frozen_picture_begin(frozen_picture *self);

/* Returns whether a picture that shows a target is the frozen one. */
bool frozen_picture_shows(const frozen_picture *self, image_vector error);

#endif
