#include "node/objects/protection_objects.h"

#include "canopen/object_dictionary_rows.h"

#define LIMIT(sub_, member_, low_, high_, default_, unit_, name_, help_)                                          \
  OD_F32(0x2060, sub_, OD_RW, OD_STORED | OD_GUARDED, protection_objects, written.member_, low_, high_, default_, \
         unit_, name_, help_)

_Static_assert(offsetof(protection_objects, written) == 0, "rows are read in a protection_limits alone, too");

static const od_entry kEntries[] = {
    OD_RECORD_HEAD(0x2060, 18, "Protection", "Limits that trigger a fault; open 0x3040 to write them"),
    LIMIT(1, overspeed_rad_s, 1e-3f, 1e3f, 1.5f, "rad/s", "Over-speed limit", "Largest joint rate"),
    LIMIT(2, base_rate_rad_s, 1e-4f, 1e3f, 0.02f, "rad/s", "Base rate limit",
          "Fastest rotation of the base: largest difference of gyro and encoder rate (plus 2 % of the joint rate)"),
    LIMIT(3, gyro_range_rad_s, 1e-3f, 1e3f, 8.55f, "rad/s", "Gyro range", "Measuring range from the data sheet"),
    LIMIT(4, encoder_jump_rad, 1e-6f, 1.0f, 5e-4f, "rad", "Encoder jump limit",
          "Largest change of the position increment between consecutive ticks"),
    LIMIT(5, stuck_s, 0.0f, 60.0f, 0.1f, "s", "Stuck sensor time",
          "Identical encoder or gyro readings for this time are a fault; 0: not monitored"),
    LIMIT(6, speed_error_rad_s, 1e-3f, 1e3f, 0.5f, "rad/s", "Speed error limit",
          "Largest difference between set-point and rate"),
    LIMIT(7, speed_error_s, 1e-3f, 60.0f, 0.3f, "s", "Speed error time", "Longest time above the speed error limit"),
    LIMIT(8, stall_s, 0.01f, 60.0f, 0.5f, "s", "Stall time", "Longest time at the torque limit without motion"),
    LIMIT(9, minimum_rad, -200.0f, 200.0f, 0.0f, "rad", "Hard minimum position",
          "Lower end of the travel; 607D cannot extend it; equal to 2060:10: not monitored"),
    LIMIT(10, maximum_rad, -200.0f, 200.0f, 0.0f, "rad", "Hard maximum position",
          "Upper end of the travel, see 2060:9"),
    LIMIT(11, continuous_current_a, 1e-3f, 1e4f, 8.0f, "A", "Continuous current",
          "Current that the motor can carry continuously"),
    LIMIT(12, thermal_time_s, 0.1f, 1e4f, 60.0f, "s", "Thermal time constant", "Thermal time constant of the winding"),
    LIMIT(13, current_offset_a, 1e-4f, 1e4f, 0.5f, "A", "Current offset limit",
          "Largest reading of the current sensor without current"),
    LIMIT(14, voltage_mismatch_v, 0.01f, 1e3f, 4.0f, "V", "Voltage mismatch limit",
          "Largest difference between bridge voltage and R i + Ke w (plus 40 % of R i)"),
    LIMIT(15, under_voltage_v, 1.0f, 1e3f, 36.0f, "V", "Under-voltage limit",
          "Lowest bus voltage while a control loop is closed"),
    LIMIT(16, over_voltage_v, 1.0f, 1e3f, 60.0f, "V", "Over-voltage limit", "Highest bus voltage"),
    LIMIT(17, stopping_margin_rad, 0.0f, 10.0f, 0.005f, "rad", "Stopping margin",
          "Ramps stop this far inside 2060:9 and 2060:10; must exceed the overshoot of the loops"),
    OD_U8(0x2060, 18, OD_RO, 0, protection_objects, waiting, 0, 7, 0, "", "Waiting limits",
          "Sum of the limits written but not active because they contradict each other: 1: 2060:15, 16; 2: 2060:9, 10, "
          "17; 4: 607D"),
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
