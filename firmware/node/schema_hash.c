/* SPDX-License-Identifier: Apache-2.0 */
#include "node/schema_hash.h"

#include "base/crc32.h"

static uint32_t add_u32(uint32_t crc, uint32_t value) {
  const uint8_t bytes[4] = {(uint8_t)value, (uint8_t)(value >> 8), (uint8_t)(value >> 16), (uint8_t)(value >> 24)};
  return crc32_add(crc, bytes, sizeof bytes);
}

/* Limits and default as stored in the union: the low word holds a float, both words an integer. */
static uint32_t add_number(uint32_t crc, const od_entry *entry, od_number number) {
  if (entry->type == OD_VISIBLE_STRING || entry->type == OD_DOMAIN) {
    return crc;
  }
  const uint64_t bits = (uint64_t)number.i;
  crc = add_u32(crc, (uint32_t)bits);
  return entry->type == OD_REAL32 ? crc : add_u32(crc, (uint32_t)(bits >> 32));
}

/* A fixed text, such as a version, is not part of the schema; nor is its length. */
static uint16_t bytes_of(const od_entry *entry) {
  return entry->type == OD_VISIBLE_STRING && entry->access == OD_CONST ? 0 : entry->bytes;
}

static uint32_t add_entry(uint32_t crc, const od_object *object) {
  const od_entry *entry = object->entry;
  crc = add_u32(crc, (uint32_t)od_index(object) << 16 | (uint32_t)entry->sub << 8 | entry->type);
  crc = add_u32(crc, (uint32_t)entry->access << 16 | bytes_of(entry));
  crc = add_number(crc, entry, entry->low);
  crc = add_number(crc, entry, entry->high);
  return add_number(crc, entry, entry->preset);
}

uint32_t schema_hash(const object_dictionary *dictionary) {
  uint32_t crc = CRC32_START;
  /* Bound: CANOPEN_PARTS. */
  for (uint32_t part = 0; part < dictionary->count; ++part) {
    const od_table *table = &dictionary->parts[part].table;
    /* Bound: rows of a table, which is constant. */
    for (uint32_t row = 0; row < table->count; ++row) {
      const od_object object = {&dictionary->parts[part], &table->entries[row]};
      crc = add_entry(crc, &object);
    }
  }
  return crc32_end(crc);
}
