/* SPDX-License-Identifier: Apache-2.0 */
#include "node/objects/board_objects.h"

#include "base/scalar.h"
#include "canopen/object_dictionary_rows.h"

#define MIN_CURRENT_A 0.1f
#define MAX_CURRENT_A 1000.0f
#define MIN_THRESHOLD_A 0.05f
#define MIN_VOLTAGE_V 5.0f
#define MAX_VOLTAGE_V 1000.0f

#define SCALE(sub_, member_, low_, high_, default_, unit_, name_, help_) \
  OD_F32(0x3060, sub_, OD_RW, OD_STORED | OD_GUARDED, hal_scales, member_, low_, high_, default_, unit_, name_, help_)

static const od_entry kEntries[] = {
    OD_RECORD_HEAD(0x3060, 5, "Board",
                   "Scales of the current and voltage sensors; to write: open 0x3040 and switch both axes off"),
    SCALE(1, current_full_scale_a[0], MIN_CURRENT_A, MAX_CURRENT_A, 25.0f, "A", "Current full scale of azimuth",
          "Current at both ends of the sensor's range; the middle is 0 A"),
    SCALE(2, current_full_scale_a[1], MIN_CURRENT_A, MAX_CURRENT_A, 25.0f, "A", "Current full scale of pitch",
          "See 3060:1"),
    SCALE(3, over_current_a[0], MIN_THRESHOLD_A, MAX_CURRENT_A, 25.0f, "A", "Over-current threshold of azimuth",
          "Above it, and at full scale, the bridge is switched off within a PWM period (2310); set it above 2055:6"),
    SCALE(4, over_current_a[1], MIN_THRESHOLD_A, MAX_CURRENT_A, 25.0f, "A", "Over-current threshold of pitch",
          "See 3060:3; for pitch the current limit is 2855:6"),
    SCALE(5, voltage_full_scale_v, MIN_VOLTAGE_V, MAX_VOLTAGE_V, 66.0f, "V", "Bus voltage full scale",
          "Voltage at the upper end of the divider's range"),
};

const od_table board_objects_table = {kEntries, sizeof kEntries / sizeof kEntries[0]};

control_status board_objects_check(const hal_scales *scales) {
  const scalar_range ranges[] = {
      {scales->current_full_scale_a[0], MIN_CURRENT_A, MAX_CURRENT_A},
      {scales->current_full_scale_a[1], MIN_CURRENT_A, MAX_CURRENT_A},
      {scales->over_current_a[0], MIN_THRESHOLD_A, MAX_CURRENT_A},
      {scales->over_current_a[1], MIN_THRESHOLD_A, MAX_CURRENT_A},
      {scales->voltage_full_scale_v, MIN_VOLTAGE_V, MAX_VOLTAGE_V},
  };
  return scalar_check_ranges(ranges, (int)(sizeof ranges / sizeof ranges[0]));
}
