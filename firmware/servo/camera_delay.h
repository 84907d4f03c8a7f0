/* SPDX-License-Identifier: Apache-2.0 */
/* The camera's delay while both axes track: measured from the frames, reported, and corrected if that is allowed.
 *
 *     in the tick        camera_delay_age, camera_delay_notice for each frame
 *     in the same ms     camera_delay_step: a part of the work in each ms, after the tick; camera_delay_dither
 *
 * The estimate (control/delay_estimator.h) uses the motion of the line of sight that the pointing tracker remembers. It
 * takes this motion at the age that it believes (stated age plus `offset_ticks`), so that a large error does not make
 * it wrong. Frames that arrive while it works on another one are left out: from 330 Hz on.
 *
 * The dither is a sine on the elevation's rate. It gives the line of sight a motion that the target cannot have. The
 * first dither is a small one that starts by itself when both axes track a target, until half the interval is
 * CAMERA_DELAY_WELL_KNOWN_S, CAMERA_DELAY_FIRST_DITHER_S in all; the other one is the user's. */
#ifndef TRACKSERVO_SERVO_CAMERA_DELAY_H
#define TRACKSERVO_SERVO_CAMERA_DELAY_H

#include <stdbool.h>
#include <stdint.h>

#include "control/delay_estimator.h"
#include "control/pointing_tracker.h"

typedef enum { CAMERA_DELAY_IGNORED = 0, CAMERA_DELAY_REPORTED = 1, CAMERA_DELAY_CORRECTED = 2 } camera_delay_use;

enum { CAMERA_DELAY_MOST_TICKS = 50 }; /* of a correction */

#define CAMERA_DELAY_GOOD_ENOUGH_S 4e-3f /* half an interval: a worse estimate corrects nothing */
#define CAMERA_DELAY_WELL_KNOWN_S 2.5e-3f
#define CAMERA_DELAY_FIRST_DITHER_S 30.0f /* until the estimate is forgotten */

typedef struct {
  uint8_t use;            /* camera_delay_use */
  float dither_rad;       /* the user's, amplitude of the elevation, 0 .. 2e-4 */
  float dither_hz;        /* of both, 1 .. 10 */
  float first_dither_rad; /* 0 .. 2e-5; 0: none */
} camera_delay_params;

typedef enum { CAMERA_DELAY_WAITS = 0, CAMERA_DELAY_FRAME, CAMERA_DELAY_SAMPLE, CAMERA_DELAY_SUMS } camera_delay_stage;

typedef struct {
  delay_estimator estimator;
  delay_error found;
  delay_sample sample;
  pointing_frame frame;     /* of the stage CAMERA_DELAY_FRAME; with the stated age */
  image_vector moved_since; /* by the line of sight from the last frame's exposure to its tick */
  int ticks_since;          /* the last frame, up to TARGET_TRACKER_HISTORY */
  int tracked_ticks;        /* up to TARGET_TRACKER_HISTORY */
  int offset_ticks;         /* the error that is believed, -CAMERA_DELAY_MOST_TICKS .. CAMERA_DELAY_MOST_TICKS */
  camera_delay_stage stage;
  angle_turn32 dither_phase;
  float first_dither_s; /* so far */
} camera_delay;

/* Forgets the estimated error and all frames. */
void camera_delay_reset(camera_delay *self);

/* Returns the effective age of a frame, in ticks, 0 .. TARGET_TRACKER_HISTORY - 1, given the age that its sender
 * states. */
int camera_delay_age(const camera_delay *self, const camera_delay_params *params, int stated_ticks);

/* Takes a frame of this tick, with the age that its sender states, aligned as for pointing_step. */
void camera_delay_notice(camera_delay *self, const pointing_frame *frame);

/* Leaves out the frame of this ms, which does not count. */
void camera_delay_leave_out(camera_delay *self);

/* Continues the estimate. Call once per ms after the tick. `count_rad`: to which the frames' errors are rounded;
 * `tracks`: both axes follow the estimate of `tracker`. */
void camera_delay_step(camera_delay *self, const camera_delay_params *params, const pointing_tracker_state *tracker,
                       float count_rad, bool tracks, float tick_s);

/* Returns the rate to add to the elevation's in the next tick, rad/s. `by_user`: the user's dither runs. */
float camera_delay_dither(camera_delay *self, const camera_delay_params *params, bool by_user, float tick_s);

#endif
