/* SPDX-License-Identifier: Apache-2.0 */
#include "node/shared_dictionary.h"

#include "canopen/object_dictionary_rows.h"
#include "node/servo_node.h"

#define U32_HIGHEST INT64_C(0xFFFFFFFF)

static const od_entry kEntries[] = {
    OD_RECORD_HEAD(0x3010, 1, "Timing", "Timing of the control task"),
    OD_U32(0x3010, 1, OD_RO, OD_TPDO, servo_node_objects, ticks, 0, U32_HIGHEST, 0, "ms", "Ticks since start",
           "Counts the 1 ms ticks and wraps"),
    OD_RECORD_HEAD(0x3030, 3, "Version", "Version of firmware and object dictionary"),
    OD_FIXED_TEXT(0x3030, 1, TRACKSERVO_VERSION, "Firmware version", "For information; tools compare 3030:2 instead"),
    OD_U32(0x3030, 2, OD_RO, 0, servo_node_objects, schema_hash, 0, U32_HIGHEST, 0, "", "Schema hash",
           "CRC-32 of all objects without their texts: equal hashes mean equal dictionaries"),
    OD_FIXED_TEXT(0x3030, 3, TRACKSERVO_GIT, "Source version", "Commit from which the firmware was built"),
    OD_RECORD_HEAD(0x3031, 7, "Stored set", "Parameter set that 0x1010 stored last, as found at start-up"),
    OD_U8(0x3031, 1, OD_RO, 0, servo_node_objects, persisted_set.source, 0, 4, 0, "", "Stored set source",
          "Active values: 0: defaults; 1: the set in flash; 2: a set of another version; 3: an older set, a newer one "
          "may be lost; 4: defaults, all sets are lost"),
    OD_U32(0x3031, 2, OD_RO, 0, servo_node_objects, persisted_set.sequence, 0, U32_HIGHEST, 0, "", "Stored set number",
           "Counts all saves; 0: nothing stored"),
    OD_U8(0x3031, 3, OD_RO, 0, servo_node_objects, persisted_set.damaged, 0, 255, 0, "", "Damaged sets",
          "Skipped because of a wrong CRC"),
    OD_U8(0x3031, 4, OD_RO, 0, servo_node_objects, persisted_set.unfinished, 0, 255, 0, "", "Unfinished sets",
          "Skipped because power failed while they were stored"),
    OD_U8(0x3031, 5, OD_RO, 0, servo_node_objects, persisted_set.refused, 0, 255, 0, "", "Refused sets",
          "Skipped because values are out of range or inconsistent"),
    OD_U16(0x3031, 6, OD_RO, 0, servo_node_objects, persisted_set.dropped, 0, 65535, 0, "", "Dropped values",
           "Values in another version's set for objects that do not exist here"),
    OD_U16(0x3031, 7, OD_RO, 0, servo_node_objects, persisted_set.missing, 0, 65535, 0, "", "Missing values",
           "Objects missing from another version's set; they have their defaults"),
    OD_RECORD_HEAD(0x3050, 4, "Bus settings", "Node id and bit rate, set by LSS"),
    OD_U8(0x3050, 1, OD_RO, 0, servo_node_objects, bus.in_force.node_id, 1, 255, 1, "", "Node id in force",
          "255: no node id, the node answers LSS only"),
    OD_U16(0x3050, 2, OD_RO, 0, servo_node_objects, bus.in_force.kbit_s, 125, 1000, 1000, "kbit/s", "Bit rate in force",
           "125, 250, 500 or 1000"),
    OD_U8(0x3050, 3, OD_RO, 0, servo_node_objects, bus.stored.node_id, 1, 255, 1, "", "Stored node id",
          "Active from the next start-up; 255: none"),
    OD_U16(0x3050, 4, OD_RO, 0, servo_node_objects, bus.stored.kbit_s, 125, 1000, 1000, "kbit/s", "Stored bit rate",
           "Active from the next start-up"),
    OD_RECORD_HEAD(0x3061, 1, "Board state", "What the board reads back of its safety functions"),
    OD_U32(0x3061, 1, OD_RO, OD_TPDO, servo_node_objects, board_status, 0, U32_HIGHEST, 0, "", "Board status",
           "Sum: 1, 2: STO channels A, B permit torque; 4, 8: azimuth, pitch brake released; 16: RAM parity on; 32: "
           "program write-protected; 64: flash read-protected; 128: flash with the right banks"),
};

const od_table shared_table = {kEntries, sizeof kEntries / sizeof kEntries[0]};
