/* SPDX-License-Identifier: Apache-2.0 */
/* The scales of the board's current and voltage sensors on the bus: 0x3060, one part for both axes.
 *
 * Written only while 0x3040 is open and both axes are off; takes effect at once (hal_set_scales). */
#ifndef TRACKSERVO_NODE_OBJECTS_BOARD_OBJECTS_H
#define TRACKSERVO_NODE_OBJECTS_BOARD_OBJECTS_H

#include "base/status.h"
#include "canopen/object_dictionary.h"
#include "hal.h"

/* Offsets point into `hal_scales`. */
extern const od_table board_objects_table;

/* Returns CONTROL_OK if the scales are within the ranges of the table. */
control_status board_objects_check(const hal_scales *scales);

#endif
