/* SPDX-License-Identifier: Apache-2.0 */
#include "canopen/object_dictionary.h"

#include <math.h>

uint16_t od_index(const od_object *object) { return (uint16_t)(object->entry->index + object->part->shift); }

static uint32_t key_of(uint32_t index, uint8_t sub) { return index << 8 | sub; }

/* Index and sub-index are above the type in the first word of an entry. */
static uint32_t key_at(const od_entry *entry) {
  _Static_assert(offsetof(od_entry, type) == 0 && offsetof(od_entry, sub) == 1 && offsetof(od_entry, index) == 2,
                 "type, sub-index and index are one word");
  uint32_t word;
  memcpy(&word, entry, sizeof word);
  return word >> 8;
}

/* First row of the table whose key is not below the required one; count if there is none. */
static uint32_t lower_bound(const od_table *table, uint32_t key) {
  uint32_t first = 0;
  uint32_t length = table->count;
  /* Bound: 32: length is halved each time. */
  while (length > 0) {
    const uint32_t half = length / 2;
    const od_entry *middle = &table->entries[first + half];
    if (key_at(middle) < key) {
      first += half + 1;
      length -= half + 1;
    } else {
      length = half;
    }
  }
  return first;
}

static bool has_index(const od_table *table, uint32_t row, uint32_t index) {
  return row < table->count && table->entries[row].index == index;
}

void od_group_parts(od_groups *groups, const od_part *parts, uint32_t count) {
  *groups = (od_groups){{0}};
  /* Bound: OD_GROUPED_PARTS. */
  for (uint32_t i = 0; i < count && i < OD_GROUPED_PARTS; i++) {
    const od_table *table = &parts[i].table;
    /* Bound: rows of a table, which is constant; at the start, not in the tick. */
    for (uint32_t row = 0; row < table->count; row++) {
      const uint16_t index = (uint16_t)(table->entries[row].index + parts[i].shift);
      groups->parts[index >> OD_GROUP_SHIFT] |= UINT32_C(1) << i;
    }
  }
}

static od_abort find_in(const od_part *part, uint16_t index, uint8_t sub, od_object *object) {
  const od_table *table = &part->table;
  const uint32_t own_index = (uint32_t)index - part->shift; /* wraps when below the part, and is then too large */
  if (table->count == 0 || own_index < table->entries[0].index || own_index > table->entries[table->count - 1].index) {
    return OD_NO_OBJECT;
  }
  const uint32_t row = lower_bound(table, key_of(own_index, sub));
  if (has_index(table, row, own_index) && table->entries[row].sub == sub) {
    object->part = part;
    object->entry = &table->entries[row];
    return OD_OK;
  }
  const bool other_sub = has_index(table, row, own_index) || (row > 0 && has_index(table, row - 1, own_index));
  return other_sub ? OD_NO_SUB : OD_NO_OBJECT;
}

od_abort od_find(const object_dictionary *dictionary, uint16_t index, uint8_t sub, od_object *object) {
  const od_groups *groups = dictionary->groups;
  uint32_t candidates = groups != NULL ? groups->parts[index >> OD_GROUP_SHIFT] : UINT32_MAX;
  od_abort answer = OD_NO_OBJECT;
  /* Bound: CANOPEN_PARTS. */
  for (uint32_t i = 0; i < dictionary->count && candidates != 0 && answer != OD_OK; i++) {
    if ((candidates & 1u) != 0) {
      const od_abort here = find_in(&dictionary->parts[i], index, sub, object);
      answer = here == OD_NO_OBJECT ? answer : here;
    }
    candidates >>= 1;
  }
  return answer;
}

uint8_t *od_place(const od_object *object) {
  return object->entry->offset == OD_NO_VALUE ? NULL : (uint8_t *)object->part->values + object->entry->offset;
}

unsigned od_needed_hooks(const od_object *object) {
  const od_hooks *hooks = object->part->hooks;
  if (hooks == NULL) {
    return 0;
  }
  const unsigned given = (hooks->refresh != NULL ? OD_HOOK_REFRESH : 0u) |
                         (hooks->accept != NULL ? OD_HOOK_ACCEPT : 0u) |
                         (hooks->changed != NULL ? OD_HOOK_CHANGED : 0u) |
                         (hooks->execute != NULL ? OD_HOOK_EXECUTE : 0u) | (hooks->waits != NULL ? OD_HOOK_WAITS : 0u);
  return hooks->needed == NULL ? given : given & hooks->needed(object);
}

bool od_is_unlimited(const od_entry *entry) {
  const int64_t low = entry->low.i;
  const int64_t high = entry->high.i;
  switch (entry->type) {
    case OD_INTEGER8:
      return low <= INT8_MIN && high >= INT8_MAX;
    case OD_INTEGER16:
      return low <= INT16_MIN && high >= INT16_MAX;
    case OD_INTEGER32:
      return low <= INT32_MIN && high >= INT32_MAX;
    case OD_UNSIGNED8:
      return low <= 0 && high >= UINT8_MAX;
    case OD_UNSIGNED16:
      return low <= 0 && high >= UINT16_MAX;
    case OD_UNSIGNED32:
      return low <= 0 && high >= UINT32_MAX;
    default:
      return false;
  }
}

/* A value has the same bytes in memory and on the bus. */
_Static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "CANopen is little-endian, and so must the machine be");

static int16_t load_i16(const uint8_t *bytes) {
  int16_t value;
  memcpy(&value, bytes, sizeof value);
  return value;
}

static int32_t load_i32(const uint8_t *bytes) {
  int32_t value;
  memcpy(&value, bytes, sizeof value);
  return value;
}

static od_number number_from_bytes(od_type type, const uint8_t *bytes) {
  od_number number = {.i = 0};
  switch (type) {
    case OD_BOOLEAN:
    case OD_UNSIGNED8:
      number.i = bytes[0];
      break;
    case OD_INTEGER8:
      number.i = bytes[0] < 0x80 ? bytes[0] : bytes[0] - 0x100;
      break;
    case OD_UNSIGNED16:
      number.i = (uint16_t)load_i16(bytes);
      break;
    case OD_INTEGER16:
      number.i = load_i16(bytes);
      break;
    case OD_UNSIGNED32:
      number.i = (uint32_t)load_i32(bytes);
      break;
    case OD_INTEGER32:
      number.i = load_i32(bytes);
      break;
    case OD_REAL32:
      memcpy(&number.f, bytes, sizeof number.f);
      break;
    case OD_UNSIGNED64:
      memcpy(&number.i, bytes, sizeof number.i);
      break;
    case OD_VISIBLE_STRING:
    case OD_DOMAIN:
      break;
  }
  return number;
}

od_number od_get(const od_object *object) {
  const od_entry *entry = object->entry;
  const uint8_t *place = od_place(object);
  if (place == NULL || entry->type == OD_DOMAIN) {
    return entry->preset;
  }
  if (entry->type == OD_VISIBLE_STRING) {
    return (od_number){.text = (const char *)place};
  }
  return number_from_bytes((od_type)entry->type, place);
}

od_number od_default(const od_object *object) {
  const od_entry *entry = object->entry;
  const void *defaults = object->part->defaults;
  if (defaults == NULL || (entry->flags & OD_STORED) == 0 || entry->offset == OD_NO_VALUE) {
    return entry->preset;
  }
  return number_from_bytes((od_type)entry->type, (const uint8_t *)defaults + entry->offset);
}

/* Length of a text that fills `capacity` bytes or ends earlier. */
static uint16_t text_length(const char *text, uint16_t capacity) {
  uint16_t length = 0;
  /* Bound: capacity: the bytes of an entry, whose row is constant. */
  while (text != NULL && length < capacity && text[length] != '\0') {
    length++;
  }
  return length;
}

static void put_text(uint8_t *place, uint16_t capacity, const char *text, uint16_t length) {
  memset(place, 0, capacity);
  if (length > 0) {
    memcpy(place, text, length < capacity ? length : capacity);
  }
}

void od_put(const od_object *object, od_number value) {
  const od_entry *entry = object->entry;
  uint8_t *place = od_place(object);
  if (place == NULL || entry->type == OD_DOMAIN) {
    return;
  }
  if (entry->type == OD_VISIBLE_STRING) {
    put_text(place, entry->bytes, value.text, text_length(value.text, entry->bytes));
    return;
  }
  od_copy_number(place, &value, entry->bytes);
}

od_abort od_read(const od_object *object, uint8_t *bytes, uint16_t capacity, uint16_t *length) {
  const od_entry *entry = object->entry;
  const od_hooks *hooks = object->part->hooks;
  if (entry->access == OD_WO) {
    return OD_WRITE_ONLY;
  }
  if (entry->type == OD_DOMAIN || entry->bytes > capacity) {
    return OD_UNSUPPORTED;
  }
  if (hooks != NULL && hooks->refresh != NULL) {
    const od_abort answer = hooks->refresh(object->part->owner, object);
    if (answer != OD_OK) {
      return answer;
    }
  }
  if (entry->type == OD_VISIBLE_STRING) {
    const char *text = od_get(object).text;
    *length = text_length(text, entry->bytes);
    if (*length > 0) {
      memcpy(bytes, text, *length);
    }
    return OD_OK;
  }
  const uint8_t *place = od_place(object);
  od_copy_number(bytes, place != NULL ? (const void *)place : &entry->preset, entry->bytes);
  *length = entry->bytes;
  return OD_OK;
}

static od_abort check_real(const od_entry *entry, float value) {
  if (isnan(value)) {
    return OD_BAD_VALUE;
  }
  if (value > entry->high.f || (isinf(value) && value > 0.0f)) {
    return OD_TOO_HIGH;
  }
  return value < entry->low.f || isinf(value) ? OD_TOO_LOW : OD_OK;
}

static od_abort check_number(const od_entry *entry, od_number value) {
  if (entry->type == OD_REAL32) {
    return check_real(entry, value.f);
  }
  if (entry->type == OD_UNSIGNED64) {
    if ((uint64_t)value.i > (uint64_t)entry->high.i) {
      return OD_TOO_HIGH;
    }
    return (uint64_t)value.i < (uint64_t)entry->low.i ? OD_TOO_LOW : OD_OK;
  }
  if (value.i > entry->high.i) {
    return OD_TOO_HIGH;
  }
  return value.i < entry->low.i ? OD_TOO_LOW : OD_OK;
}

/* Only printable ASCII, CiA 301 clause 7.1.6. */
static od_abort check_text(const od_entry *entry, const uint8_t *bytes, uint16_t length) {
  if (length > entry->bytes) {
    return OD_TOO_LONG;
  }
  /* Bound: the bytes of an entry, checked just before. */
  for (uint16_t i = 0; i < length; i++) {
    if (bytes[i] < 0x20 || bytes[i] > 0x7E) {
      return OD_BAD_VALUE;
    }
  }
  return OD_OK;
}

od_abort od_check_write(const od_object *object, const uint8_t *bytes, uint16_t length) {
  const od_entry *entry = object->entry;
  const od_hooks *hooks = object->part->hooks;
  if (entry->access == OD_CONST || entry->access == OD_RO) {
    return OD_READ_ONLY;
  }
  if (entry->type == OD_DOMAIN) {
    return OD_UNSUPPORTED;
  }
  if (entry->type == OD_VISIBLE_STRING) {
    return check_text(entry, bytes, length);
  }
  if (length != entry->bytes) {
    return length > entry->bytes ? OD_TOO_LONG : OD_TOO_SHORT;
  }
  const od_number value = number_from_bytes((od_type)entry->type, bytes);
  const od_abort answer = check_number(entry, value);
  if (answer != OD_OK || hooks == NULL || hooks->accept == NULL) {
    return answer;
  }
  return hooks->accept(object->part->owner, object, value);
}

bool od_is_stop(const od_object *object, const uint8_t *bytes) {
  const od_hooks *hooks = object->part->hooks;
  return hooks != NULL && hooks->stops != NULL &&
         hooks->stops(object, number_from_bytes((od_type)object->entry->type, bytes));
}

bool od_defer_stop(const od_object *object, const uint8_t *bytes) {
  const od_hooks *hooks = object->part->hooks;
  if (hooks->waits == NULL || hooks->defer == NULL || !hooks->waits(object->part->owner, object)) {
    return false;
  }
  hooks->defer(object->part->owner, object, number_from_bytes((od_type)object->entry->type, bytes));
  return true;
}

bool od_must_wait(const od_object *object, const uint8_t *bytes) {
  const od_hooks *hooks = object->part->hooks;
  const uint8_t *place = od_place(object);
  return hooks != NULL && hooks->waits != NULL && place != NULL &&
         !od_same_number(place, bytes, object->entry->bytes) && hooks->waits(object->part->owner, object);
}

static od_abort execute(const od_object *object, const uint8_t *bytes) {
  const od_hooks *hooks = object->part->hooks;
  if (od_must_wait(object, bytes)) {
    return OD_PENDING;
  }
  const od_type type = (od_type)object->entry->type;
  if (hooks == NULL || hooks->execute == NULL || type == OD_VISIBLE_STRING) {
    return OD_OK;
  }
  return hooks->execute(object->part->owner, object, number_from_bytes(type, bytes));
}

od_abort od_write_checked(const od_object *object, const uint8_t *bytes, uint16_t length) {
  const od_entry *entry = object->entry;
  const od_hooks *hooks = object->part->hooks;
  const od_abort answer = execute(object, bytes);
  if (answer != OD_OK) {
    return answer;
  }
  uint8_t *place = od_place(object);
  if (place != NULL && entry->type == OD_VISIBLE_STRING) {
    put_text(place, entry->bytes, (const char *)bytes, length);
  } else if (place != NULL) {
    od_copy_number(place, bytes, entry->bytes);
  }
  if (hooks != NULL && hooks->changed != NULL) {
    hooks->changed(object->part->owner, object);
  }
  return OD_OK;
}

od_abort od_write(const od_object *object, const uint8_t *bytes, uint16_t length) {
  const od_abort answer = od_check_write(object, bytes, length);
  return answer == OD_OK ? od_write_checked(object, bytes, length) : answer;
}

void od_restore_defaults(const od_part *part, uint8_t node_id) {
  /* Bound: rows of a table, which is constant. */
  for (uint32_t i = 0; i < part->table.count; i++) {
    const od_object object = {part, &part->table.entries[i]};
    od_number preset = object.entry->preset;
    if ((object.entry->flags & OD_NODE_ID) != 0) {
      preset.i += node_id;
    }
    od_put(&object, preset);
  }
}

void od_copy_stored(const od_table *table, const void *from, void *to) {
  /* Bound: rows of a table, which is constant. */
  for (uint32_t i = 0; i < table->count; i++) {
    const od_entry *entry = &table->entries[i];
    if ((entry->flags & OD_STORED) != 0 && entry->offset != OD_NO_VALUE) {
      memcpy((char *)to + entry->offset, (const char *)from + entry->offset, entry->bytes);
    }
  }
}

static bool are_same(const od_table *table, const void *one, const void *other, uint8_t flag) {
  bool same = true;
  /* Bound: rows of a table, which is constant. */
  for (uint32_t i = 0; i < table->count && same; i++) {
    const od_entry *entry = &table->entries[i];
    if ((entry->flags & flag) != 0 && entry->offset != OD_NO_VALUE) {
      same = memcmp((const char *)one + entry->offset, (const char *)other + entry->offset, entry->bytes) == 0;
    }
  }
  return same;
}

bool od_same_stored(const od_table *table, const void *one, const void *other) {
  return are_same(table, one, other, OD_STORED);
}

bool od_same_guarded(const od_table *table, const void *one, const void *other) {
  return are_same(table, one, other, OD_GUARDED);
}
