/* SPDX-License-Identifier: Apache-2.0 */
#include "node/objects/protection_objects.h"

#include "canopen/object_dictionary_rows.h"

enum { ENVELOPE_OBJECT = 0x2061, CONFIRMED_TURN = 5 };

#define ROW(sub_, member_, low_, high_, default_, unit_, name_, help_)                                            \
  OD_F32(0x2060, sub_, OD_RW, OD_STORED | OD_GUARDED, protection_objects, written.member_, low_, high_, default_, \
         unit_, name_, help_),

_Static_assert(offsetof(protection_objects, written) == 0, "rows are read in a protection_limits alone, too");

static const od_entry kEntries[] = {
    OD_RECORD_HEAD(0x2060, 32, "Protection", "Limits that trigger a fault; open 0x3040 to write them"),
    /* clang-format off */
    PROTECTION_LIMITS_1_TO_17(ROW)
    /* clang-format on */
    OD_U8(0x2060, 18, OD_RO, 0, protection_objects, waiting, 0, 7, 0, "", "Waiting limits",
          "Sum of the limits written but not active because they contradict each other: 1: 2060:15, 16; 2: 2060:9, 10, "
          "17; 4: 607D"),
    /* clang-format off */
    PROTECTION_LIMITS_FROM_19(ROW)
    /* clang-format on */
    OD_RECORD_HEAD(0x2061, 7, "Envelope", "How fast the axis may be, and in which turn it started"),
    OD_U8(0x2061, 1, OD_RO, OD_TPDO, protection_objects, restrictions, 0, 7, 0, "", "Restrictions",
          "Sum: 1: 2060:9 and 2060:10 limit no travel, so the axis is not enabled (2060:21); 2: the turn is not known, "
          "at most 5 deg/s, pp and csp wait (2061:5); 4: commissioning, at most 5 deg/s"),
    OD_I8(0x2061, 2, OD_RO, 0, protection_objects, turn, INT8_MIN, INT8_MAX, 0, "", "Start turn",
          "Turns added to the angle that was counted from the start"),
    OD_I8(0x2061, 3, OD_RO, 0, protection_objects, lowest_turn, INT8_MIN, INT8_MAX, 0, "", "Lowest start turn",
          "Lowest turn that the travel and the motion since the start allow"),
    OD_I8(0x2061, 4, OD_RO, 0, protection_objects, highest_turn, INT8_MIN, INT8_MAX, 0, "", "Highest start turn",
          "Highest one; below the lowest: the angle is outside of the travel in every turn"),
    OD_I8(0x2061, 5, OD_RW, OD_GUARDED, protection_objects, confirmed_turn, -START_POSITION_MAX_TURN,
          START_POSITION_MAX_TURN, 0, "", "Confirmed start turn",
          "Write the turn that you have seen the axis to be in, from 2061:3 to 2061:4, while the axis is off"),
    OD_F32(0x2061, 6, OD_RO, OD_TPDO, protection_objects, fastest_down_rad_s, 0.0f, 1e4f, 0.0f, "rad/s",
           "Fastest rate downwards", "Beyond it towards 2060:9 protection brakes"),
    OD_F32(0x2061, 7, OD_RO, OD_TPDO, protection_objects, fastest_up_rad_s, 0.0f, 1e4f, 0.0f, "rad/s",
           "Fastest rate upwards", "Beyond it towards 2060:10 protection brakes"),
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

static bool is_confirmation(const od_object *object) {
  return object->entry->index == ENVELOPE_OBJECT && object->entry->sub == CONFIRMED_TURN;
}

/* One of the possible turns, or any if none is possible. The lock is closed to an axis with power: its position must
 * not jump. */
static od_abort accept_turn(const protection_objects *objects, int64_t turn) {
  const bool any = objects->lowest_turn > objects->highest_turn;
  return any || (turn >= objects->lowest_turn && turn <= objects->highest_turn) ? OD_OK : OD_BAD_VALUE;
}

static od_abort accept(void *owner, const od_object *object, od_number value) {
  const protection_owner *own = owner;
  const od_abort guarded = guarded_write(own->lock, object->entry);
  return guarded == OD_OK && is_confirmation(object) ? accept_turn(own->objects, value.i) : guarded;
}

static od_abort execute(void *owner, const od_object *object, od_number value) {
  const protection_owner *own = owner;
  if (is_confirmation(object)) {
    start_position_confirm(own->start, (int8_t)value.i);
  }
  return OD_OK;
}

static void changed(void *owner, const od_object *object) {
  (void)object;
  const protection_owner *own = owner;
  if (protection_check(&own->objects->written) == CONTROL_OK) {
    *own->in_force = own->objects->written;
    own->objects->changes++;
  }
}

const od_hooks protection_objects_hooks = {
    .refresh = refresh, .accept = accept, .execute = execute, .changed = changed};
