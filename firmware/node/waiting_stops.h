/* SPDX-License-Identifier: Apache-2.0 */
/* Controlwords that stop, from frames that cannot wait: too short, replaced before a SYNC, or dropped from a full
 * queue. Each takes effect in a tick of its own, after the controlword that was written before it. */
#ifndef TRACKSERVO_NODE_WAITING_STOPS_H
#define TRACKSERVO_NODE_WAITING_STOPS_H

#include <stdint.h>

enum { WAITING_STOPS = 8 };

/* All zero: none waits. */
typedef struct {
  uint16_t word[WAITING_STOPS]; /* the oldest first */
  uint8_t count;
} waiting_stops;

/* Adds one, if it is not the last one again. When there is no room, the last one becomes both: each bit that stops. */
void waiting_stops_add(waiting_stops *self, uint16_t controlword);

/* Returns the oldest one, which no longer waits. Call only if there is one. */
uint16_t waiting_stops_take(waiting_stops *self);

#endif
