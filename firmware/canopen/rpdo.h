/* SPDX-License-Identifier: Apache-2.0 */
/* Receive PDO: from a frame into the mapped objects.
 *
 * Standard: CiA 301 v4.2.0, clause 7.2.2 and 7.5.2.35: types 254 and 255 take effect at once, types 0 to 240 at the
 * next SYNC; the event timer monitors silence. A frame that is too short, or whose values are not all acceptable,
 * changes nothing, except that a stop in it is obeyed (od_hooks.stops): at once if the frame is too short. */
#ifndef TRACKSERVO_CANOPEN_RPDO_H
#define TRACKSERVO_CANOPEN_RPDO_H

#include "canopen/pdo.h"

typedef struct {
  pdo_map map;
  bool on;     /* valid, with at least one mapped object */
  bool speaks; /* a frame is a word of the master: not all of its objects take what a sensor measures */
  bool synchronous;
  uint16_t monitored_ms; /* maximum silence; 0: not monitored */
  bool heard;            /* silence is monitored from the first frame on */
  bool late;             /* silence has been reported */
  bool wrong_length;     /* the last frame was too short, */
  bool was_too_short;    /* or one since rpdo_take_errors was called */
  bool waiting;          /* `bytes` wait for SYNC */
  uint16_t silent_ms;
  uint32_t refused;        /* frames with a value that its object refused */
  uint32_t refused_object; /* of the last frame: index << 8 | sub-index; 0: it was accepted */
  uint32_t was_refused;    /* the same of the last frame that was refused since rpdo_take_errors was called */
  uint8_t bytes[CAN_FRAME_BYTES];
} rpdo;

typedef enum {
  RPDO_IGNORED, /* it is off, or nothing waited */
  RPDO_WAITS,   /* for SYNC */
  RPDO_APPLIED,
  RPDO_REFUSED, /* a value out of its range; this and the next are errors */
  RPDO_TOO_SHORT
} rpdo_verdict;

/* Takes its parameters, resolves the mapping and discards all frames: call it whenever one of them has changed. */
void rpdo_configure(rpdo *self, const object_dictionary *dictionary, const pdo_communication *communication,
                    const pdo_mapping *mapping);

/* Discards all frames. */
void rpdo_reset(rpdo *self);

/* Returns whether a data frame with its identifier, or the values that wait for SYNC if `frame` is NULL, must wait
 * until an earlier value has taken effect (od_hooks.waits). */
bool rpdo_must_wait(const rpdo *self, const can_frame *frame);

/* Obeys only the stops in such a frame; its other values are lost. */
void rpdo_obey_stops(rpdo *self, const can_frame *frame);

/* Takes a data frame with its identifier. Accepts frames that are longer than the mapping, and ignores the rest. */
rpdo_verdict rpdo_receive(rpdo *self, const can_frame *frame);

/* Writes the frame that waits for SYNC. Returns RPDO_IGNORED when none does. */
rpdo_verdict rpdo_sync(rpdo *self);

typedef struct {
  bool short_one;          /* a frame was too short */
  uint32_t refused_object; /* index << 8 | sub-index; 0: no frame was refused */
} rpdo_errors;

/* Returns what was wrong with the last frame, or with one since the last call. */
rpdo_errors rpdo_take_errors(rpdo *self);

/* Counts one ms. Returns true once, when the PDO has been silent for its event time. */
bool rpdo_tick(rpdo *self);

/* Returns whether its last frame, or its silence, is an error to report. */
static inline bool rpdo_is_bad(const rpdo *self) {
  return self->wrong_length || self->late || self->refused_object != 0;
}

/* Returns whether rpdo_tick has anything to do. */
static inline bool rpdo_is_monitored(const rpdo *self) { return self->monitored_ms != 0 && self->heard && !self->late; }

#endif
