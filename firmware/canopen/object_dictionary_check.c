/* SPDX-License-Identifier: Apache-2.0 */
#include "canopen/object_dictionary_check.h"

#include <math.h>
#include <string.h>

static bool type_is_good(const od_entry *entry) {
  switch ((od_type)entry->type) {
    case OD_DOMAIN:
      return entry->bytes == 0;
    case OD_VISIBLE_STRING:
      return true;
    case OD_BOOLEAN:
    case OD_INTEGER8:
    case OD_INTEGER16:
    case OD_INTEGER32:
    case OD_UNSIGNED8:
    case OD_UNSIGNED16:
    case OD_UNSIGNED32:
    case OD_REAL32:
    case OD_UNSIGNED64:
      return entry->bytes == od_type_bytes((od_type)entry->type);
  }
  return false;
}

static int64_t smallest(od_type type) {
  switch (type) {
    case OD_INTEGER8:
      return INT8_MIN;
    case OD_INTEGER16:
      return INT16_MIN;
    case OD_INTEGER32:
      return INT32_MIN;
    default:
      return 0;
  }
}

static int64_t largest(od_type type) {
  switch (type) {
    case OD_BOOLEAN:
      return 1;
    case OD_INTEGER8:
      return INT8_MAX;
    case OD_INTEGER16:
      return INT16_MAX;
    case OD_INTEGER32:
      return INT32_MAX;
    case OD_UNSIGNED8:
      return UINT8_MAX;
    case OD_UNSIGNED16:
      return UINT16_MAX;
    default:
      return UINT32_MAX;
  }
}

static od_table_fault check_values(const od_entry *entry) {
  const od_type type = (od_type)entry->type;
  if (type == OD_DOMAIN) {
    return OD_TABLE_GOOD;
  }
  if (type == OD_VISIBLE_STRING) {
    const bool fits = entry->preset.text == NULL || strlen(entry->preset.text) <= entry->bytes;
    return fits ? OD_TABLE_GOOD : OD_TABLE_BAD_DEFAULT;
  }
  if (type == OD_REAL32) {
    const od_number low = entry->low;
    const od_number high = entry->high;
    if (!isfinite(low.f) || !isfinite(high.f) || low.f > high.f) {
      return OD_TABLE_BAD_LIMITS;
    }
    return entry->preset.f >= low.f && entry->preset.f <= high.f ? OD_TABLE_GOOD : OD_TABLE_BAD_DEFAULT;
  }
  if (type == OD_UNSIGNED64) {
    const uint64_t low = (uint64_t)entry->low.i;
    const uint64_t high = (uint64_t)entry->high.i;
    const uint64_t preset = (uint64_t)entry->preset.i;
    if (low > high) {
      return OD_TABLE_BAD_LIMITS;
    }
    return preset >= low && preset <= high ? OD_TABLE_GOOD : OD_TABLE_BAD_DEFAULT;
  }
  if (entry->low.i > entry->high.i || entry->low.i < smallest(type) || entry->high.i > largest(type)) {
    return OD_TABLE_BAD_LIMITS;
  }
  const bool inside = entry->preset.i >= entry->low.i && entry->preset.i <= entry->high.i;
  return inside ? OD_TABLE_GOOD : OD_TABLE_BAD_DEFAULT;
}

static bool mapping_is_good(const od_entry *entry) {
  const bool writable = entry->access == OD_RW || entry->access == OD_WO;
  const bool readable = entry->access != OD_WO;
  if ((entry->flags & (OD_RPDO | OD_TPDO)) == 0) {
    return (entry->flags & OD_EVENT) == 0;
  }
  /* A BOOLEAN is one bit in a PDO; no mapping here is finer than a byte. */
  if (entry->type == OD_VISIBLE_STRING || entry->type == OD_DOMAIN || entry->type == OD_BOOLEAN) {
    return false;
  }
  if ((entry->flags & OD_RPDO) != 0 && (entry->flags & OD_GUARDED) != 0) {
    return false; /* an RPDO has no client that could have opened a lock */
  }
  return ((entry->flags & OD_RPDO) == 0 || writable) && ((entry->flags & OD_TPDO) == 0 || readable);
}

static od_table_fault check_entry(const od_entry *entry) {
  if (!type_is_good(entry)) {
    return OD_TABLE_BAD_TYPE;
  }
  const od_table_fault fault = check_values(entry);
  if (fault != OD_TABLE_GOOD) {
    return fault;
  }
  if (!mapping_is_good(entry)) {
    return OD_TABLE_BAD_MAPPING;
  }
  if ((entry->flags & OD_STORED) != 0 && (entry->offset == OD_NO_VALUE || entry->access != OD_RW)) {
    return OD_TABLE_NOT_STORABLE;
  }
  const bool described = entry->name != NULL && entry->name[0] != '\0' && entry->unit != NULL && entry->help != NULL;
  return described ? OD_TABLE_GOOD : OD_TABLE_NO_TEXT;
}

/* `head` is the row with sub-index 0 of the same object. */
static od_table_fault check_place(const od_entry *head, const od_entry *before, const od_entry *entry) {
  if (before != NULL &&
      (entry->index < before->index || (entry->index == before->index && entry->sub <= before->sub))) {
    return OD_TABLE_UNSORTED;
  }
  if (before == NULL || before->index != entry->index) {
    return entry->sub == 0 ? OD_TABLE_GOOD : OD_TABLE_NO_HEAD;
  }
  if ((head->flags & OD_RECORD) == 0) {
    return OD_TABLE_NO_HEAD;
  }
  return entry->sub <= head->high.i ? OD_TABLE_GOOD : OD_TABLE_HEAD_TOO_LOW;
}

od_table_verdict od_check_table(const od_table *table) {
  const od_entry *head = NULL;
  /* Bound: rows of a table, which is constant; for tests and the start, not for the tick. */
  for (uint32_t i = 0; i < table->count; i++) {
    const od_entry *entry = &table->entries[i];
    od_table_fault fault = check_place(head, i == 0 ? NULL : entry - 1, entry);
    if (fault == OD_TABLE_GOOD) {
      fault = check_entry(entry);
    }
    if (fault != OD_TABLE_GOOD) {
      return (od_table_verdict){fault, entry->index, entry->sub};
    }
    head = entry->sub == 0 ? entry : head;
  }
  return (od_table_verdict){OD_TABLE_GOOD, 0, 0};
}

od_table_verdict od_check_dictionary(const object_dictionary *dictionary) {
  /* Bound: CANOPEN_PARTS. */
  for (uint32_t i = 0; i < dictionary->count; i++) {
    const od_part *part = &dictionary->parts[i];
    const object_dictionary before = {.parts = dictionary->parts, .count = i};
    const od_table_verdict verdict = od_check_table(&part->table);
    if (verdict.fault != OD_TABLE_GOOD) {
      return verdict;
    }
    /* Bound: rows of a table, which is constant. */
    for (uint32_t row = 0; row < part->table.count; row++) {
      const od_object object = {part, &part->table.entries[row]};
      od_object other;
      if (od_find(&before, od_index(&object), object.entry->sub, &other) != OD_NO_OBJECT) {
        return (od_table_verdict){OD_TABLE_OVERLAP, object.entry->index, object.entry->sub};
      }
    }
  }
  return (od_table_verdict){OD_TABLE_GOOD, 0, 0};
}
