/* SPDX-License-Identifier: Apache-2.0 */
/* The camera on the bus, one part for both axes: a frame in one PDO (0x3070), how its numbers are meant (0x3071), what
 * became of the frames (0x3072), how old they really are (0x3073), the camera's strobe (0x3074), and when the line of
 * sight will be back on a target that is too fast or outside of the azimuth's travel (0x3075).
 *
 * A frame is 8 bytes in the order of 0x3070. Its counter comes last: writing it hands the frame over, by RPDO or SDO,
 * in every NMT state in which that service exists. What counts as a frame: servo/camera_input.h. */
#ifndef TRACKSERVO_NODE_OBJECTS_CAMERA_OBJECTS_H
#define TRACKSERVO_NODE_OBJECTS_CAMERA_OBJECTS_H

#include <stdbool.h>
#include <stdint.h>

#include "canopen/object_dictionary.h"
#include "servo/camera_delay.h"
#include "servo/camera_input.h"
#include "servo/strobe_log.h"

enum { CAMERA_DELAY_UNKNOWN = 0xFFFF, CAMERA_ROLL_COUNTS_PER_RAD = 10000 };

typedef enum { CAMERA_WITHIN_TRAVEL = 0, CAMERA_TARGET_OUTSIDE = 1, CAMERA_TURNS_BACK = 2 } camera_wrap_state;

typedef struct {
  camera_message message;     /* 0x3070 */
  camera_input_params params; /* 0x3071 */
  uint16_t stated_delay;      /* 0x3071:8, 10 us */
  uint32_t taken;             /* 0x3072:1 */
  uint32_t missed;            /* 2 */
  uint32_t dropped;           /* 3 */
  uint8_t last_drop;          /* camera_drop */
  uint8_t azimuth_tracking;   /* drive_tracking */
  uint8_t pitch_tracking;
  uint8_t age_ms;            /* of the newest frame that counted */
  uint16_t clock;            /* modulo 2^16 */
  uint8_t picture_verdict;   /* 0x3072:9 */
  int16_t picture_roll;      /* 10 */
  camera_delay_params delay; /* 0x3073:1 .. 3 */
  uint8_t dither_s;          /* 4: time left */
  int16_t delay_error;       /* 5: true minus stated age, 10 us */
  uint16_t delay_half_width; /* 6: of its 95 % interval, 10 us; CAMERA_DELAY_UNKNOWN */
  int8_t correction_ms;      /* 7 */
  uint8_t turn_back;         /* 0x3075:2: allowed */
  strobe_params strobe;      /* 0x3074:1 .. 3 */
  uint32_t strobe_time_us;   /* 4: the newest edge, in the node's clock (0x1013) */
  uint32_t strobe_edges;
  uint32_t strobe_paired;
  uint32_t strobe_unpaired;
  uint8_t strobe_refusal; /* strobe_refusal */
  uint32_t strobe_missing;
  uint32_t strobe_additional;
  uint32_t strobe_floods;
  uint8_t time_source; /* of the newest frame: CAMERA_AGE, CAMERA_NODE_CLOCK or CAMERA_STROBE_OR_AGE */
  uint8_t wrap_state;  /* 0x3075:3: camera_wrap_state */
  uint16_t strobe_age; /* of the newest frame that was paired, 10 us */
  uint16_t back_in_ms; /* 0x3075:1 */
} camera_objects;

/* Offsets point into `camera_objects`. */
extern const od_table camera_objects_table;

/* Returns whether writing this object hands the frame over. */
bool camera_objects_hand_over(const od_object *object);

#endif
