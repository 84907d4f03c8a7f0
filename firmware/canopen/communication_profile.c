/* SPDX-License-Identifier: Apache-2.0 */
#include "canopen/communication_profile.h"

#include "canopen/cob_id.h"
#include "canopen/object_dictionary_rows.h"

#define OBJECTS communication_objects

#define HISTORY_ROW(sub_)                                                                                         \
  OD_U32(0x1003, sub_, OD_RO, 0, OBJECTS, emergency.history[(sub_)-1], 0, CANOPEN_U32_MAX, 0, "", "Error " #sub_, \
         "Bits 0 to 15: error code; bits 16 to 31: detail; error 1 is the newest.")

#define CONSUMER_ROW(sub_)                                                                          \
  OD_U32(0x1016, sub_, OD_RW, OD_STORED, OBJECTS, heartbeat_consumer[(sub_)-1], 0, 0x7FFFFF, 0, "", \
         "Consumer heartbeat time " #sub_, "Node id << 16 | longest time between heartbeats in ms; 0: not monitored.")

/* NOLINTBEGIN(bugprone-macro-parentheses): a member name cannot be put in parentheses. */
#define STORAGE_ROW(index_, sub_, member_, name_, help_) \
  OD_U32(index_, sub_, OD_RW, 0, OBJECTS, member_[(sub_)-1], 0, CANOPEN_U32_MAX, STORAGE_ON_COMMAND, "", name_, help_)
/* NOLINTEND(bugprone-macro-parentheses) */

static const od_entry rows[] = {
    OD_U8(0x1001, 0, OD_RO, OD_TPDO | OD_EVENT, OBJECTS, emergency.error_register, 0, 255, 0, "", "Error register",
          "Active error types: bit 0 any, 1 current, 2 voltage, 3 temperature, 4 communication."),

    {.index = 0x1003,
     .sub = 0,
     .type = OD_UNSIGNED8,
     .access = OD_RW,
     .flags = OD_RECORD | OD_ARRAY,
     .bytes = 1,
     .offset = OD_OFFSET(OBJECTS, emergency.count, 1),
     .low = {.i = 0},
     .high = {.i = EMERGENCY_HISTORY},
     .preset = {.i = 0},
     OD_TEXTS("Error history", "", "Number of errors in the history; write 0 to clear it.")},
    HISTORY_ROW(1),
    HISTORY_ROW(2),
    HISTORY_ROW(3),
    HISTORY_ROW(4),
    HISTORY_ROW(5),
    HISTORY_ROW(6),
    HISTORY_ROW(7),
    HISTORY_ROW(8),

    OD_U32(0x1005, 0, OD_RW, OD_STORED, OBJECTS, sync.cob_id, 0, CANOPEN_U32_MAX, 0x80, "", "SYNC COB-ID",
           "CAN identifier of the SYNC that this node uses."),
    OD_U32(
        0x1006, 0, OD_RW, OD_STORED, OBJECTS, sync.period_us, 0, CANOPEN_U32_MAX, 0, "us", "Communication cycle period",
        "Expected SYNC period; EMCY 8700 after 1.5 periods without SYNC, 8701 when it differs from the node's clock by "
        "1 %; 0: not monitored."),

    OD_ARRAY_HEAD(0x1010, STORAGE_GROUPS, "Store parameters", "Write \"save\" (0x65766173) to store."),
    STORAGE_ROW(0x1010, 1, save, "Store all parameters", "Stores all objects that can be stored."),
    STORAGE_ROW(0x1010, 2, save, "Store communication parameters", "Stores objects 1000 to 1FFF."),
    STORAGE_ROW(0x1010, 3, save, "Store application parameters", "Stores all other objects."),
    OD_ARRAY_HEAD(0x1011, STORAGE_GROUPS, "Restore default parameters", "Write \"load\" (0x64616F6C), then reset."),
    STORAGE_ROW(0x1011, 1, restore, "Restore all default parameters", "Restores all objects that can be stored."),
    STORAGE_ROW(0x1011, 2, restore, "Restore communication default parameters", "Restores objects 1000 to 1FFF."),
    STORAGE_ROW(0x1011, 3, restore, "Restore application default parameters", "Restores all other objects."),

    OD_U32(0x1014, 0, OD_RW, OD_NODE_ID | OD_STORED, OBJECTS, emergency.cob_id, 0, CANOPEN_U32_MAX, 0x80, "",
           "EMCY COB-ID", "CAN identifier of emergency messages; bit 31: switched off."),
    OD_U16(0x1015, 0, OD_RW, OD_STORED, OBJECTS, emergency.inhibit_100us, 0, 65535, 0, "100 us", "EMCY inhibit time",
           "Minimum time between two emergency messages."),

    OD_ARRAY_HEAD(0x1016, HEARTBEAT_CONSUMERS, "Consumer heartbeat time", "Nodes whose heartbeat is monitored."),
    CONSUMER_ROW(1),
    CONSUMER_ROW(2),
    CONSUMER_ROW(3),
    CONSUMER_ROW(4),
    OD_U16(0x1017, 0, OD_RW, OD_STORED, OBJECTS, heartbeat_producer_ms, 0, 65535, 100, "ms", "Producer heartbeat time",
           "Heartbeat period; 0: no heartbeats."),

    OD_U8(0x1019, 0, OD_RW, OD_STORED, OBJECTS, sync.overflow, 0, 240, 0, "", "Synchronous counter overflow value",
          "Highest value of the SYNC counter; 0: SYNC without counter."),
    OD_ARRAY_HEAD(0x1029, 1, "Error behaviour", "Reaction of the NMT state to errors."),
    OD_U8(0x1029, 1, OD_RW, OD_STORED, OBJECTS, error_behaviour, 0, 2, ON_ERROR_PRE_OPERATIONAL, "",
          "Communication error", "0: change to pre-operational; 1: no change; 2: change to stopped."),

    OD_RECORD_HEAD(0x1200, 2, "SDO server parameter", "Access to this object dictionary."),
    OD_U32(0x1200, 1, OD_RO, OD_NODE_ID, OBJECTS, sdo[0].request_cob_id, 0, CANOPEN_U32_MAX, 0x600, "",
           "SDO COB-ID client to server", "CAN identifier of requests."),
    OD_U32(0x1200, 2, OD_RO, OD_NODE_ID, OBJECTS, sdo[0].response_cob_id, 0, CANOPEN_U32_MAX, 0x580, "",
           "SDO COB-ID server to client", "CAN identifier of responses."),
    OD_RECORD_HEAD(0x1201, 2, "Second SDO server parameter", "Access for a second client; off by default."),
    OD_U32(0x1201, 1, OD_RW, OD_STORED, OBJECTS, sdo[1].request_cob_id, 0, CANOPEN_U32_MAX, COB_ID_INVALID, "",
           "Second SDO COB-ID client to server", "CAN identifier of requests; bit 31: channel off."),
    OD_U32(0x1201, 2, OD_RW, OD_STORED, OBJECTS, sdo[1].response_cob_id, 0, CANOPEN_U32_MAX, COB_ID_INVALID, "",
           "Second SDO COB-ID server to client", "CAN identifier of responses; bit 31: channel off."),
};

const od_table communication_profile_table = {rows, sizeof rows / sizeof rows[0]};
