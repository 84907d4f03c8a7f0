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
           "CRC-32 over all objects: equal hashes mean equal dictionaries"),
    OD_FIXED_TEXT(0x3030, 3, TRACKSERVO_GIT, "Source version", "Commit that the firmware was built from"),
};

const od_table shared_table = {kEntries, sizeof kEntries / sizeof kEntries[0]};
