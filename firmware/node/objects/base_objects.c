/* SPDX-License-Identifier: Apache-2.0 */
#include "node/objects/base_objects.h"

#include "canopen/object_dictionary_rows.h"

enum { MESSAGE_OBJECT = 0x3076, MESSAGE_COUNTER = 4, SETTING_OBJECT = 0x3077, SETTING_SCALE = 2 };
enum { LONGEST_DELAY = 50 * BASE_TIMES_PER_TICK };

#define U32_HIGHEST INT64_C(0xFFFFFFFF)

#define TAKES(kind_, sub_, member_, low_, high_, unit_, name_, help_) \
  kind_(0x3076, sub_, OD_RW, OD_RPDO, base_objects, message.member_, low_, high_, 0, unit_, name_, help_)
#define SETS(kind_, sub_, member_, low_, high_, preset_, unit_, name_, help_) \
  kind_(0x3077, sub_, OD_RW, OD_STORED, base_objects, params.member_, low_, high_, preset_, unit_, name_, help_)
#define REPORTS(kind_, sub_, member_, low_, high_, unit_, name_, help_) \
  kind_(0x3078, sub_, OD_RO, OD_TPDO, base_objects, member_, low_, high_, 0, unit_, name_, help_)

static const od_entry kEntries[] = {
    OD_RECORD_HEAD(0x3076, 4, "Base rates",
                   "What an inertial sensor on the vehicle or ship measures, in the axes of the base on which the "
                   "azimuth stands; map all four into one RPDO"),
    TAKES(OD_I16, 1, x, INT16_MIN, INT16_MAX, "3077:2", "Base rate x",
          "About the axis ahead, to which the azimuth's angle 0 points, right-handed; -32768: not measured"),
    TAKES(OD_I16, 2, y, INT16_MIN, INT16_MAX, "3077:2", "Base rate y", "About the axis to the left; as 3076:1"),
    TAKES(OD_I16, 3, z, INT16_MIN, INT16_MAX, "3077:2", "Base rate z",
          "About the axis up, about which the azimuth turns; as 3076:1"),
    TAKES(OD_U8, 4, counter, 0, 255, "", "Base rates counter",
          "One more with each message, 255 is followed by 0; writing it hands the message over"),
    OD_RECORD_HEAD(0x3077, 6, "Base rates setting", "How the numbers of 3076 are meant"),
    SETS(OD_U8, 1, use, 0, 1, 0, "", "Base rates in use",
         "1: each axis adds to its rate what its own sensors do not see of the base's motion, if 2060:27 is 0"),
    SETS(OD_F32, 2, scale_rad_s, 1e-7f, 1e-3f, 2e-5f, "rad/s", "Base rate scale", "Rate of one count of 3076:1 to :3"),
    SETS(OD_U16, 3, delay, 0, LONGEST_DELAY, 0, "1e-5 s", "Base rates delay",
         "From the measurement to the arrival of its message"),
    SETS(OD_F32, 4, largest_rad_s, 0.01f, 10.0f, 0.5f, "rad/s", "Base rate limit",
         "A message with a larger rate does not count"),
    SETS(OD_F32, 5, bandwidth_rad_s, 1.0f, 500.0f, 100.0f, "rad/s", "Base rates bandwidth",
         "Of the filter between two messages"),
    SETS(OD_U16, 6, timeout_ms, 10, 2000, 100, "ms", "Base rates time-out",
         "Without a message for this time nothing is added any more"),
    OD_RECORD_HEAD(0x3078, 6, "Base rates report", "What became of the base rates"),
    OD_U8(0x3078, 1, OD_RO, OD_TPDO | OD_EVENT, base_objects, state, 0, 4, 0, "", "Base rates state",
          "0: not used; 1: no message yet; 2: in use; 3: the messages have ended, see 3077:6; 4: 2060:27 of an axis "
          "declares the base fixed, that axis uses none; 0 to 3 are of both axes"),
    REPORTS(OD_U32, 2, taken, 0, U32_HIGHEST, "", "Base rates taken", "Messages that counted"),
    REPORTS(OD_U32, 3, dropped, 0, U32_HIGHEST, "", "Base rates dropped", "Messages that did not count, see 3078:4"),
    REPORTS(OD_U8, 4, last_drop, 0, 4, "", "Base rates last drop",
            "Why: 0: none dropped; 1: the counter of the last message; 2: a rate above 3077:4; 3: a rate not measured; "
            "4: another one came within 4 ms"),
    REPORTS(OD_F32, 5, added_azimuth_rad_s, -1e3f, 1e3f, "rad/s", "Base rate added, azimuth",
            "To the rate of the azimuth's own sensors"),
    REPORTS(OD_F32, 6, added_pitch_rad_s, -1e3f, 1e3f, "rad/s", "Base rate added, pitch",
            "To the rate of the pitch's own sensors"),
};

const od_table base_objects_table = {kEntries, sizeof kEntries / sizeof kEntries[0]};

bool base_objects_hand_over(const od_object *object) {
  return object->entry->index == MESSAGE_OBJECT && object->entry->sub == MESSAGE_COUNTER;
}

bool base_objects_sets_scale(const od_object *object) {
  return object->entry->index == SETTING_OBJECT && object->entry->sub == SETTING_SCALE;
}
