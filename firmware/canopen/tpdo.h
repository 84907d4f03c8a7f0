/* SPDX-License-Identifier: Apache-2.0 */
/* Transmit PDO: from the mapped objects into a frame.
 *
 * Standard: CiA 301 v4.2.0, clause 7.2.2 and 7.5.2.37: types 254 and 255 are sent when a mapped object with OD_EVENT
 * changes or the event timer ends, type 0 at the SYNC after such a change, types 1 to 240 at every n-th SYNC. The
 * inhibit time holds in all event-driven cases; a frame that the bus does not accept is sent again. */
#ifndef TRACKSERVO_CANOPEN_TPDO_H
#define TRACKSERVO_CANOPEN_TPDO_H

#include "canopen/pdo.h"

typedef struct {
  pdo_map map;
  const pdo_communication *communication;
  bool on; /* valid, with at least one mapped object */
  bool synchronous;
  bool event;          /* something to send since the last frame */
  bool waiting;        /* `frame` was sampled at SYNC and not yet accepted by the bus */
  bool sync_started;   /* the start value of the SYNC counter has been received */
  uint8_t sync_count;  /* SYNCs since the last frame */
  uint8_t due;         /* frames requested by SYNCs */
  uint16_t inhibit_ms; /* time left */
  uint16_t elapsed_ms; /* since the last frame */
  can_frame frame;     /* last frame sent, or frame to send */
} tpdo;

/* Takes its parameters, resolves the mapping and restarts: call it whenever one of them has changed. `communication`
 * stays unchanged. */
void tpdo_configure(tpdo *self, const object_dictionary *dictionary, const pdo_communication *communication,
                    const pdo_mapping *mapping);

/* Restarts, as on entering OPERATIONAL: an event-driven PDO is sent once, so that listeners get the initial values. */
void tpdo_reset(tpdo *self);

/* Takes the application's event: the PDO is sent when type and inhibit time allow. */
void tpdo_request(tpdo *self);

/* Takes a SYNC with its counter, 0 without one. The next tpdo_tick samples and sends the requested frame. */
void tpdo_sync(tpdo *self, uint8_t counter);

/* Counts one ms and sends what is due. */
void tpdo_tick(tpdo *self, const can_sender *sender);

/* Returns whether tpdo_tick has anything to do. */
static inline bool tpdo_is_monitored(const tpdo *self) {
  return self->on && (self->due != 0 || self->waiting || !self->synchronous);
}

#endif
