/* SPDX-License-Identifier: Apache-2.0 */
/* The base's rates on the bus, one part for both axes: a message in one PDO (0x3076), how its numbers are meant and
 * whether they are used (0x3077), and what became of them (0x3078).
 *
 * The counter comes last: writing it hands the message over, by RPDO or SDO. What it does: servo/base_rates.h. */
#ifndef TRACKSERVO_NODE_OBJECTS_BASE_OBJECTS_H
#define TRACKSERVO_NODE_OBJECTS_BASE_OBJECTS_H

#include <stdbool.h>
#include <stdint.h>

#include "canopen/object_dictionary.h"
#include "servo/base_rates.h"

/* 0x3078:1 */
typedef enum {
  BASE_RATES_OFF = 0,
  BASE_RATES_AWAITED,
  BASE_RATES_IN_USE,
  BASE_RATES_STALE,
  BASE_RATES_OF_FIXED_BASE /* 2060:27 of an axis declares it: that axis does not use them */
} base_rates_state;

typedef struct {
  base_rates_message message; /* 0x3076 */
  base_rates_params params;   /* 0x3077 */
  uint8_t state;              /* 0x3078:1: base_rates_state */
  uint32_t taken;             /* 2 */
  uint32_t dropped;           /* 3 */
  uint8_t last_drop;          /* 4: base_rates_drop */
  float added_azimuth_rad_s;  /* 5 */
  float added_pitch_rad_s;    /* 6 */
} base_objects;

/* Offsets point into `base_objects`. */
extern const od_table base_objects_table;

/* Returns whether writing this object hands the message over, or changes what earlier messages mean. */
bool base_objects_hand_over(const od_object *object);
bool base_objects_sets_scale(const od_object *object);

#endif
