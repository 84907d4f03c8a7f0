/* SPDX-License-Identifier: Apache-2.0 */
/* The fault log on the bus: 0x3020. */
#ifndef TRACKSERVO_NODE_OBJECTS_FAULT_OBJECTS_H
#define TRACKSERVO_NODE_OBJECTS_FAULT_OBJECTS_H

#include "canopen/object_dictionary.h"
#include "protection/fault_log.h"

typedef struct {
  uint32_t count; /* 0x3020:1 */
  uint8_t command;
} fault_objects;

/* Offsets point into `fault_objects`. 0x3020:3 .. 10 are the entries, newest first, each a DOMAIN, little endian:
 *   0 tick u32, 4 fault u8, 5 whose u8 (0 azimuth, 1 pitch, 2 the board: n is 0 then), 6 samples n u8, 7 signals m u8,
 * 8 n rows of m REAL32, oldest first, in the order of `fault_log_sample`. */
extern const od_table fault_objects_table;

/* The owner of the part. */
typedef struct {
  fault_objects *objects;
  fault_log *log;
} fault_objects_owner;

extern const od_hooks fault_objects_hooks;

#endif
