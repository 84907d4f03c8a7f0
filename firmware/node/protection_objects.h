/* The limits that protect an axis, on the bus: 0x2060, one part per axis, written only while 0x3040 is open. */
#ifndef TRACKSERVO_NODE_PROTECTION_OBJECTS_H
#define TRACKSERVO_NODE_PROTECTION_OBJECTS_H

#include "canopen/object_dictionary.h"
#include "protection/access_lock.h"
#include "protection/axis_protection.h"

/* Offsets point into `protection_limits`. */
extern const od_table protection_objects_table;

/* The owner of the part. */
typedef struct {
  protection_limits *limits;
  const access_lock *lock;
} protection_owner;

extern const od_hooks protection_objects_hooks;

/* OD_DEVICE_STATE for a row flagged OD_GUARDED while the lock is closed, else OD_OK. */
od_abort guarded_write(const access_lock *lock, const od_entry *entry);

#endif
