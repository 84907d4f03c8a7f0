#include "node/objects/protection_objects.h"

#include "canopen/object_dictionary_rows.h"

#define ROW(sub_, member_, low_, high_, default_, unit_, name_, help_)                                            \
  OD_F32(0x2060, sub_, OD_RW, OD_STORED | OD_GUARDED, protection_objects, written.member_, low_, high_, default_, \
         unit_, name_, help_),

_Static_assert(offsetof(protection_objects, written) == 0, "rows are read in a protection_limits alone, too");

static const od_entry kEntries[] = {
    OD_RECORD_HEAD(0x2060, 31, "Protection", "Limits that trigger a fault; open 0x3040 to write them"),
    /* clang-format off */
    PROTECTION_LIMITS_1_TO_17(ROW)
    /* clang-format on */
    OD_U8(0x2060, 18, OD_RO, 0, protection_objects, waiting, 0, 7, 0, "", "Waiting limits",
          "Sum of the limits written but not active because they contradict each other: 1: 2060:15, 16; 2: 2060:9, 10, "
          "17; 4: 607D"),
    /* clang-format off */
    PROTECTION_LIMITS_FROM_19(ROW)
    /* clang-format on */
    OD_U8(0x2062, 0, OD_RW, 0, protection_objects, reduced_speed, 0, 1, 0, "", "Reduced speed",
          "1: from 1 s after the write on, a joint rate above 2060:30 is a fault; 0: not monitored"),
};

const od_table protection_objects_table = {kEntries, sizeof kEntries / sizeof kEntries[0]};

od_abort guarded_change(const access_lock *lock) {
  return access_lock_is_open(lock) && !lock->powered ? OD_OK : OD_DEVICE_STATE;
}

od_abort guarded_write(const access_lock *lock, const od_entry *entry) {
  return (entry->flags & OD_GUARDED) == 0 ? OD_OK : guarded_change(lock);
}

uint8_t protection_objects_waiting(const protection_owner *own) {
  const bool soft = own->drive->position_minimum > own->drive->position_maximum;
  return (uint8_t)(protection_contradictions(&own->objects->written) | (soft ? PROTECTION_SOFT_TRAVEL : 0));
}

static od_abort refresh(void *owner, const od_object *object) {
  (void)object;
  const protection_owner *own = owner;
  own->objects->waiting = protection_objects_waiting(own);
  return OD_OK;
}

static od_abort accept(void *owner, const od_object *object, od_number value) {
  (void)value;
  return guarded_write(((const protection_owner *)owner)->lock, object->entry);
}

static void changed(void *owner, const od_object *object) {
  (void)object;
  const protection_owner *own = owner;
  if (protection_check(&own->objects->written) == CONTROL_OK) {
    *own->in_force = own->objects->written;
    own->objects->changes++;
  }
}

const od_hooks protection_objects_hooks = {.refresh = refresh, .accept = accept, .changed = changed};
