/* SPDX-License-Identifier: Apache-2.0 */
/* The mapping of a PDO: the objects that its bytes belong to.
 *
 * Standard: CiA 301 v4.2.0, clause 7.5.2.36 (RPDO mapping 0x1600), 7.5.2.38 (TPDO mapping 0x1A00) and 7.4.7.1 (dummy
 * entries in an RPDO). A mapping is resolved once, when it is set. Then bytes are copied directly to or from the
 * values; the dictionary is called only for objects with limits or hooks. */
#ifndef TRACKSERVO_CANOPEN_PDO_MAP_H
#define TRACKSERVO_CANOPEN_PDO_MAP_H

#include "base/can_frame.h"
#include "canopen/object_dictionary.h"

enum { PDO_OBJECTS = 8 };

typedef enum { PDO_RECEIVE, PDO_TRANSMIT } pdo_direction;

/* Values of 0x1600 and 0x1A00: index << 16 | sub << 8 | bits. */
typedef struct {
  uint8_t count;
  uint32_t entry[PDO_OBJECTS];
} pdo_mapping;

/* One mapped object, with the data needed to move its bytes. */
typedef struct {
  const void *from; /* its value; NULL: a dummy, or an object that is read through the dictionary */
  void *to;         /* NULL: a dummy, or an object that is written through the dictionary */
  uint8_t bytes;
  bool checked;     /* a value may be refused */
  bool reported;    /* its owner is notified of a write */
  bool waits;       /* a value may have to wait for the one before it */
  od_object object; /* entry NULL: dummy */
} pdo_item;

typedef struct {
  pdo_item item[PDO_OBJECTS];
  uint8_t count;
  bool checked;       /* one of them may refuse its value */
  uint8_t waiting;    /* how many items there are up to the last that may have to wait */
  uint8_t length;     /* of the whole PDO, 0 .. 8 */
  uint8_t event_mask; /* bit n: byte n belongs to an object flagged OD_EVENT */
} pdo_map;

/* Returns OD_OK, OD_NO_OBJECT, OD_NO_SUB or OD_NOT_MAPPABLE. Entry 0 is allowed: it is not used. */
od_abort pdo_check_entry(const object_dictionary *dictionary, pdo_direction direction, uint32_t entry);

/* Resolves a mapping. Returns as pdo_check_entry, OD_NOT_MAPPABLE for an object that an RPDO has twice, or
 * OD_MAPPING_TOO_LONG above 8 objects or 8 bytes. On any refusal the map is empty. */
od_abort pdo_resolve(const object_dictionary *dictionary, pdo_direction direction, const pdo_mapping *mapping,
                     pdo_map *map);

/* Copies the current objects into the bytes of a TPDO. */
void pdo_gather(const pdo_map *map, uint8_t bytes[CAN_FRAME_BYTES]);

/* Writes all objects of an RPDO, or, if one of them refuses its value, only the stops (od_hooks.stops). Sets `refused`
 * to the object that refused, and leaves it unchanged otherwise. */
od_abort pdo_scatter(const pdo_map *map, const uint8_t bytes[CAN_FRAME_BYTES], od_object *refused);

/* Returns whether one of these values must wait until an earlier one has taken effect (od_hooks.waits). `bytes` has the
 * length of the map. */
bool pdo_must_wait(const pdo_map *map, const uint8_t *bytes);

/* Writes only the stops that lie wholly in the first `length` bytes: a stop is obeyed, whatever else the frame holds or
 * lacks. Returns whether there was one. */
bool pdo_obey_stops(const pdo_map *map, const uint8_t *bytes, uint8_t length);

#endif
