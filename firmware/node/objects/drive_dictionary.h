/* SPDX-License-Identifier: Apache-2.0 */
/* The rows of one axis' CiA 402 objects, 0x603F to 0x6502.
 *
 * The offsets point into `drive_objects`. The table serves both axes, the second shifted by 0x800. Units are those of
 * 60A8 and 60A9 (1e-7 rad, 1e-6 rad/s); CiA 402-2 gives names and types. */
#ifndef TRACKSERVO_NODE_OBJECTS_DRIVE_DICTIONARY_H
#define TRACKSERVO_NODE_OBJECTS_DRIVE_DICTIONARY_H

#include "canopen/object_dictionary.h"

extern const od_table drive_objects_table;

#endif
