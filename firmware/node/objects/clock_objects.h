/* SPDX-License-Identifier: Apache-2.0 */
/* The node's clock on the bus, 0x1013.
 *
 * Standard: CiA 301 v4.2.0, clause 7.5.2.16: high-resolution time stamp, UNSIGNED32 in us, mappable. A read gives the
 * present time. A write sets it: the value is the time at which its frame began, or of a synchronous PDO its SYNC. What
 * it means for frames of the camera: servo/exposure_clock.h. */
#ifndef TRACKSERVO_NODE_OBJECTS_CLOCK_OBJECTS_H
#define TRACKSERVO_NODE_OBJECTS_CLOCK_OBJECTS_H

#include <stdint.h>

#include "canopen/object_dictionary.h"

typedef struct {
  uint32_t time_us; /* of the last read or write */
} clock_objects;

/* Offsets point into `clock_objects`. */
extern const od_table clock_objects_table;

#endif
