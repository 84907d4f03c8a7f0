/* SPDX-License-Identifier: Apache-2.0 */
/* Frames that have nothing to do with those around them: a bird, a reflection, a flash. One of them would count in
 * full: the axes would start after it.
 *
 * A frame's residual is what it says beyond the estimate from the frames before it. One that is STRAY_RATIO times as
 * large as usual, and STRAY_RAD at least, does not count, unless the frame before it was as far off on the same side:
 * then the target is there. So a target that really jumps is followed one frame later. The usual residual is a mean
 * over about STRAY_FRAMES frames; one that is dropped counts in it with the limit, so that errors that alternate soon
 * count. Only frames within STRAY_LONGEST_MS of the last one that counted are dropped: with fewer than 20 in a second
 * the wait for the next one would lose a target that begins to turn. Until the axes have followed the target for
 * STRAY_SETTLED_MS every frame counts: an estimate that has just begun is far off. */
#ifndef TRACKSERVO_SERVO_STRAY_FRAME_H
#define TRACKSERVO_SERVO_STRAY_FRAME_H

#include <stdbool.h>
#include <stdint.h>

#include "control/line_of_sight.h"

#define STRAY_RAD 3e-4f
#define STRAY_RATIO 8.0f

enum { STRAY_FRAMES = 8, STRAY_SETTLED_MS = 500, STRAY_LONGEST_MS = 50 };

typedef struct {
  uint16_t ms;               /* since the last frame that counted, saturates */
  uint16_t settled_ms;       /* for so long the axes have followed the target, up to STRAY_SETTLED_MS */
  float usual_rad;           /* mean of the residuals */
  bool waits;                /* the last frame did not count: the next one tells */
  image_vector residual_rad; /* of it */
} stray_frames;

/* Passes a ms without a frame, or before its frame. */
void stray_frames_pass_ms(stray_frames *self);

/* Says whether the axes followed the target in this ms, with frames that counted. */
void stray_frames_settle(stray_frames *self, bool follows);

/* Takes the residual of a frame, rad. Returns whether it must not count. */
bool stray_frames_take(stray_frames *self, image_vector residual_rad);

#endif
