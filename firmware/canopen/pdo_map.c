/* SPDX-License-Identifier: Apache-2.0 */
#include "canopen/pdo_map.h"

#include <string.h>

/* Indices 1 to 7 stand for a type whose bytes an RPDO skips. */
static bool is_dummy(pdo_direction direction, uint16_t index, uint8_t sub) {
  return direction == PDO_RECEIVE && index >= OD_INTEGER8 && index <= OD_UNSIGNED32 && sub == 0;
}

/* `found->entry` is NULL for a dummy. */
static od_abort find_entry(const object_dictionary *dictionary, pdo_direction direction, uint32_t entry,
                           od_object *found, uint8_t *bytes) {
  const uint16_t index = (uint16_t)(entry >> 16);
  const uint8_t sub = (uint8_t)(entry >> 8);
  const uint8_t bits = (uint8_t)entry;
  uint16_t size;
  if (is_dummy(direction, index, sub)) {
    *found = (od_object){NULL, NULL};
    size = od_type_bytes((od_type)index);
  } else {
    const od_abort answer = od_find(dictionary, index, sub, found);
    if (answer != OD_OK) {
      return answer;
    }
    const uint8_t wanted = direction == PDO_RECEIVE ? OD_RPDO : OD_TPDO;
    if ((found->entry->flags & wanted) == 0) {
      return OD_NOT_MAPPABLE;
    }
    size = found->entry->bytes;
  }
  *bytes = (uint8_t)size;
  return bits == size * 8u ? OD_OK : OD_NOT_MAPPABLE;
}

od_abort pdo_check_entry(const object_dictionary *dictionary, pdo_direction direction, uint32_t entry) {
  od_object found;
  uint8_t bytes;
  return entry == 0 ? OD_OK : find_entry(dictionary, direction, entry, &found, &bytes);
}

/* Directly to the value when its owner has no hooks. */
static pdo_item item_of(const od_object *object, uint8_t bytes) {
  pdo_item item = {.object = *object, .bytes = bytes};
  const od_entry *entry = object->entry;
  if (entry == NULL) {
    return item;
  }
  const unsigned hooks = od_needed_hooks(object);
  const bool is_number = od_type_bytes((od_type)entry->type) != 0;
  uint8_t *place = od_place(object);
  if (is_number && entry->access != OD_WO && (hooks & OD_HOOK_REFRESH) == 0) {
    item.from = place != NULL ? (const void *)place : &entry->preset;
  }
  const bool executes = (hooks & OD_HOOK_EXECUTE) != 0;
  item.to = is_number && !executes ? place : NULL;
  item.checked =
      (hooks & OD_HOOK_ACCEPT) != 0 || entry->access == OD_CONST || entry->access == OD_RO || !od_is_unlimited(entry);
  item.reported = (hooks & OD_HOOK_CHANGED) != 0 || executes || !is_number;
  item.waits = (hooks & OD_HOOK_WAITS) != 0;
  return item;
}

/* Of one that is received twice in a frame, only the last value would be seen: a stop could be lost. */
static bool is_mapped(const pdo_map *map, const od_object *object) {
  bool found = false;
  /* Bound: PDO_OBJECTS: copied from such an object. */
  for (uint8_t i = 0; i < map->count; i++) {
    const od_object *other = &map->item[i].object;
    found = found || (object->entry != NULL && other->entry == object->entry && other->part == object->part);
  }
  return found;
}

static void add(pdo_map *map, const od_object *object, uint8_t bytes) {
  const pdo_item item = item_of(object, bytes);
  map->item[map->count] = item;
  map->checked = map->checked || item.checked;
  if (object->entry != NULL && (object->entry->flags & OD_EVENT) != 0) {
    map->event_mask = (uint8_t)(map->event_mask | ((1u << bytes) - 1u) << map->length);
  }
  map->count++;
  map->waiting = item.waits ? map->count : map->waiting;
  map->length = (uint8_t)(map->length + bytes);
}

od_abort pdo_resolve(const object_dictionary *dictionary, pdo_direction direction, const pdo_mapping *mapping,
                     pdo_map *map) {
  *map = (pdo_map){.count = 0};
  pdo_map wanted = {.count = 0};
  if (mapping->count > PDO_OBJECTS) {
    return OD_MAPPING_TOO_LONG;
  }
  /* Bound: PDO_OBJECTS: the limit of the object behind it, 0x1600:0 and 0x1A00:0. */
  for (uint8_t i = 0; i < mapping->count; i++) {
    od_object found;
    uint8_t bytes = 0;
    const od_abort answer = find_entry(dictionary, direction, mapping->entry[i], &found, &bytes);
    if (answer != OD_OK) {
      return answer;
    }
    if (direction == PDO_RECEIVE && is_mapped(&wanted, &found)) {
      return OD_NOT_MAPPABLE;
    }
    if (wanted.length + bytes > CAN_FRAME_BYTES) {
      return OD_MAPPING_TOO_LONG;
    }
    add(&wanted, &found, bytes);
  }
  *map = wanted;
  return OD_OK;
}

static void read_item(const pdo_item *item, uint8_t *bytes) {
  uint16_t length = 0;
  if (item->object.entry == NULL || od_read(&item->object, bytes, item->bytes, &length) != OD_OK) {
    memset(bytes, 0, item->bytes);
  }
}

void pdo_gather(const pdo_map *map, uint8_t bytes[CAN_FRAME_BYTES]) {
  uint8_t *place = bytes;
  const pdo_item *end = &map->item[map->count];
  /* Bound: PDO_OBJECTS: the items of a map. */
  for (const pdo_item *item = map->item; item < end; item++) {
    const uint8_t size = item->bytes; /* read once: `place` might point to it */
    if (item->from != NULL) {
      od_copy_number(place, item->from, size);
    } else {
      read_item(item, place);
    }
    place += size;
  }
}

/* A value that is already set has been accepted: most masters send the same mode in every frame. */
static bool is_there(const pdo_item *item, const uint8_t *bytes) {
  return item->to != NULL && od_same_number(item->to, bytes, item->bytes);
}

static od_abort check(const pdo_map *map, const uint8_t *bytes, od_object *refused) {
  od_abort answer = OD_OK;
  /* Bound: PDO_OBJECTS: copied from such an object. */
  for (uint8_t i = 0; i < map->count && answer == OD_OK; i++) {
    const pdo_item *item = &map->item[i];
    if (item->checked && !is_there(item, bytes)) {
      answer = od_check_write(&item->object, bytes, item->bytes);
      *refused = answer != OD_OK ? item->object : *refused;
    }
    bytes += item->bytes;
  }
  return answer;
}

static od_abort write_item(const pdo_item *item, const uint8_t *bytes) {
  if (item->to != NULL) {
    od_copy_number(item->to, bytes, item->bytes);
    if (item->reported) {
      item->object.part->hooks->changed(item->object.part->owner, &item->object);
    }
    return OD_OK;
  }
  return item->reported ? od_write_checked(&item->object, bytes, item->bytes) : OD_OK;
}

bool pdo_must_wait(const pdo_map *map, const uint8_t *bytes) {
  bool waits = false;
  const pdo_item *end = &map->item[map->waiting];
  /* Bound: PDO_OBJECTS: the items of a map. */
  for (const pdo_item *item = map->item; item < end; item++) {
    waits = waits || (item->waits && !is_there(item, bytes) && /* seldom: a command changes */
                      item->object.part->hooks->waits(item->object.part->owner, &item->object));
    bytes += item->bytes;
  }
  return waits;
}

bool pdo_obey_stops(const pdo_map *map, const uint8_t *bytes, uint8_t length) {
  bool obeyed = false;
  uint8_t end = 0;
  /* Bound: PDO_OBJECTS: copied from such an object. */
  for (uint8_t i = 0; i < map->count; i++) {
    const pdo_item *item = &map->item[i];
    end = (uint8_t)(end + item->bytes);
    if (end <= length && item->object.entry != NULL && od_is_stop(&item->object, bytes)) {
      if (!od_defer_stop(&item->object, bytes)) {
        (void)write_item(item, bytes);
      }
      obeyed = true;
    }
    bytes += item->bytes;
  }
  return obeyed;
}

od_abort pdo_scatter(const pdo_map *map, const uint8_t bytes[CAN_FRAME_BYTES], od_object *refused) {
  od_abort answer = map->checked ? check(map, bytes, refused) : OD_OK;
  if (answer != OD_OK) {
    (void)pdo_obey_stops(map, bytes, map->length);
    return answer;
  }
  const uint8_t *place = bytes;
  const pdo_item *end = &map->item[map->count];
  /* Bound: PDO_OBJECTS: the items of a map. */
  for (const pdo_item *item = map->item; item < end; item++) {
    const od_abort written = write_item(item, place);
    if (written != OD_OK && answer == OD_OK) {
      answer = written;
      *refused = item->object;
    }
    place += item->bytes;
  }
  return answer;
}
