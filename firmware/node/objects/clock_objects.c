/* SPDX-License-Identifier: Apache-2.0 */
#include "node/objects/clock_objects.h"

#include "canopen/object_dictionary_rows.h"

static const od_entry kEntries[] = {
    OD_U32(
        0x1013, 0, OD_RW, OD_RPDO | OD_TPDO, clock_objects, time_us, 0, INT64_C(0xFFFFFFFF), 0, "us",
        "High resolution time stamp",
        "The node's clock, to which exposures of the camera refer; a write sets it to the time of the frame's start"),
};

const od_table clock_objects_table = {kEntries, sizeof kEntries / sizeof kEntries[0]};
