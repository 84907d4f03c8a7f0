/* SPDX-License-Identifier: Apache-2.0 */
/* Whether the picture shows the target where it is: a camera mounted upside down, or an image processor that mirrors,
 * makes the tracking loop a positive feedback.
 *
 * The orientation found (control/image_orientation.h) decides, while an axis tracks:
 *
 *     not judged    rates are limited (rate_limit_rad_s), and a target that leaves the picture is lost
 *                   after PICTURE_UNPROVEN_COAST_S. Until the picture is found to be right, or the target has been
 *                   followed for PICTURE_PROVEN_TICKS without the limit
 *     right         turned by less than 45 degrees. A mirror is still looked for until both directions have moved
 *     turned        by 45 to 60 degrees: goes on with a warning
 *     wrong         turned by more, or mirrored: nothing is followed until tracking is ended, or 3071 is written
 *     no answer     as wrong: the line of sight has moved by PICTURE_FARTHEST_RAD at the limit, not judged, and the
 *                   target has come no nearer; or its way is so much longer than it has come, as of one that goes round
 *                   in circles because the scale is far off
 *
 * A constant rate is a straight line, which shows nothing: a wrong picture at the limit looks like a target that runs
 * away. So as long as the limit holds and the target comes no nearer, it falls to PICTURE_SLOWER of itself for every
 * other PICTURE_VARIES_TICKS.
 * A wrong picture drives the line of sight away faster and faster. So one that is not so fast is no proof: a target
 * that accelerates looks similar for a moment. All findings of PICTURE_AGREE_TICKS must agree. */
#ifndef TRACKSERVO_SERVO_PICTURE_CHECK_H
#define TRACKSERVO_SERVO_PICTURE_CHECK_H

#include "control/image_orientation.h"

enum {
  PICTURE_SPACING_TICKS = 18,  /* between two pictures that count here: 50 Hz, with the jitter of a tick */
  PICTURE_AGREE_TICKS = 36,    /* for so long all findings must say wrong, two at least */
  PICTURE_PROMPT_TICKS = 40,   /* between two pictures; with longer intervals the limit of the rate is lower */
  PICTURE_SLOWEST_TICKS = 100, /* longer intervals count as this */
  PICTURE_VARIES_TICKS = 400,
  PICTURE_PROVEN_TICKS = 1500
};

#define PICTURE_UNPROVEN_RAD_S 0.1f
#define PICTURE_UNPROVEN_COAST_S 0.15f
#define PICTURE_SLOWER 0.25f
#define PICTURE_FARTHEST_RAD 0.15f   /* 8.6 degrees */
#define PICTURE_TELLS_RAD 0.2e-3f    /* motion off the straight line (rms) that proves a right picture */
#define PICTURE_STOPS_RAD 0.5e-3f    /* likewise a wrong one, while not judged */
#define PICTURE_CONVICTS_RAD 1e-3f   /* likewise, of one that has been right */
#define PICTURE_WARNS_RAD 0.7853982f /* 45 degrees */
#define PICTURE_WRONG_RAD 1.0471976f /* 60 degrees */

typedef enum {
  PICTURE_NOT_JUDGED = 0,
  PICTURE_RIGHT = 1,
  PICTURE_TURNED = 2,
  PICTURE_WRONG_ROLL = 3,
  PICTURE_MIRRORED = 4,
  PICTURE_NO_ANSWER = 5
} picture_verdict;

typedef struct {
  image_orientation pictures;
  image_vector moved;      /* by the line of sight since the newest exposure */
  uint32_t ticks;          /* since then */
  float rate_limit_rad_s;  /* highest rate of the line of sight, as long as the picture is not judged: less before
                              the third one, because a constant rate shows nothing */
  float full_limit_rad_s;  /* of which it is PICTURE_SLOWER at times */
  uint32_t held_ticks;     /* since the limit holds, or the first picture */
  image_vector held_moved; /* by the line of sight in this time */
  float held_path_rad;     /* its way from picture to picture */
  float held_error_rad;    /* at its beginning */
  bool no_nearer;          /* the newest error is as large at least */
  uint32_t unjudged_ticks; /* up to a picture that the next tick judges: the tick of a frame has enough to do */
  picture_verdict verdict;
  bool complete;           /* right in both directions */
  bool doubted;            /* the last finding said wrong */
  uint32_t doubted_ticks;  /* between the first such finding in a row and the last one */
  uint16_t followed_ticks; /* without the limit */
  float roll_rad;          /* of the verdict: missing in 3071:2 */
} picture_check;

/* Forgets all. Call when no axis tracks, or when the mounting changes. */
void picture_check_reset(picture_check *self);

/* Judges the picture taken before it, and adds a tick in which the line of sight has moved by `moved_rad`. `follows`: a
 * target is followed, below the rate limit. Call once per tick while an axis tracks. */
void picture_check_tick(picture_check *self, image_vector moved_rad, bool follows);

/* Takes a picture of a target with its error; since its exposure the line of sight has moved by `since_rad`, in
 * `age_ticks`. Call after picture_check_tick. */
void picture_check_take(picture_check *self, image_vector error_rad, image_vector since_rad, int age_ticks);

static inline bool picture_check_is_wrong(const picture_check *self) { return self->verdict >= PICTURE_WRONG_ROLL; }

#endif
