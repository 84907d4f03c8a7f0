/* SPDX-License-Identifier: Apache-2.0 */
/* The communication objects 0x1000 to 0x1FFF: the struct of their values, and the rows that all nodes share.
 *
 * Standard: CiA 301 v4.2.0, clause 7.5.2. What differs between devices (identity, default PDO mapping) is a second,
 * short table. The application writes it with the macros at the end of this file. */
#ifndef TRACKSERVO_CANOPEN_COMMUNICATION_PROFILE_H
#define TRACKSERVO_CANOPEN_COMMUNICATION_PROFILE_H

#include "canopen/bus_settings.h"
#include "canopen/cob_id.h"
#include "canopen/emergency.h"
#include "canopen/heartbeat.h"
#include "canopen/object_dictionary.h"
#include "canopen/pdo.h"
#include "canopen/storage.h"
#include "canopen/sync.h"
#include "canopen/sync_clock.h"

enum { SDO_CHANNELS = 2 };

/* 0x1200 and 0x1201: bit 31 of either: off, bits 0..10 identifier. */
/* Longest text of 0x1009. */
enum { CANOPEN_HARDWARE_VERSION = 32 };

typedef struct {
  uint32_t request_cob_id;
  uint32_t response_cob_id;
} sdo_channel;

typedef struct {
  emergency_objects emergency;
  sync_objects sync;
  uint32_t save[STORAGE_GROUPS];    /* always STORAGE_ON_COMMAND: a write is a command */
  uint32_t restore[STORAGE_GROUPS]; /* likewise */
  uint32_t heartbeat_consumer[HEARTBEAT_CONSUMERS];
  uint16_t heartbeat_producer_ms;
  uint32_t serial_number;                          /* 0x1018:4, set by the application */
  char hardware_version[CANOPEN_HARDWARE_VERSION]; /* 0x1009, set by the application */
  uint8_t error_behaviour;                         /* 0x1029:1 */
  sdo_channel sdo[SDO_CHANNELS];
  pdo_communication rpdo[RPDO_COUNT];
  pdo_mapping rpdo_mapping[RPDO_COUNT];
  pdo_communication tpdo[TPDO_COUNT];
  pdo_mapping tpdo_mapping[TPDO_COUNT];
} communication_objects;

/* 0x1029:1, reaction of an operational node to a communication error */
enum { ON_ERROR_PRE_OPERATIONAL = 0, ON_ERROR_NOTHING = 1, ON_ERROR_STOP = 2 };

/* 1001, 1003, 1005, 1006, 1010, 1011, 1014 to 1017, 1019, 1029, 1200, 1201. */
extern const od_table communication_profile_table;

/* --- For the device's table; include object_dictionary_rows.h first. ------------------------------------------ */
/* Member names and string fragments cannot be put in parentheses. NOLINTBEGIN(bugprone-macro-parentheses) */

#define CANOPEN_U32_MAX INT64_C(0xFFFFFFFF)

/* 0x1018:0 to 4; the serial number is communication_objects.serial_number. */
#define CANOPEN_IDENTITY_ROWS(vendor_, product_, revision_)                                                          \
  OD_RECORD_HEAD(0x1018, 4, "Identity", "Vendor, type and serial number of this device."),                           \
      OD_FIXED(OD_UNSIGNED32, 4, 0x1018, 1, 0, vendor_, "Vendor-ID", "Vendor number assigned by CiA; 0: none."),     \
      OD_FIXED(OD_UNSIGNED32, 4, 0x1018, 2, 0, product_, "Product code", "Type of device."),                         \
      OD_FIXED(OD_UNSIGNED32, 4, 0x1018, 3, 0, revision_, "Revision number", "Changes with the object dictionary."), \
      OD_U32(0x1018, 4, OD_RO, 0, communication_objects, serial_number, 0, CANOPEN_U32_MAX, 0, "", "Serial number",  \
             "Distinguishes devices of the same type.")

#define CANOPEN_COB_ID_ROW(index_, member_, cob_id_, name_)                                                            \
  OD_U32(index_, 1, OD_RW, OD_NODE_ID | OD_STORED, communication_objects, member_.cob_id, 0, CANOPEN_U32_MAX, cob_id_, \
         "", name_ " COB-ID", "CAN identifier; bit 31: switched off; bit 30: no remote requests.")

#define CANOPEN_TYPE_ROW(index_, member_, type_, name_)                                      \
  OD_U8(index_, 2, OD_RW, OD_STORED, communication_objects, member_.type, 0, 255, type_, "", \
        name_ " transmission type", "0: at the SYNC after an event; 1 to 240: every n-th SYNC; 254, 255: on event.")

#define CANOPEN_EVENT_ROW(index_, member_, event_ms_, name_, help_)                                       \
  OD_U16(index_, 5, OD_RW, OD_STORED, communication_objects, member_.event_ms, 0, 65535, event_ms_, "ms", \
         name_ " event timer", help_)

/* 0x1400 + n. The default COB-ID is that of the predefined connection set; `off_` is 0 or COB_ID_INVALID. */
#define CANOPEN_RPDO_ROWS(n_, number_, off_, type_, event_ms_)                                                      \
  OD_RECORD_HEAD(0x1400 + (n_), 5, "RPDO" number_ " communication", "When the frame's values take effect."),        \
      CANOPEN_COB_ID_ROW(0x1400 + (n_), rpdo[n_], (int64_t)(off_) + 0x200 + INT64_C(0x100) * (n_), "RPDO" number_), \
      CANOPEN_TYPE_ROW(0x1400 + (n_), rpdo[n_], type_, "RPDO" number_),                                             \
      CANOPEN_EVENT_ROW(0x1400 + (n_), rpdo[n_], event_ms_, "RPDO" number_,                                         \
                        "Longest time without this RPDO before EMCY 8250; 0: not monitored.")

/* 0x1800 + n, for n = 0 .. 3. The default COB-ID is that of the predefined connection set; `off_` as above. */
#define CANOPEN_TPDO_ROWS(n_, number_, off_, type_, inhibit_100us_, event_ms_)                                  \
  CANOPEN_TPDO_RECORD(n_, number_, (int64_t)(off_) + 0x40000180 + INT64_C(0x100) * (n_), type_, inhibit_100us_, \
                      event_ms_)

/* 0x1800 + n, for n = 4 .. 7: off, and without an identifier in the predefined connection set. The default identifiers
 * of nodes 1 to CANOPEN_FURTHER_NODES are the first half of the free range 680h to 6DFh, TPDO5 of all nodes first. */
enum { CANOPEN_FURTHER_FIRST = 0x680, CANOPEN_FURTHER_NODES = 12 };
#define CANOPEN_FURTHER_TPDO_ROWS(n_, number_, type_, inhibit_100us_, event_ms_)                                   \
  CANOPEN_TPDO_RECORD(n_, number_,                                                                                 \
                      (int64_t)(COB_ID_INVALID | COB_ID_NO_REMOTE) + CANOPEN_FURTHER_FIRST - BUS_DEFAULT_NODE_ID + \
                          (int64_t)CANOPEN_FURTHER_NODES * ((n_)-4),                                               \
                      type_, inhibit_100us_, event_ms_)

#define CANOPEN_TPDO_RECORD(n_, number_, cob_id_, type_, inhibit_100us_, event_ms_)                        \
  OD_RECORD_HEAD(0x1800 + (n_), 6, "TPDO" number_ " communication", "When the frame is sent."),            \
      CANOPEN_COB_ID_ROW(0x1800 + (n_), tpdo[n_], cob_id_, "TPDO" number_),                                \
      CANOPEN_TYPE_ROW(0x1800 + (n_), tpdo[n_], type_, "TPDO" number_),                                    \
      OD_U16(0x1800 + (n_), 3, OD_RW, OD_STORED, communication_objects, tpdo[n_].inhibit_100us, 0, 65535,  \
             inhibit_100us_, "100 us", "TPDO" number_ " inhibit time",                                     \
             "Minimum time between two event-driven frames."),                                             \
      CANOPEN_EVENT_ROW(0x1800 + (n_), tpdo[n_], event_ms_, "TPDO" number_,                                \
                        "Maximum time between two event-driven frames; 0: on change only."),               \
      OD_U8(0x1800 + (n_), 6, OD_RW, OD_STORED, communication_objects, tpdo[n_].sync_start, 0, 240, 0, "", \
            "TPDO" number_ " SYNC start value", "SYNC counter value of the first frame; 0: any.")

#define CANOPEN_MAPPING_ROW(index_, member_, sub_, entry_, name_)                                                    \
  OD_U32(index_, sub_, OD_RW, OD_STORED, communication_objects, member_.entry[(sub_)-1], 0, CANOPEN_U32_MAX, entry_, \
         "", name_ " mapped object " #sub_, "Index, sub-index and length in bits: 0xIIIISSLL.")

/* 0x1600 + n with member rpdo_mapping[n], or 0x1A00 + n with tpdo_mapping[n]; `entries` are eight of
 * CANOPEN_MAP(index, sub, bits), or 0. */
#define CANOPEN_MAP(index_, sub_, bits_) ((int64_t)(index_) << 16 | (int64_t)(sub_) << 8 | (bits_))
#define CANOPEN_MAPPING_ROWS(index_, member_, name_, count_, e1_, e2_, e3_, e4_, e5_, e6_, e7_, e8_)            \
  {.index = (index_),                                                                                           \
   .sub = 0,                                                                                                    \
   .type = OD_UNSIGNED8,                                                                                        \
   .access = OD_RW,                                                                                             \
   .flags = OD_RECORD | OD_STORED,                                                                              \
   .bytes = 1,                                                                                                  \
   .offset = OD_OFFSET(communication_objects, member_.count, 1),                                                \
   .low = {.i = 0},                                                                                             \
   .high = {.i = PDO_OBJECTS},                                                                                  \
   .preset = {.i = (count_)},                                                                                   \
   OD_TEXTS(name_ " mapping", "", "Number of mapped objects.")},                                                \
      CANOPEN_MAPPING_ROW(index_, member_, 1, e1_, name_), CANOPEN_MAPPING_ROW(index_, member_, 2, e2_, name_), \
      CANOPEN_MAPPING_ROW(index_, member_, 3, e3_, name_), CANOPEN_MAPPING_ROW(index_, member_, 4, e4_, name_), \
      CANOPEN_MAPPING_ROW(index_, member_, 5, e5_, name_), CANOPEN_MAPPING_ROW(index_, member_, 6, e6_, name_), \
      CANOPEN_MAPPING_ROW(index_, member_, 7, e7_, name_), CANOPEN_MAPPING_ROW(index_, member_, 8, e8_, name_)

/* NOLINTEND(bugprone-macro-parentheses) */

#endif
