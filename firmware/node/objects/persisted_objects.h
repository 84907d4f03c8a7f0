/* SPDX-License-Identifier: Apache-2.0 */
/* The objects that 0x1010 saves and 0x1011 restores: gains, limits, drive objects and communication; also as rows of a
 * store.
 *
 * Groups are those of canopen/storage.h. */
#ifndef TRACKSERVO_NODE_OBJECTS_KEPT_OBJECTS_H
#define TRACKSERVO_NODE_OBJECTS_KEPT_OBJECTS_H

#include "canopen/bus_settings.h"
#include "canopen/communication_profile.h"
#include "drive/drive_objects.h"
#include "hal.h"
#include "node/objects/base_objects.h"
#include "node/objects/camera_objects.h"
#include "node/objects/master_objects.h"
#include "parameters/axis_parameters.h"
#include "parameters/parameter_store.h"
#include "protection/axis_protection.h"
#include "servo/servo_app.h"

enum { PERSISTED_MAX_ROWS = 480 };

/* Which groups. 0x1010 and 0x1011 leave the last one as it is: 0x3040:4 sets the owner's word. */
enum { PERSISTED_COMMUNICATION = 1, PERSISTED_APPLICATION = 2, PERSISTED_ACCESS = 4 };

typedef struct {
  axis_parameters parameters[SERVO_AXES];
  drive_objects drive[SERVO_AXES];
  protection_limits protection[SERVO_AXES];
  hal_scales scales;
  master_objects master;
  camera_objects camera;
  base_objects base;
  communication_objects communication;
  uint32_t access_hash[2]; /* of the owner's word, low word first; 0: none */
  bus_settings bus;        /* node id and bit rate to which the defaults in `communication` belong: persisted with it */
} persisted_objects;

/* Returns the PERSISTED_* bits of STORAGE_ALL, STORAGE_COMMUNICATION or STORAGE_APPLICATION. */
uint8_t retained_groups(uint8_t group);

/* Copies PERSISTED_* groups of `from` into `to`; of the drive and the communication only the objects that are marked as
 * stored. */
void persisted_objects_copy(persisted_objects *to, const persisted_objects *from, uint8_t groups);

/* Returns whether the objects that persisted_objects_copy would copy are equal already. */
bool persisted_objects_are_same(const persisted_objects *kept, const persisted_objects *other, uint8_t groups);

/* Copies the communication objects that are marked as stored. */
void persisted_communication_copy(communication_objects *to, const communication_objects *from);

/* Moves values with the defaults for `from` to the defaults for `to`: COB-IDs and inhibit times; see bus_settings.h. */
void persisted_communication_follow(communication_objects *objects, const bus_settings *from, const bus_settings *to);

/* Writes the objects of these groups that are marked as stored as rows (`kept` is not changed; 0.3 ms on a board).
 * Returns their number, or UINT32_MAX for more than `capacity` rows or a value of more than four bytes; a test excludes
 * both. */
uint32_t persisted_objects_to_rows(persisted_objects *kept, uint8_t groups, parameter_row *rows, uint32_t capacity);

typedef struct {
  uint8_t groups;   /* PERSISTED_*, groups with rows */
  uint32_t dropped; /* rows of objects that no longer exist, are not stored, or have another type */
  uint32_t missing; /* objects of these groups without a row: they keep their values */
} persisted_rows_report;

/* Writes rows over the values in `kept`, by index and sub-index; the node id and bit rate under which the rows were
 * saved become those of `kept`. Returns false when a value is beyond its limits; `kept` must not be used then.
 * persisted_objects_are_good checks whether the values fit together. */
bool persisted_objects_from_rows(persisted_objects *kept, const parameter_row *rows, uint32_t count,
                                 persisted_rows_report *report);

/* Returns whether all guarded values are equal. */
bool persisted_objects_same_guarded(const persisted_objects *one, const persisted_objects *other);

/* Returns whether these values may be in effect together; `dictionary` is the node's, for the mapped objects of PDOs.
 * Cost: builds the gains of both axes. */
bool persisted_objects_are_good(const persisted_objects *kept, const object_dictionary *dictionary);

#endif
