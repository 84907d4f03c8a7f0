#include "canopen/object_dictionary.h"

#include <math.h>
#include <string.h>

uint16_t od_type_bytes(od_type type) {
  switch (type) {
    case OD_BOOLEAN:
    case OD_INTEGER8:
    case OD_UNSIGNED8:
      return 1;
    case OD_INTEGER16:
    case OD_UNSIGNED16:
      return 2;
    case OD_INTEGER32:
    case OD_UNSIGNED32:
    case OD_REAL32:
      return 4;
    case OD_UNSIGNED64:
      return 8;
    case OD_VISIBLE_STRING:
    case OD_DOMAIN:
      break;
  }
  return 0;
}

uint16_t od_index(const od_object *object) { return (uint16_t)(object->entry->index + object->part->shift); }

static uint32_t key_of(uint32_t index, uint8_t sub) { return index << 8 | sub; }

/* First row of the table whose key is not below the wanted one; count if there is none. */
static uint32_t lower_bound(const od_table *table, uint32_t key) {
  uint32_t first = 0;
  uint32_t length = table->count;
  while (length > 0) {
    const uint32_t half = length / 2;
    const od_entry *middle = &table->entries[first + half];
    if (key_of(middle->index, middle->sub) < key) {
      first += half + 1;
      length -= half + 1;
    } else {
      length = half;
    }
  }
  return first;
}

od_abort od_find(const object_dictionary *dictionary, uint16_t index, uint8_t sub, od_object *object) {
  od_abort answer = OD_NO_OBJECT;
  for (uint32_t i = 0; i < dictionary->count; i++) {
    const od_part *part = &dictionary->parts[i];
    if (index < part->shift) {
      continue;
    }
    const uint32_t own_index = (uint32_t)index - part->shift;
    const uint32_t row = lower_bound(&part->table, key_of(own_index, 0));
    if (row == part->table.count || part->table.entries[row].index != own_index) {
      continue;
    }
    answer = OD_NO_SUB;
    const uint32_t exact = lower_bound(&part->table, key_of(own_index, sub));
    if (exact < part->table.count && part->table.entries[exact].index == own_index &&
        part->table.entries[exact].sub == sub) {
      object->part = part;
      object->entry = &part->table.entries[exact];
      return OD_OK;
    }
  }
  return answer;
}

static uint8_t *place_of(const od_object *object) {
  return object->entry->offset == OD_NO_VALUE ? NULL : (uint8_t *)object->part->values + object->entry->offset;
}

static bool is_signed(od_type type) { return type == OD_INTEGER8 || type == OD_INTEGER16 || type == OD_INTEGER32; }

static uint64_t load_native(const uint8_t *place, uint16_t size) {
  uint8_t u8;
  uint16_t u16;
  uint32_t u32;
  uint64_t u64;
  switch (size) {
    case 1:
      memcpy(&u8, place, sizeof u8);
      return u8;
    case 2:
      memcpy(&u16, place, sizeof u16);
      return u16;
    case 4:
      memcpy(&u32, place, sizeof u32);
      return u32;
    default:
      memcpy(&u64, place, sizeof u64);
      return u64;
  }
}

static void store_native(uint8_t *place, uint16_t size, uint64_t bits) {
  const uint8_t u8 = (uint8_t)bits;
  const uint16_t u16 = (uint16_t)bits;
  const uint32_t u32 = (uint32_t)bits;
  switch (size) {
    case 1:
      memcpy(place, &u8, sizeof u8);
      break;
    case 2:
      memcpy(place, &u16, sizeof u16);
      break;
    case 4:
      memcpy(place, &u32, sizeof u32);
      break;
    default:
      memcpy(place, &bits, sizeof bits);
      break;
  }
}

static od_number number_from_bits(od_type type, uint64_t bits) {
  od_number number = {.i = 0};
  if (type == OD_REAL32) {
    const uint32_t u32 = (uint32_t)bits;
    memcpy(&number.f, &u32, sizeof u32);
    return number;
  }
  const uint16_t size = od_type_bytes(type);
  const uint64_t sign = (uint64_t)1 << (8u * size - 1u);
  if (is_signed(type) && (bits & sign) != 0) {
    bits |= ~(sign | (sign - 1u));
  }
  memcpy(&number.i, &bits, sizeof bits); /* two's complement, also above INT64_MAX */
  return number;
}

static uint64_t bits_of(od_type type, od_number number) {
  uint64_t bits = 0;
  if (type == OD_REAL32) {
    uint32_t u32;
    memcpy(&u32, &number.f, sizeof u32);
    return u32;
  }
  memcpy(&bits, &number.i, sizeof bits);
  return bits;
}

od_number od_get(const od_object *object) {
  const od_entry *entry = object->entry;
  const uint8_t *place = place_of(object);
  if (place == NULL || entry->type == OD_DOMAIN) {
    return entry->preset;
  }
  if (entry->type == OD_VISIBLE_STRING) {
    return (od_number){.text = (const char *)place};
  }
  return number_from_bits((od_type)entry->type, load_native(place, od_type_bytes((od_type)entry->type)));
}

/* Length of a text that fills `capacity` bytes or ends before. */
static uint16_t text_length(const char *text, uint16_t capacity) {
  uint16_t length = 0;
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
  uint8_t *place = place_of(object);
  if (place == NULL || entry->type == OD_DOMAIN) {
    return;
  }
  if (entry->type == OD_VISIBLE_STRING) {
    put_text(place, entry->bytes, value.text, text_length(value.text, entry->bytes));
    return;
  }
  store_native(place, od_type_bytes((od_type)entry->type), bits_of((od_type)entry->type, value));
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
  const od_number value = od_get(object);
  if (entry->type == OD_VISIBLE_STRING) {
    *length = text_length(value.text, entry->bytes);
    if (*length > 0) {
      memcpy(bytes, value.text, *length);
    }
    return OD_OK;
  }
  const uint64_t bits = bits_of((od_type)entry->type, value);
  *length = od_type_bytes((od_type)entry->type);
  for (uint16_t i = 0; i < *length; i++) {
    bytes[i] = (uint8_t)(bits >> (8u * i));
  }
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
  for (uint16_t i = 0; i < length; i++) {
    if (bytes[i] < 0x20 || bytes[i] > 0x7E) {
      return OD_BAD_VALUE;
    }
  }
  return OD_OK;
}

static od_number number_from_bytes(od_type type, const uint8_t *bytes) {
  uint64_t bits = 0;
  for (uint16_t i = 0; i < od_type_bytes(type); i++) {
    bits |= (uint64_t)bytes[i] << (8u * i);
  }
  return number_from_bits(type, bits);
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

od_abort od_write(const od_object *object, const uint8_t *bytes, uint16_t length) {
  const od_entry *entry = object->entry;
  const od_hooks *hooks = object->part->hooks;
  const od_abort answer = od_check_write(object, bytes, length);
  if (answer != OD_OK) {
    return answer;
  }
  if (entry->type == OD_VISIBLE_STRING) {
    uint8_t *place = place_of(object);
    if (place != NULL) {
      put_text(place, entry->bytes, (const char *)bytes, length);
    }
  } else {
    od_put(object, number_from_bytes((od_type)entry->type, bytes));
  }
  if (hooks != NULL && hooks->changed != NULL) {
    hooks->changed(object->part->owner, object);
  }
  return OD_OK;
}

void od_restore_defaults(const od_part *part, uint8_t node_id) {
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
  for (uint32_t i = 0; i < table->count; i++) {
    const od_entry *entry = &table->entries[i];
    if ((entry->flags & OD_STORED) != 0 && entry->offset != OD_NO_VALUE) {
      memcpy((char *)to + entry->offset, (const char *)from + entry->offset, entry->bytes);
    }
  }
}
