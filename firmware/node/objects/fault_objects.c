/* SPDX-License-Identifier: Apache-2.0 */
#include "node/objects/fault_objects.h"

#include <string.h>

#include "canopen/object_dictionary_rows.h"

enum { LOG_OBJECT = 0x3020, LOG_COMMAND = 2, FIRST_ENTRY = 3, COMMAND_CLEAR = 1 };
enum { HEADER_BYTES = 8 };

#define U32_HIGHEST INT64_C(0xFFFFFFFF)
#define ENTRY(sub_, number_) \
  OD_STREAM(0x3020, sub_, OD_RO, "Fault log entry " #number_, "Format: node/fault_objects.h; entry 1 is the newest")

static const od_entry kEntries[] = {
    OD_RECORD_HEAD(0x3020, 10, "Fault log", "The last faults with the signals recorded before them"),
    OD_U32(0x3020, 1, OD_RO, 0, fault_objects, count, 0, U32_HIGHEST, 0, "", "Fault log count",
           "Entries written since the log was cleared; the last eight are kept"),
    OD_U8(0x3020, 2, OD_RW, 0, fault_objects, command, 0, 1, 0, "", "Fault log command", "1: clear all entries"),
    ENTRY(3, 1),
    ENTRY(4, 2),
    ENTRY(5, 3),
    ENTRY(6, 4),
    ENTRY(7, 5),
    ENTRY(8, 6),
    ENTRY(9, 7),
    ENTRY(10, 8),
};

const od_table fault_objects_table = {kEntries, sizeof kEntries / sizeof kEntries[0]};

static bool is_at(const od_object *object, uint16_t index, uint8_t sub) {
  return object->entry->index == index && object->entry->sub == sub;
}

static od_abort refresh(void *owner, const od_object *object) {
  const fault_objects_owner *own = owner;
  (void)object;
  own->objects->count = own->log->count;
  return OD_OK;
}

static void changed(void *owner, const od_object *object) {
  const fault_objects_owner *own = owner;
  if (is_at(object, LOG_OBJECT, LOG_COMMAND) && own->objects->command == COMMAND_CLEAR) {
    fault_log_clear(own->log);
    own->objects->command = 0;
  }
}

static const fault_log_entry *entry_of(const fault_objects_owner *own, const od_object *object) {
  return fault_log_find(own->log, (uint32_t)object->entry->sub - FIRST_ENTRY);
}

static od_abort stream_begin(void *owner, const od_object *object, bool writing, uint32_t *size) {
  const fault_log_entry *entry = entry_of(owner, object);
  (void)writing;
  *size = entry == NULL ? 0 : HEADER_BYTES + entry->samples * (uint32_t)sizeof(fault_log_sample);
  return entry == NULL ? OD_NO_DATA : OD_OK;
}

/* Word `n` of an entry in the byte order of the bus. */
static uint32_t word_of(const fault_log_entry *entry, uint32_t n) {
  if (n == 0) {
    return entry->tick;
  }
  if (n == 1) {
    return entry->fault | (uint32_t)entry->source << 8 | (uint32_t)entry->samples << 16 |
           (uint32_t)FAULT_LOG_SIGNALS << 24;
  }
  const uint32_t value = n - HEADER_BYTES / 4;
  float signals[FAULT_LOG_SIGNALS];
  uint32_t word;
  memcpy(signals, &entry->before[value / FAULT_LOG_SIGNALS], sizeof signals);
  memcpy(&word, &signals[value % FAULT_LOG_SIGNALS], sizeof word);
  return word;
}

/* A fault that comes while an entry is read shifts the entries: what was read then mixes two entries, and must be read
 * again.
 */
static od_abort stream_read(void *owner, const od_object *object, uint32_t offset, uint8_t *bytes, uint32_t length) {
  const fault_log_entry *entry = entry_of(owner, object);
  const uint32_t size = entry == NULL ? 0 : HEADER_BYTES + entry->samples * (uint32_t)sizeof(fault_log_sample);
  if (offset > size || length > size - offset) {
    return OD_NO_DATA;
  }
  /* Bound: 7 bytes of an SDO segment. */
  for (uint32_t i = 0; i < length; ++i) {
    const uint32_t place = offset + i;
    bytes[i] = (uint8_t)(word_of(entry, place / 4) >> (8 * (place % 4)));
  }
  return OD_OK;
}

const od_hooks fault_objects_hooks = {
    .refresh = refresh, .changed = changed, .stream_begin = stream_begin, .stream_read = stream_read};
