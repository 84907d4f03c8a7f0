/* SPDX-License-Identifier: Apache-2.0 */
/* Access of the bus to the parameters of an axis: the hooks of its dictionary part (0x2000 to 0x2070).
 *
 * Writes go to the staged set; 0x2070:1 applies it, discards it or undoes the last apply. An inconsistent set is
 * refused with 0604 0043 before anything changes; so is one that is not stable on the identified plant (0x2056). The
 * check takes some 50 ms, in which the SDO client waits. 0x2070:1 = 4 applies without it, while the lock is open. */
#ifndef TRACKSERVO_NODE_OBJECTS_TUNING_OBJECTS_H
#define TRACKSERVO_NODE_OBJECTS_TUNING_OBJECTS_H

#include "canopen/object_dictionary.h"
#include "parameters/axis_tuning.h"
#include "protection/access_lock.h"
#include "servo/servo_board.h"

/* Owner of the part. */
typedef struct {
  axis_tuning *tuning;
  servo_board *board;
  int axis;
  const access_lock *lock; /* of the guarded ones */
} tuning_owner;

extern const od_hooks tuning_objects_hooks;

#endif
