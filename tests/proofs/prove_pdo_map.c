/* SPDX-License-Identifier: Apache-2.0 */
/* PDO mapping, for every mapping record (any count, any eight entries), both directions, on objects of any type, size,
 * access and flags:
 * - a map has at most 8 objects and 8 bytes; its length is the sum of its objects' bytes; its event bits lie within it;
 * - a refused mapping leaves an empty map;
 * - only an object that this direction allows is mapped, with its size in bits;
 * - no access outside the map; no shift or sum out of range.
 * The dictionary is replaced by its contract: any of two arbitrary objects, or a refusal. No bound: the loop over the
 * eight entries is complete. */
#include "canopen/pdo_map.h"

#include "any_dictionary.h"
#include "proof.h"

static uint8_t memory[8];

unsigned od_needed_hooks(const od_object *object) {
  (void)object;
  return any_u8() & 15u;
}

bool od_is_unlimited(const od_entry *entry) {
  (void)entry;
  return any_bool();
}

uint8_t *od_place(const od_object *object) {
  (void)object;
  return any_bool() ? memory : NULL;
}

static od_entry any_entry(void) {
  od_entry entry = {0};
  entry.type = any_u8();
  entry.access = any_u8() & 3u;
  entry.flags = any_u8();
  entry.bytes = any_u16();
  return entry;
}

int main(void) {
  const object_dictionary dictionary = {&part, 1, NULL};
  one = any_entry();
  other = any_entry();
  pdo_mapping mapping = {.count = any_u8()};
  for (int i = 0; i < PDO_OBJECTS; ++i) {
    mapping.entry[i] = any_u32();
  }
  const pdo_direction direction = any_bool() ? PDO_RECEIVE : PDO_TRANSMIT;
  pdo_map map;
  const od_abort answer = pdo_resolve(&dictionary, direction, &mapping, &map);
  REQUIRE(map.count <= PDO_OBJECTS && map.length <= CAN_FRAME_BYTES, "at most 8 objects and 8 bytes");
  REQUIRE(map.event_mask >> map.length == 0, "event bits lie within the PDO");
  REQUIRE(map.count == (answer == OD_OK ? mapping.count : 0) && (answer == OD_OK || map.length == 0),
          "a refused mapping leaves an empty map");
  uint32_t sum = 0;
  for (int i = 0; i < PDO_OBJECTS; ++i) {
    if (i < map.count) {
      const od_entry *entry = map.item[i].object.entry;
      sum += map.item[i].bytes;
      REQUIRE((mapping.entry[i] & 0xFFu) == 8u * map.item[i].bytes, "an object is mapped with its size in bits");
      REQUIRE(entry == NULL || (entry->flags & (direction == PDO_RECEIVE ? OD_RPDO : OD_TPDO)) != 0,
              "an object is mapped in a direction that it allows");
      REQUIRE(entry != NULL || direction == PDO_RECEIVE, "only a received PDO has dummies");
    }
  }
  REQUIRE(map.length == sum, "the length is the sum of the bytes");
  return 0;
}
