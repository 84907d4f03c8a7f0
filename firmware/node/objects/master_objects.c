/* SPDX-License-Identifier: Apache-2.0 */
#include "node/objects/master_objects.h"

#include "canopen/object_dictionary_rows.h"
#include "servo/servo_timing.h"

enum { LOCK = 0x3040, SUB_SHORT_WORD = 1, SUB_WORD = 3, SUB_NEW_WORD = 4 };

/* A word is compared, or hashed, and never kept. */
#define WORD(type_, bytes_, sub_, highest_, name_, help_)                                                     \
  {                                                                                                           \
    .index = LOCK, .sub = (sub_), .type = (type_), .access = OD_WO, .bytes = (bytes_), .offset = OD_NO_VALUE, \
    .low = {.i = 0}, .high = {.i = (highest_)}, .preset = {.i = 0}, OD_TEXTS(name_, "", help_)                \
  }

#define U32_HIGHEST INT64_C(0xFFFFFFFF)
#define U64_HIGHEST INT64_C(-1)

static const od_entry kEntries[] = {
    OD_RECORD_HEAD(LOCK, 6, "Access",
                   "Lock of the guarded parameters, for the SDO channel of the request: 2055, 2060, 3060"),
    WORD(OD_UNSIGNED32, 4, SUB_SHORT_WORD, U32_HIGHEST, "Access word",
         "\"open\" (6E65706F), or an owner's word of up to 4 letters: guarded parameters can be written for 60 s; 0 "
         "locks "
         "them"),
    OD_U16(LOCK, 2, OD_RO, 0, master_objects, lock_left_s, 0, 65535, 0, "s", "Access time left", "0: locked"),
    WORD(OD_UNSIGNED64, 8, SUB_WORD, U64_HIGHEST, "Owner's access word",
         "As 3040:1, for a word of up to 8 letters, the first in the lowest byte, filled with 0"),
    WORD(OD_UNSIGNED64, 8, SUB_NEW_WORD, U64_HIGHEST, "New access word",
         "Replaces the word, while the lock is open and no axis has torque; stored at once; 0: no word, 3040:1 takes "
         "\"open\""),
    OD_U8(LOCK, 5, OD_RO, 0, master_objects, lock_has_word, 0, 1, 0, "", "Access word is set",
          "0: no, the word is \"open\"; 1: the owner has set a word"),
    OD_U16(LOCK, 6, OD_RO, 0, master_objects, lock_delay_s, 0, 65535, 0, "s", "Access delay left",
           "After a wrong word no other is accepted for this time"),
    OD_RECORD_HEAD(0x3041, 2, "Master supervision", "What happens when the master is silent; see 6007"),
    OD_U16(0x3041, 1, OD_RW, OD_STORED, master_objects, longest_silence_ms, 50, 65535, 1000, "ms", "Longest silence",
           "An axis that turns without a frame for this node for this time does what 6007 selects"),
    OD_U32(0x3041, 2, OD_RO, 0, master_objects, stops, 0, U32_HIGHEST, 0, "", "Silent master count",
           "How often an axis has reacted to a silent master since start-up"),
};

const od_table master_objects_table = {kEntries, sizeof kEntries / sizeof kEntries[0]};

static uint16_t seconds_of(uint32_t ticks) { return (uint16_t)((ticks + SERVO_TICKS_PER_S - 1) / SERVO_TICKS_PER_S); }

static od_abort refresh(void *owner, const od_object *object) {
  const master_owner *own = owner;
  (void)object;
  own->objects->lock_left_s = seconds_of(access_lock_ticks_left(own->lock));
  own->objects->lock_has_word = own->lock->hash != 0 ? 1 : 0;
  own->objects->lock_delay_s = seconds_of(access_lock_delay_ticks(own->lock));
  return OD_OK;
}

static od_abort open(access_lock *lock, uint64_t word) {
  if (word == 0) {
    access_lock_close(lock);
    return OD_OK;
  }
  switch (access_lock_open(lock, word)) {
    case ACCESS_OPENED:
      return OD_OK;
    case ACCESS_WRONG_WORD:
      return OD_BAD_VALUE;
    default:
      return OD_DEVICE_STATE;
  }
}

static od_abort set_word(const master_owner *own, uint64_t word) {
  if (!access_lock_is_open(own->lock)) {
    return OD_DEVICE_STATE;
  }
  return own->store_word(own->context, word == 0 ? 0 : access_lock_hash(own->lock, word));
}

static od_abort execute(void *owner, const od_object *object, od_number value) {
  const master_owner *own = owner;
  if (object->entry->index != LOCK) {
    return OD_OK;
  }
  return object->entry->sub == SUB_NEW_WORD ? set_word(own, (uint64_t)value.i) : open(own->lock, (uint64_t)value.i);
}

const od_hooks master_objects_hooks = {.refresh = refresh, .execute = execute};
