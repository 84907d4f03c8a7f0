/* SPDX-License-Identifier: Apache-2.0 */
/* Frames that contradict each other: from one to the next the target jumps further than any target moves, and back.
 *
 * The tracking loop takes the mean of such errors. If they do not answer the axes' motion, as those of an image
 * processor that has lost its target, a mean of zero confirms whatever rate the loop has begun with: both axes drift.
 * So JUMPING_SCORE / 2 jumps in a row, each faster than JUMPING_RAD_S and against the one before, make the frames count
 * no more, until as many others have come. A jump adds 2 to the score, another frame takes 1 away; not so the first
 * frames after a jump, as many as it is times faster than JUMPING_RAD_S, JUMPING_FREE at most: errors that stay for a
 * few frames and jump far contradict each other, too. An imager that hops between two targets a few times in a second
 * keeps its score low, and noise reaches it from about JUMPING_RAD_S times the time between two frames (rms) on. */
#ifndef TRACKSERVO_SERVO_JUMPING_PICTURE_H
#define TRACKSERVO_SERVO_JUMPING_PICTURE_H

#include <stdbool.h>
#include <stdint.h>

#include "control/pointing_tracker.h"

enum { JUMPING_SCORE = 12, JUMPING_HIGHEST_SCORE = 24, JUMPING_FREE = 8 };

#define JUMPING_RAD_S 0.5f /* per frame of 2 ms: 1 mrad; of 20 ms: 10 mrad */

typedef struct {
  bool seen;     /* a frame has come */
  uint8_t ticks; /* since the last frame, saturates */
  uint8_t score;
  uint8_t free;       /* frames that take nothing away */
  bool jumps;         /* its frames do not count */
  int age_ticks;      /* of the last frame */
  image_vector error; /* likewise */
  image_vector jump;  /* the last one */
} jumping_picture;

/* Takes what a tick has: a frame or none. Returns whether the frame must not count. */
bool jumping_picture_take(jumping_picture *self, const pointing_frame *frame, float dt_s);

#endif
