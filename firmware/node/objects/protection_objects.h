/* SPDX-License-Identifier: Apache-2.0 */
/* The limits that protect an axis, on the bus: 0x2060, one part per axis, written only while 0x3040 is open
 * and both axes are off; and what follows from them, 0x2061.
 *
 *     written, one by one -> contradict each other? -> no: in force, all of them, from the next tick on
 *                                                   -> yes: wait; what was in force stays so (2060:18 says which)
 *
 * So any order of writes that ends in a consistent set works, and no inconsistent set is ever in effect. A read returns
 * the written value. */
#ifndef TRACKSERVO_NODE_OBJECTS_PROTECTION_OBJECTS_H
#define TRACKSERVO_NODE_OBJECTS_PROTECTION_OBJECTS_H

#include "canopen/object_dictionary.h"
#include "drive/drive_objects.h"
#include "protection/access_lock.h"
#include "protection/axis_protection.h"
#include "protection/start_position.h"

typedef struct {
  protection_limits written; /* first: for the stored rows a protection_limits alone is enough */
  uint8_t waiting;           /* 2060:18: PROTECTION_* and PROTECTION_SOFT_TRAVEL bits */
  uint8_t reduced_speed;     /* 2062 */
  uint32_t changes;          /* of the limits in force, on purpose: counted for guarded_sets.h */
  uint8_t restrictions;      /* 2061:1; the node renews 2061:1 to 2061:4, :6 and :7 */
  int8_t turn;               /* 2061:2 */
  int8_t lowest_turn;        /* 2061:3 */
  int8_t highest_turn;       /* 2061:4 */
  int8_t confirmed_turn;     /* 2061:5 */
  float fastest_down_rad_s;  /* 2061:6 */
  float fastest_up_rad_s;    /* 2061:7 */
} protection_objects;

/* 607D:1 is above 607D:2; the last consistent travel stays in effect. */
enum { PROTECTION_SOFT_TRAVEL = 4 };

/* Offsets point into `protection_objects`. */
extern const od_table protection_objects_table;

/* The owner of the part. */
typedef struct {
  protection_objects *objects;
  protection_limits *in_force;
  start_position *start;            /* takes the confirmed turn */
  const drive_limit_objects *drive; /* of the same axis */
  const access_lock *lock;
} protection_owner;

extern const od_hooks protection_objects_hooks;

/* Returns which limits are written but not in effect, as bits of 2060:18. */
uint8_t protection_objects_waiting(const protection_owner *own);

/* Returns whether the caller may change guarded values now: OD_OK, or OD_DEVICE_STATE while its lock is closed or an
 * axis has torque. */
od_abort guarded_change(const access_lock *lock);

/* Returns the same for a write to a row; OD_OK for a row without OD_GUARDED. */
od_abort guarded_write(const access_lock *lock, const od_entry *entry);

#endif
