/* SPDX-License-Identifier: Apache-2.0 */
/* The camera's strobe: edges that the machine has captured, and which of them is the exposure of a frame.
 *
 * A frame belongs to an edge if
 * - exactly one edge has an age within the window (youngest .. oldest, 10 us): so the window must be shorter than the
 *   time between two frames, and
 * - edges and frames are in step: the number of the edge minus the frame's counter is as before.
 *
 * Otherwise the frame has no exposure by strobe, and the sender's statement counts. STROBE_LOG_AGREE frames in a row
 * that agree on another difference begin a new order; what the edges were more or less than the frames is counted. So
 * after a noise edge, or a missing one, that many frames count by the sender's statement. A delay that grows by a whole
 * frame time for good cannot be distinguished from a missing edge: only the window excludes it.
 *
 * Cost: about 20 instructions for each edge that is younger than the window's end, and 60. */
#ifndef TRACKSERVO_SERVO_STROBE_LOG_H
#define TRACKSERVO_SERVO_STROBE_LOG_H

#include <stdbool.h>
#include <stdint.h>

#include "hal.h"

enum {
  STROBE_LOG_EDGES = 64, /* remembered: the history of the line of sight at 500 Hz; a power of two */
  STROBE_LOG_AGREE = 4   /* frames */
};

/* Why the last frame had no exposure by strobe. */
typedef enum {
  STROBE_FOUND = 0,
  STROBE_NONE = 1,        /* no edge within the window */
  STROBE_SEVERAL = 2,     /* more than one */
  STROBE_OUT_OF_ORDER = 3 /* the only one is not in step with the frames */
} strobe_refusal;

typedef struct {
  uint16_t youngest;         /* age of an exposure, 10 us */
  uint16_t oldest;           /* not above 12700 */
  uint16_t half_exposure_us; /* from the edge to the middle of the exposure */
} strobe_params;

typedef struct {
  uint32_t at_us[STROBE_LOG_EDGES]; /* machine's clock; edge n is at n modulo STROBE_LOG_EDGES */
  uint32_t edges;                   /* so far */
  uint32_t past;                    /* of them, so many are too old for any later frame */
  uint32_t floods;                  /* ms with more edges than any camera has: they were dropped */
  bool heard;                       /* a frame has come */
  uint8_t last_counter;             /* of the last frame */
  bool in_step;                     /* `step` is known */
  uint8_t step;                     /* number of an edge minus counter of its frame, modulo 256 */
  uint8_t other_step;               /* of the last frames, if different */
  uint8_t others;                   /* frames in a row with it */
  uint32_t paired;                  /* frames with an exposure by strobe */
  uint32_t unpaired;                /* frames without */
  uint32_t missing;                 /* edges less than frames */
  uint32_t additional;              /* edges more than frames */
  uint32_t age_us;                  /* of the last frame that was paired */
  strobe_refusal last_refusal;
} strobe_log;

/* Forgets all edges and frames. */
void strobe_log_reset(strobe_log *self);

/* Adds edges that the machine has captured. */
void strobe_log_add(strobe_log *self, const hal_strobes *strobes);

/* Returns the machine's clock at the newest edge, us; 0 before the first. */
uint32_t strobe_log_newest_us(const strobe_log *self);

/* Takes a frame with this counter and returns whether an edge is its exposure. Sets `age_us` then to the age of the
 * middle of the exposure when the machine's clock is `now_us`. Ignores a frame with the counter of the last one. */
bool strobe_log_pair(strobe_log *self, const strobe_params *params, uint8_t counter, uint32_t now_us);

#endif
