/* What 0x1010 keeps and 0x1011 gives back: gains, drive objects and communication, in two sets.
 *
 * `stored` is what a reset comes back to, `factory` what the node was started with. Both live in RAM: they survive a
 * reset of the node, not a loss of power. Groups are those of canopen/storage.h. */
#ifndef TRACKSERVO_NODE_KEPT_OBJECTS_H
#define TRACKSERVO_NODE_KEPT_OBJECTS_H

#include "app/servo_app.h"
#include "canopen/communication_profile.h"
#include "drive/drive_objects.h"
#include "parameters/axis_parameters.h"

typedef struct {
  axis_parameters parameters[SERVO_AXES];
  drive_objects drive[SERVO_AXES];
  communication_objects communication;
} kept_objects;

/* Takes a group of `from` into `to`, of the drive and the communication only the objects that are marked as stored. */
void kept_objects_copy(kept_objects *to, const kept_objects *from, uint8_t group);

#endif
