/* SPDX-License-Identifier: Apache-2.0 */
/* Frames of an image processor, as they arrive over the bus: which of them count, and how old they are.
 *
 *     message (counts, time, quality, counter) -> counter, quality, time -> scale, sensor roll, boresight -> frame
 *
 * A frame counts once, and only if it is newer than the last one. The counter (0 .. 255, one more with each frame)
 * decides: 1 .. 127 ahead is newer, anything else was sent before or twice. Frames that are skipped take time: a
 * counter that is CAMERA_LEAD further ahead than there was time for since the last message, by the interval between
 * those that counted, is not newer either. A sender that has begun anew shows by CAMERA_RESTART messages in a row that
 * are not newer, each 1 .. CAMERA_RESTART_STEP counters ahead of the one before: the last of them counts. Messages that
 * are sent again say nothing. One that is behind the message before, as CAMERA_RESTART or more before it in a row, is
 * not newer: a counter that runs backwards comes round to the newest one. So a frozen counter or one that runs
 * backwards never drives an axis, and of two senders at once only one gets through. Each time a sender begins anew, the
 * next time takes four times as many messages, until the counters have once gone round: pictures that return again and
 * again, numbers and all, soon do not count.
 *
 * The error of a message is found when it arrives, between two ticks. The caller finds the age of the exposure: the
 * message states it, or the node's clock (servo/exposure_clock.h) or the camera's strobe (servo/strobe_log.h) gives it.
 * A frame older than CAMERA_LONGEST_AGE_TICKS, or exposed later than now, does not count. Cost: about 140 instructions
 * in a tick in which a message has arrived. */
#ifndef TRACKSERVO_SERVO_CAMERA_INPUT_H
#define TRACKSERVO_SERVO_CAMERA_INPUT_H

#include <stdbool.h>
#include <stdint.h>

#include "control/line_of_sight.h"
#include "control/pointing_tracker.h"

enum {
  CAMERA_LONGEST_AGE_TICKS = TARGET_TRACKER_HISTORY - 1,
  CAMERA_TIMES_PER_TICK = 100, /* of 10 us */
  CAMERA_BEST_QUALITY = 100,
  CAMERA_RESTART = 4, /* messages */
  CAMERA_RESTART_STEP = 8,
  CAMERA_COUNTERS = 256,
  CAMERA_MOST_RESTARTS = 3, /* then CAMERA_COUNTERS messages are needed */
  CAMERA_LEAD = 4,
  CAMERA_LONGEST_INTERVAL_TICKS = 200
};

#define CAMERA_AGE_AMBIGUOUS INT32_MIN /* an age that is not known, because the clock was set */

/* Meaning of `time` in a message, and whether the strobe comes first; then the message is for a frame without one. */
typedef enum {
  CAMERA_AGE = 0,
  CAMERA_NODE_CLOCK = 1,
  CAMERA_STROBE_OR_AGE = 2,
  CAMERA_STROBE_OR_CLOCK = 3
} camera_time;

/* Why the last message that did not count was dropped. */
typedef enum {
  CAMERA_NOT_DROPPED = 0,
  CAMERA_NOT_NEWER = 1,     /* repeated, out of order, or of a second sender */
  CAMERA_TOO_OLD = 2,       /* its exposure is not in the history of the line of sight */
  CAMERA_IN_FUTURE = 3,     /* exposed after now */
  CAMERA_BAD_QUALITY = 4,   /* above CAMERA_BEST_QUALITY */
  CAMERA_CLOCK_SET = 5,     /* its stamp has two readings, because the node's clock has just been set */
  CAMERA_FROZEN = 6,        /* servo/frozen_picture.h */
  CAMERA_PICTURE_WRONG = 7, /* servo/picture_check.h */
  CAMERA_BEYOND = 8,        /* its error is at the end of int16_t, or above pi, the tangent of 72 degrees */
  CAMERA_JUMPS = 9,         /* servo/jumping_picture.h */
  CAMERA_STRAY = 10         /* servo/stray_frame.h */
} camera_drop;

typedef struct {
  float scale_rad; /* image error of one count, 1e-9 .. 1e-3 */
  camera_mounting mounting;
  uint8_t mirrored;    /* 1: x of the message counts against the sensor's rows */
  uint8_t time;        /* camera_time */
  uint8_t min_quality; /* a target of less counts as not found, 1 .. CAMERA_BEST_QUALITY */
} camera_input_params;

typedef struct {
  int16_t x; /* target minus line of sight along the sensor's rows, in counts */
  int16_t y; /* along its columns, upwards */
  uint16_t time;
  uint8_t quality; /* 0: no target found; up to CAMERA_BEST_QUALITY */
  uint8_t counter;
} camera_message;

typedef struct {
  bool heard;           /* a message has counted */
  uint8_t last_counter; /* of the newest message that counted */
  uint8_t before;       /* counter of the message before, whether it counted or not */
  uint8_t backwards;    /* messages in a row that were behind the one before, up to CAMERA_RESTART */
  uint16_t restarts;    /* messages in a row that were not newer, and whose counters advance */
  uint8_t begun;        /* how often a sender has begun anew, up to CAMERA_MOST_RESTARTS */
  uint16_t in_order;    /* messages that were newer since it began anew, up to CAMERA_COUNTERS */
  uint32_t last_tick;   /* when a message came, whether it counted or not */
  float interval_ticks; /* mean between two counters, of the last messages; 0: not known */
  bool rolled;          /* `roll` is of `roll_rad`: computed when it changes, because it takes 60 instructions */
  float roll_rad;
  rotation roll;
  uint32_t taken;   /* messages that counted */
  uint32_t missed;  /* skipped counters */
  uint32_t dropped; /* messages that did not count */
  bool repeated;    /* the last message that was not newer had the counter of the one before */
  camera_drop last_drop;
} camera_input;

/* Returns CONTROL_OK, or why these parameters are refused. */
control_status camera_input_check(const camera_input_params *params);

/* Lets the next sender that begins anew need no more than CAMERA_RESTART messages. */
static inline void camera_input_expect_restarts(camera_input *input) { input->begun = 0; }

/* Forgets all messages. */
void camera_input_reset(camera_input *input);

/* Returns how far the target is from where it is to be held, by a message. Call between two ticks. */
image_vector camera_input_error(camera_input *input, const camera_input_params *params, const camera_message *message);

/* Drops a message that never gets to camera_input_take. */
void camera_input_refuse(camera_input *input, camera_drop why);

/* Takes a message whose exposure is `age` old in tick `tick`, in 10 us; negative: later; and with its error. Returns
 * its frame, which is fresh if the message counts. */
pointing_frame camera_input_take(camera_input *input, const camera_input_params *params, const camera_message *message,
                                 image_vector error, int32_t age, uint32_t tick);

/* Counts the message that was just taken as dropped instead. */
void camera_input_take_back(camera_input *input, camera_drop why);

#endif
