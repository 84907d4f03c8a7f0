/* Transmit PDO: from the mapped objects into a frame.
 *
 * Standard: CiA 301 v4.2.0, clause 7.2.2 and 7.5.2.37: types 254 and 255 go out when a mapped object flagged OD_EVENT
 * changes or the event timer ends, type 0 at the SYNC after such a change, types 1 to 240 at every n-th SYNC. The
 * inhibit time is kept in all event-driven cases; a frame that the bus does not take is tried again. */
#ifndef TRACKSERVO_CANOPEN_TPDO_H
#define TRACKSERVO_CANOPEN_TPDO_H

#include "canopen/pdo.h"

typedef struct {
  pdo_map map;
  bool event;                     /* something to tell since the last frame */
  bool waiting;                   /* `bytes` were sampled at SYNC and not taken by the bus yet */
  bool sync_started;              /* the start value of the SYNC counter has come by */
  uint8_t sync_count;             /* SYNCs since the last frame */
  uint16_t inhibit_ms;            /* still to wait */
  uint16_t elapsed_ms;            /* since the last frame */
  uint8_t bytes[CAN_FRAME_BYTES]; /* last frame sent, or to send */
} tpdo;

/* Resolves the mapping and starts anew. */
void tpdo_configure(tpdo *self, const object_dictionary *dictionary, const pdo_mapping *mapping);

/* Starts anew, as on entering OPERATIONAL: an event-driven PDO is sent once, so that listeners know the start. */
void tpdo_reset(tpdo *self);

/* The application's event: send when type and inhibit time allow. */
void tpdo_request(tpdo *self);

/* A SYNC with its counter, 0 without one. */
void tpdo_sync(tpdo *self, const pdo_communication *communication, uint8_t counter, const can_sender *sender);

/* One ms. */
void tpdo_tick(tpdo *self, const pdo_communication *communication, const can_sender *sender);

#endif
