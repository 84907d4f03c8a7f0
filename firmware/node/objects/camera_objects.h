/* The camera on the bus, one part for both axes: a frame in one PDO (0x3070), how its numbers are meant (0x3071), what
 * became of the frames (0x3072), and how old they really are (0x3073).
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

enum { CAMERA_DELAY_UNKNOWN = 0xFFFF };

typedef struct {
  camera_message message;     /* 0x3070 */
  camera_input_params params; /* 0x3071 */
  uint32_t taken;             /* 0x3072:1 */
  uint32_t missed;            /* 2 */
  uint32_t dropped;           /* 3 */
  uint8_t last_drop;          /* camera_drop */
  uint8_t azimuth_tracking;   /* drive_tracking */
  uint8_t pitch_tracking;
  uint8_t age_ms;            /* of the newest frame that counted */
  uint16_t clock;            /* modulo 2^16 */
  camera_delay_params delay; /* 0x3073:1 .. 3 */
  uint8_t dither_s;          /* 4: time left */
  int16_t delay_error;       /* 5: true minus stated age, 10 us */
  uint16_t delay_half_width; /* 6: of its 95 % interval, 10 us; CAMERA_DELAY_UNKNOWN */
  int8_t correction_ms;      /* 7 */
  bool arrived;              /* a frame waits for the tick */
} camera_objects;

/* Offsets point into `camera_objects`. */
extern const od_table camera_objects_table;

/* The owner of the part is its `camera_objects`. */
extern const od_hooks camera_objects_hooks;

#endif
