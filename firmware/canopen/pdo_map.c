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

static void add(pdo_map *map, const od_object *object, uint8_t bytes) {
  map->object[map->count] = *object;
  map->bytes[map->count] = bytes;
  if (object->entry != NULL && (object->entry->flags & OD_EVENT) != 0) {
    map->event_mask = (uint8_t)(map->event_mask | ((1u << bytes) - 1u) << map->length);
  }
  map->count++;
  map->length = (uint8_t)(map->length + bytes);
}

od_abort pdo_resolve(const object_dictionary *dictionary, pdo_direction direction, const pdo_mapping *mapping,
                     pdo_map *map) {
  *map = (pdo_map){.count = 0};
  pdo_map wanted = {.count = 0};
  if (mapping->count > PDO_OBJECTS) {
    return OD_MAPPING_TOO_LONG;
  }
  for (uint8_t i = 0; i < mapping->count; i++) {
    od_object found;
    uint8_t bytes = 0;
    const od_abort answer = find_entry(dictionary, direction, mapping->entry[i], &found, &bytes);
    if (answer != OD_OK) {
      return answer;
    }
    if (wanted.length + bytes > CAN_FRAME_BYTES) {
      return OD_MAPPING_TOO_LONG;
    }
    add(&wanted, &found, bytes);
  }
  *map = wanted;
  return OD_OK;
}

void pdo_gather(const pdo_map *map, uint8_t bytes[CAN_FRAME_BYTES]) {
  uint8_t place = 0;
  memset(bytes, 0, CAN_FRAME_BYTES);
  for (uint8_t i = 0; i < map->count; i++) {
    uint16_t length = 0;
    (void)od_read(&map->object[i], &bytes[place], map->bytes[i], &length); /* a refusal leaves zeros */
    place = (uint8_t)(place + map->bytes[i]);
  }
}

od_abort pdo_scatter(const pdo_map *map, const uint8_t bytes[CAN_FRAME_BYTES]) {
  uint8_t place = 0;
  for (uint8_t i = 0; i < map->count; i++) {
    if (map->object[i].entry != NULL) {
      const od_abort answer = od_check_write(&map->object[i], &bytes[place], map->bytes[i]);
      if (answer != OD_OK) {
        return answer;
      }
    }
    place = (uint8_t)(place + map->bytes[i]);
  }
  place = 0;
  for (uint8_t i = 0; i < map->count; i++) {
    if (map->object[i].entry != NULL) {
      od_write_checked(&map->object[i], &bytes[place], map->bytes[i]);
    }
    place = (uint8_t)(place + map->bytes[i]);
  }
  return OD_OK;
}
