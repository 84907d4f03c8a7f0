#include "node/shared_dictionary.h"

#include "canopen/object_dictionary_rows.h"
#include "node/servo_node.h"

#define U32_HIGHEST INT64_C(0xFFFFFFFF)

static const od_entry kEntries[] = {
    OD_RECORD_HEAD(0x3010, 1, "Timing", "Of the control task"),
    OD_U32(0x3010, 1, OD_RO, OD_TPDO, servo_node_objects, ticks, 0, U32_HIGHEST, 0, "ms", "Ticks since start",
           "Counts every 1 ms tick, wraps"),
    OD_RECORD_HEAD(0x3030, 3, "Version", "What runs here"),
    OD_FIXED_TEXT(0x3030, 1, "0.1.0", "Firmware version", "For people"),
    OD_U32(0x3030, 2, OD_RO, 0, servo_node_objects, schema_hash, 0, U32_HIGHEST, 0, "", "Schema hash",
           "CRC-32 over all objects but their texts: equal hashes mean equal dictionaries"),
    OD_FIXED_TEXT(0x3030, 3, TRACKSERVO_GIT, "Source version", "Commit that the firmware was built from"),
    OD_RECORD_HEAD(0x3031, 7, "Stored set", "What 0x1010 stored last, as it was found at the start"),
    OD_U8(0x3031, 1, OD_RO, 0, servo_node_objects, stored_set.source, 0, 4, 0, "", "Stored set source",
          "0: defaults; 1: stored; 2: of another version; 3: a newer one may be lost; 4: defaults, all are lost"),
    OD_U32(0x3031, 2, OD_RO, 0, servo_node_objects, stored_set.sequence, 0, U32_HIGHEST, 0, "", "Stored set number",
           "Counts all saves; 0: nothing is stored"),
    OD_U8(0x3031, 3, OD_RO, 0, servo_node_objects, stored_set.damaged, 0, 255, 0, "", "Damaged sets",
          "Skipped since their CRC is wrong"),
    OD_U8(0x3031, 4, OD_RO, 0, servo_node_objects, stored_set.unfinished, 0, 255, 0, "", "Unfinished sets",
          "Skipped since the power failed while they were stored"),
    OD_U8(0x3031, 5, OD_RO, 0, servo_node_objects, stored_set.refused, 0, 255, 0, "", "Refused sets",
          "Skipped since values are out of range or do not fit together"),
    OD_U16(0x3031, 6, OD_RO, 0, servo_node_objects, stored_set.dropped, 0, 65535, 0, "", "Dropped values",
           "Of another version's set: objects that are not here"),
    OD_U16(0x3031, 7, OD_RO, 0, servo_node_objects, stored_set.missing, 0, 65535, 0, "", "Missing values",
           "Of another version's set: objects that it did not have, at their defaults"),
    OD_RECORD_HEAD(0x3050, 4, "Bus settings", "Node id and bit rate, as LSS sets them"),
    OD_U8(0x3050, 1, OD_RO, 0, servo_node_objects, bus.in_force.node_id, 1, 255, 1, "", "Node id in force",
          "255: none, only LSS is answered"),
    OD_U16(0x3050, 2, OD_RO, 0, servo_node_objects, bus.in_force.kbit_s, 125, 1000, 1000, "kbit/s", "Bit rate in force",
           "125, 250, 500 or 1000"),
    OD_U8(0x3050, 3, OD_RO, 0, servo_node_objects, bus.stored.node_id, 1, 255, 1, "", "Stored node id",
          "In force from the next start on; 255: none"),
    OD_U16(0x3050, 4, OD_RO, 0, servo_node_objects, bus.stored.kbit_s, 125, 1000, 1000, "kbit/s", "Stored bit rate",
           "In force from the next start on"),
};

const od_table shared_table = {kEntries, sizeof kEntries / sizeof kEntries[0]};
