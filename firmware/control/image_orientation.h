/* SPDX-License-Identifier: Apache-2.0 */
/* How the camera's picture is turned against the line of sight: its roll, whether it is mirrored, and its scale.
 *
 * When the line of sight moves by s, a target at rest moves by -s in a right picture. In a picture that is turned and
 * scaled, as complex numbers, its error is e with
 *
 *     s = -n e              turned by arg n, scaled by |n|: what is missing in the mounting that the errors assume
 *     s = -n conj(e)        likewise, of a mirrored picture
 *
 * A target at a constant rate adds a straight line in time. So the straight lines are taken out of s and e of the last
 * ORIENTATION_SAMPLES pictures within ORIENTATION_WINDOW_S, and n is that of least squares. What a target's own
 * acceleration adds is not known, and makes both fits bad; a fit that leaves more than 1 / ORIENTATION_CLEAR of the
 * squares is no finding. A motion along one direction tells a roll, but not a roll from a mirror. */
#ifndef TRACKSERVO_CONTROL_IMAGE_ORIENTATION_H
#define TRACKSERVO_CONTROL_IMAGE_ORIENTATION_H

#include <stdbool.h>

#include "control/line_of_sight.h"

enum { ORIENTATION_SAMPLES = 24, ORIENTATION_FEWEST = 5, ORIENTATION_CLEAR = 16, ORIENTATION_EXCLUDES = 9 };

#define ORIENTATION_SCALE 3.0f     /* a scale beyond 1 / 3 .. 3 is no finding */
#define ORIENTATION_WINDOW_S 1.0f  /* older pictures do not count: targets turn */
#define ORIENTATION_LONGEST_S 0.5f /* between two pictures; a longer one begins anew */

typedef struct {
  float interval_s;   /* since the exposure of the picture before, > 0 */
  image_vector moved; /* by the line of sight since then, rad */
  image_vector error; /* target minus line of sight at exposure, as the assumed mounting gives it, rad */
} orientation_sample;

typedef struct {
  orientation_sample samples[ORIENTATION_SAMPLES]; /* ring */
  int count;
  int newest;
} image_orientation;

typedef enum { ORIENTATION_UNCLEAR = 0, ORIENTATION_TURNED, ORIENTATION_MIRRORED } orientation_kind;

typedef struct {
  orientation_kind kind;
  bool both;       /* two directions have moved: the other kind is excluded */
  float moved_rad; /* by the line of sight off its straight line, root mean square */
  float roll_rad;  /* arg n, -pi .. pi */
  float scale;     /* |n| */
} orientation_finding;

/* Forgets all pictures. */
void image_orientation_reset(image_orientation *self);

/* Adds a picture. One that is not finite or comes too late begins anew. */
void image_orientation_add(image_orientation *self, const orientation_sample *sample);

/* Returns what the pictures say. The other kind is excluded by a motion of `least_rad` (root mean square) in the second
 * direction. Cost: 1,500 instructions. */
orientation_finding image_orientation_find(const image_orientation *self, float least_rad);

#endif
