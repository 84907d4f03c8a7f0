/* What 0x1010 keeps and 0x1011 gives back: gains, limits, drive objects and communication, and the same as rows of a
 * store.
 *
 * Groups are those of canopen/storage.h. */
#ifndef TRACKSERVO_NODE_OBJECTS_KEPT_OBJECTS_H
#define TRACKSERVO_NODE_OBJECTS_KEPT_OBJECTS_H

#include "canopen/bus_settings.h"
#include "canopen/communication_profile.h"
#include "drive/drive_objects.h"
#include "hal.h"
#include "parameters/axis_parameters.h"
#include "parameters/parameter_store.h"
#include "protection/axis_protection.h"
#include "servo/servo_app.h"

enum { KEPT_MOST_ROWS = 384 };

/* Which groups. */
enum { KEPT_COMMUNICATION = 1, KEPT_APPLICATION = 2 };

typedef struct {
  axis_parameters parameters[SERVO_AXES];
  drive_objects drive[SERVO_AXES];
  protection_limits protection[SERVO_AXES];
  hal_scales scales;
  communication_objects communication;
  bus_settings bus; /* that the defaults in `communication` are for: kept with it */
} kept_objects;

/* KEPT_* bits of STORAGE_ALL, STORAGE_COMMUNICATION or STORAGE_APPLICATION. */
uint8_t kept_groups(uint8_t group);

/* Takes KEPT_* groups of `from` into `to`, of the drive and the communication only the objects that are marked as
 * stored. */
void kept_objects_copy(kept_objects *to, const kept_objects *from, uint8_t groups);

/* Whether what kept_objects_copy would copy is the same already. */
bool kept_objects_are_same(const kept_objects *kept, const kept_objects *other, uint8_t groups);

/* The communication alone, likewise. */
void kept_communication_copy(communication_objects *to, const communication_objects *from);

/* Moves what is at its default for `from` to its default for `to`: COB-IDs and inhibit times, see bus_settings.h. */
void kept_communication_follow(communication_objects *objects, const bus_settings *from, const bus_settings *to);

/* The objects of these groups that are marked as stored, as rows (`kept` is not changed; 0.3 ms on a board); answers
 * how many. More than `capacity`, or a value of more than four bytes: UINT32_MAX, which a test rules out. */
uint32_t kept_objects_to_rows(kept_objects *kept, uint8_t groups, parameter_row *rows, uint32_t capacity);

typedef struct {
  uint8_t groups;   /* KEPT_*, of which there are rows */
  uint32_t dropped; /* rows of objects that are not there any more, are not stored, or have another type */
  uint32_t missing; /* objects of these groups without a row: they keep what they had */
} kept_rows_report;

/* Puts rows over what `kept` holds, by index and sub-index; the node id and bit rate that the rows were saved under
 * become those of `kept`. False, and `kept` must not be used: a value is beyond its
 * limits. That the values fit together is kept_objects_are_good's question. */
bool kept_objects_from_rows(kept_objects *kept, const parameter_row *rows, uint32_t count, kept_rows_report *report);

/* Whether such values may be in force together; `dictionary` is the node's, for what PDOs map. Cost: builds the gains
 * of both axes. */
bool kept_objects_are_good(const kept_objects *kept, const object_dictionary *dictionary);

#endif
