/* SPDX-License-Identifier: Apache-2.0 */
/* Compares the node's clock with that of the SYNC producer: the ticks between many SYNCs against their period 0x1006.
 *
 * A window begins at a SYNC and ends at the first one after 2 s. An interval that is not between half and one and a
 * half periods (a lost or additional frame) begins a new window. A window deviates if its length differs from its SYNCs
 * times the period by more than 0.7 % and 3 ms: that is more than the jitter of both its ends. The clock is off after
 * two such windows, and no longer off after one that does not deviate. So a deviation of 1 % is found within 7 s, and
 * one of 0.5 % is not. Which of the two clocks is wrong cannot be decided. Cost: about 10 instructions a tick, 25 a
 * SYNC. */
#ifndef TRACKSERVO_CANOPEN_SYNC_CLOCK_H
#define TRACKSERVO_CANOPEN_SYNC_CLOCK_H

#include <stdbool.h>
#include <stdint.h>

typedef struct {
  bool open;         /* a window has begun */
  uint32_t ticks;    /* since it began */
  uint32_t interval; /* ticks since the last SYNC */
  uint32_t syncs;    /* in it */
  int deviating;     /* windows in a row, counted up to 2 */
  bool off;
} sync_clock;

/* Forgets all SYNCs. Call it when the period changes. */
void sync_clock_reset(sync_clock *clock);

/* Takes a SYNC, with the period of 0x1006; compares nothing if that is 0 or above 1 s. Returns whether `off` has
 * changed. */
bool sync_clock_hear(sync_clock *clock, uint32_t period_us);

/* Counts one ms of this node. */
void sync_clock_tick(sync_clock *clock);

#endif
