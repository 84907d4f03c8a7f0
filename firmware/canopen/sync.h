/* SPDX-License-Identifier: Apache-2.0 */
/* SYNC consumer: the network's common clock for synchronous PDOs.
 *
 * Standard: CiA 301 v4.2.0, clause 7.2.5, objects 0x1005 (COB-ID), 0x1006 (communication cycle period) and 0x1019
 * (synchronous counter overflow value). The node passes each frame with the SYNC identifier to `sync_receive` and runs
 * its synchronous PDOs when that returns a SYNC. */
#ifndef TRACKSERVO_CANOPEN_SYNC_H
#define TRACKSERVO_CANOPEN_SYNC_H

#include "base/can_frame.h"

typedef struct {
  uint32_t cob_id;    /* 0x1005; bits 0..10 */
  uint32_t period_us; /* 0x1006; 0: absence is not monitored */
  uint8_t overflow;   /* 0x1019; 0: SYNC without counter, else 2..240 and SYNC brings one byte */
} sync_objects;

typedef struct {
  bool heard; /* a SYNC has been received since the start */
  bool late;  /* absence has been reported */
  uint32_t silent_us;
  uint8_t counter; /* of the last SYNC; 0 without counter */
} sync_consumer;

typedef enum {
  SYNC_GOOD,
  SYNC_WRONG_LENGTH /* the length differs from 0x1019: not a SYNC, to be reported as EMCY 8240 */
} sync_verdict;

void sync_reset(sync_consumer *consumer);

sync_verdict sync_receive(sync_consumer *consumer, const sync_objects *objects, const can_frame *frame);

/* Counts one ms. Returns true once, when no SYNC came for one and a half periods. */
bool sync_tick(sync_consumer *consumer, const sync_objects *objects);

#endif
