/* SPDX-License-Identifier: Apache-2.0 */
/* What the node expects of its master, on the bus, one part for both axes: the lock of guarded parameters (0x3040) and
 * the supervision (0x3041).
 *
 * 0x3040 belongs to the SDO channel of the request: what it shows and what it opens. An axis that turns while nobody
 * has spoken to the node for 0x3041:1 does what its 0x6007 says. A frame for the node is what canopen_node_silent_ms
 * counts as one. */
#ifndef TRACKSERVO_NODE_OBJECTS_MASTER_OBJECTS_H
#define TRACKSERVO_NODE_OBJECTS_MASTER_OBJECTS_H

#include "canopen/object_dictionary.h"
#include "protection/access_lock.h"

typedef struct {
  uint16_t lock_left_s;        /* 0x3040:2 */
  uint8_t lock_has_word;       /* 0x3040:5 */
  uint16_t lock_delay_s;       /* 0x3040:6 */
  uint16_t longest_silence_ms; /* 0x3041:1 */
  uint32_t stops;              /* 0x3041:2 */
} master_objects;

/* Offsets point into `master_objects`. */
extern const od_table master_objects_table;

/* The owner of the part. */
typedef struct {
  master_objects *objects;
  access_lock *lock;
  /* Stores the hash of the owner's word, 0 for none; OD_PENDING until it is in flash. */
  od_abort (*store_word)(void *context, uint64_t hash);
  void *context;
} master_owner;

extern const od_hooks master_objects_hooks;

#endif
