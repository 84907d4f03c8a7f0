#include "node/protection_objects.h"

#include "canopen/object_dictionary_rows.h"

#define LIMIT(sub_, member_, low_, high_, default_, unit_, name_, help_)                                          \
  OD_F32(0x2060, sub_, OD_RW, OD_STORED | OD_GUARDED, protection_objects, written.member_, low_, high_, default_, \
         unit_, name_, help_)

_Static_assert(offsetof(protection_objects, written) == 0, "rows are read in a protection_limits alone, too");

static const od_entry kEntries[] = {
    OD_RECORD_HEAD(0x2060, 18, "Protection", "Limits beyond which the axis is in fault; open 0x3040 to write them"),
    LIMIT(1, overspeed_rad_s, 1e-3f, 1e3f, 1.5f, "rad/s", "Over-speed limit", "Of the joint rate"),
    LIMIT(2, base_rate_rad_s, 1e-4f, 1e3f, 0.02f, "rad/s", "Base rate limit",
          "The base turns no faster by itself: gyro and encoder differ by no more (and 2 % of the joint rate)"),
    LIMIT(3, gyro_range_rad_s, 1e-3f, 1e3f, 8.55f, "rad/s", "Gyro range", "Of the data sheet"),
    LIMIT(4, encoder_jump_rad, 1e-6f, 1.0f, 5e-4f, "rad", "Encoder jump limit",
          "Most that the way of one tick differs from that of the tick before"),
    LIMIT(5, stuck_s, 0.0f, 60.0f, 0.1f, "s", "Stuck sensor time",
          "Encoder or gyro readings that are equal for so long are no readings; 0: not watched"),
    LIMIT(6, speed_error_rad_s, 1e-3f, 1e3f, 0.5f, "rad/s", "Speed error limit", "Set-point less rate"),
    LIMIT(7, speed_error_s, 1e-3f, 60.0f, 0.3f, "s", "Speed error time", "The error may last no longer"),
    LIMIT(8, stall_s, 0.01f, 60.0f, 0.5f, "s", "Stall time", "Torque at its limit without motion may last no longer"),
    LIMIT(9, minimum_rad, -200.0f, 200.0f, 0.0f, "rad", "Hard minimum position",
          "End of the travel, which 607D cannot widen; equal to the maximum: not watched"),
    LIMIT(10, maximum_rad, -200.0f, 200.0f, 0.0f, "rad", "Hard maximum position", "As 2060:9"),
    LIMIT(11, continuous_current_a, 1e-3f, 1e4f, 8.0f, "A", "Continuous current", "That the motor bears for ever"),
    LIMIT(12, thermal_time_s, 0.1f, 1e4f, 60.0f, "s", "Thermal time constant", "Of the winding"),
    LIMIT(13, current_offset_a, 1e-4f, 1e4f, 0.5f, "A", "Current offset limit",
          "That the sensor may show of no current"),
    LIMIT(14, voltage_mismatch_v, 0.01f, 1e3f, 4.0f, "V", "Voltage mismatch limit",
          "Between the bridge's voltage and what current and speed explain (and 40 % of R i)"),
    LIMIT(15, under_voltage_v, 1.0f, 1e3f, 36.0f, "V", "Under-voltage limit", "Of the bus, while the axis is driven"),
    LIMIT(16, over_voltage_v, 1.0f, 1e3f, 60.0f, "V", "Over-voltage limit", "Of the bus"),
    LIMIT(17, stopping_margin_rad, 0.0f, 10.0f, 0.005f, "rad", "Stopping margin",
          "Ramps end so far within the hard travel: what the loops overshoot must be less"),
    OD_U8(0x2060, 18, OD_RO, 0, protection_objects, waiting, 0, 7, 0, "", "Waiting limits",
          "Written, contradicting each other, not in force: 1: 2060:15, 16; 2: 2060:9, 10, 17; 4: 607D; summed"),
};

const od_table protection_objects_table = {kEntries, sizeof kEntries / sizeof kEntries[0]};

od_abort guarded_write(const access_lock *lock, const od_entry *entry) {
  return (entry->flags & OD_GUARDED) == 0 || access_lock_is_open(lock) ? OD_OK : OD_DEVICE_STATE;
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
  }
}

const od_hooks protection_objects_hooks = {.refresh = refresh, .accept = accept, .changed = changed};
